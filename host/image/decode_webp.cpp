// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <webp/decode.h>

#include <new>

#include "core/error.h"
#include "image/decode_picture.h"

namespace eikon {
namespace {

const std::uint8_t* data_of(std::span<const std::byte> bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

[[noreturn]] void refuse(VP8StatusCode status) {
  if (status == VP8_STATUS_OUT_OF_MEMORY) throw std::bad_alloc();
  const bool cut = status == VP8_STATUS_NOT_ENOUGH_DATA || status == VP8_STATUS_SUSPENDED;
  throw InputError(fmt::format("is a {} WebP; copy or export it again", cut ? "truncated" : "damaged"));
}

}  // namespace

PictureHeader webp_header(std::span<const std::byte> bytes) {
  WebPBitstreamFeatures features;
  if (const VP8StatusCode status = WebPGetFeatures(data_of(bytes), bytes.size(), &features); status != VP8_STATUS_OK)
    refuse(status);
  if (features.has_animation != 0)
    throw InputError("is an animated WebP; save one picture of it (`webpmux -get frame 1`)");
  if (features.width < 1 || features.height < 1) throw InputError("is a WebP of no pixels: damaged");
  PictureHeader header{.format = PictureFormat::webp,
                       .width = static_cast<std::uint32_t>(features.width),
                       .height = static_cast<std::uint32_t>(features.height)};
  // The lossless decoder keeps a whole picture of its own, the lossy one only a plane of alpha.
  constexpr int kLossy = 1;
  const std::uint64_t bytes_per_pixel = features.format != kLossy ? 4 : features.has_alpha != 0 ? 2 : 0;
  header.scratch_bytes = bytes_per_pixel * header.width * header.height;
  return header;
}

void decode_webp(std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8) {
  WebPDecoderConfig config;
  if (WebPInitDecoderConfig(&config) == 0)
    throw InputError("is a WebP, but libwebp is not the one eikon was built for");
  config.output.colorspace = MODE_RGBA;
  config.output.is_external_memory = 1;
  config.output.u.RGBA.rgba = reinterpret_cast<std::uint8_t*>(rgba8);
  config.output.u.RGBA.stride = static_cast<int>(header.width * sizeof(std::uint32_t));
  config.output.u.RGBA.size = std::size_t{header.width} * header.height * sizeof(std::uint32_t);
  const VP8StatusCode status = WebPDecode(data_of(bytes), bytes.size(), &config);
  WebPFreeDecBuffer(&config.output);
  if (status != VP8_STATUS_OK) refuse(status);
}

}  // namespace eikon
