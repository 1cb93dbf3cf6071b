// SPDX-License-Identifier: Apache-2.0
#include "image/decode_picture.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <string_view>

#include "core/error.h"

namespace eikon {
namespace {

static_assert(std::endian::native == std::endian::little, "decoders write R, G, B, A as bytes");

constexpr std::uint64_t kMaxPictureSide = 65536, kMaxPixels = std::uint64_t{1} << 28U;

struct Magic {
  PictureFormat format;
  std::size_t offset;
  std::string_view bytes;
};
constexpr std::array kMagics{Magic{PictureFormat::png, 0, "\x89PNG\r\n\x1A\n"},
                             Magic{PictureFormat::jpeg, 0, "\xFF\xD8\xFF"},
                             Magic{PictureFormat::ktx2, 0, "\xABKTX 20\xBB"},
                             Magic{PictureFormat::webp, 8, "WEBP"},
                             Magic{PictureFormat::avif, 4, "ftypavi"},
                             Magic{PictureFormat::gif, 0, "GIF8"},
                             Magic{PictureFormat::bmp, 0, "BM"},
                             Magic{PictureFormat::tiff, 0, std::string_view("II*\0", 4)},
                             Magic{PictureFormat::tiff, 0, std::string_view("MM\0*", 4)},
                             Magic{PictureFormat::dds, 0, "DDS "},
                             Magic{PictureFormat::openexr, 0, "\x76\x2F\x31\x01"},
                             Magic{PictureFormat::radiance, 0, "#?"}};

}  // namespace

PictureFormat picture_format(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const Magic& magic : kMagics) {
    if (text.size() >= magic.offset && text.substr(magic.offset).starts_with(magic.bytes)) return magic.format;
  }
  return PictureFormat::unknown;
}

PictureHeader read_picture_header(std::span<const std::byte> bytes) {
  const auto header_of = [&] {
    switch (picture_format(bytes)) {
      case PictureFormat::png:
        return png_header(bytes);
      case PictureFormat::jpeg:
        return jpeg_header(bytes);
      case PictureFormat::webp:
        return webp_header(bytes);
      case PictureFormat::ktx2:
        return ktx2_header(bytes);
      default:
        throw InputError("is neither PNG, JPEG, WebP nor KTX2; convert it to one of them");
    }
  };
  const PictureHeader header = header_of();
  const std::uint64_t pixels = std::uint64_t{header.width} * header.height;
  if (header.width > kMaxPictureSide || header.height > kMaxPictureSide || pixels > kMaxPixels)
    throw InputError(fmt::format("claims {} x {} pixels, more than {} a side or {} together; scale it down",
                                 header.width, header.height, kMaxPictureSide, kMaxPixels));
  return header;
}

std::vector<std::uint32_t> decode_picture(std::span<const std::byte> bytes, const PictureHeader& header) {
  std::vector<std::uint32_t> rgba8(std::size_t{header.width} * header.height);
  switch (header.format) {
    case PictureFormat::png:
      decode_png(bytes, header, rgba8.data());
      break;
    case PictureFormat::jpeg:
      decode_jpeg(bytes, header, rgba8.data());
      break;
    case PictureFormat::webp:
      decode_webp(bytes, header, rgba8.data());
      break;
    case PictureFormat::ktx2:
      decode_ktx2(bytes, header, rgba8.data());
      break;
    default:
      throw InternalError("decode_picture() was given a header that read_picture_header() never returns");
  }
  return rgba8;
}

}  // namespace eikon
