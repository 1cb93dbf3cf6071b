// SPDX-License-Identifier: Apache-2.0
#include <csetjmp>
#include <cstdio>  // jpeglib.h uses FILE without it
#include <jpeglib.h>
#include <jerror.h>

#include <fmt/format.h>

#include "core/error.h"
#include "image/decode_picture.h"

namespace eikon {
namespace {

// A block of 64 pixels takes at least one bit of Huffman code; this allows twice as many pixels.
constexpr std::uint64_t kMaxPixelsPerByte = 1024, kAlwaysCrediblePixels = 65536;
// Every scan of a progressive file visits all pixels; files in use have about ten, hostile ones
// thousands.
constexpr int kMaxScans = 256;

// The only state that a longjmp may leave behind; it has no destructors. Callbacks get pointers to
// `manager` and `progress`.
struct JpegState {
  jpeg_error_mgr manager{};
  jpeg_progress_mgr progress{};
  jpeg_decompress_struct decoder{};
  std::jmp_buf escape{};
  char message[JMSG_LENGTH_MAX] = {};
};

JpegState& state_of(j_common_ptr decoder) { return *static_cast<JpegState*>(decoder->client_data); }

void on_error(j_common_ptr decoder) {
  JpegState& state = state_of(decoder);
  decoder->err->format_message(decoder, state.message);
  std::longjmp(state.escape, 1);
}

// A level below 0 means damaged data, which the library would fill with grey. Stray bytes between
// segments are harmless.
void on_message(j_common_ptr decoder, int level) {
  const int code = decoder->err->msg_code;
  if (level < 0 && code != JWRN_EXTRANEOUS_DATA && code != JWRN_ADOBE_XFORM) on_error(decoder);
}

void on_progress(j_common_ptr decoder) {
  JpegState& state = state_of(decoder);
  if (state.decoder.input_scan_number <= kMaxScans) return;
  std::snprintf(state.message, sizeof state.message, "more than %d scans", kMaxScans);
  std::longjmp(state.escape, 1);
}

// Replaces inks by the light that they leave. Adobe's programs, which mark their files, store
// 255 - ink.
void lighten(bool stores_light, std::uint32_t width, std::uint32_t* row) {
  const std::uint32_t flip = stores_light ? 0 : 0xFFFFFFFFU;
  for (std::uint32_t x = 0; x < width; ++x) {
    const std::uint32_t cmyk = row[x] ^ flip, k = cmyk >> 24U;
    std::uint32_t rgb = 0;
    for (std::uint32_t shift = 0; shift < 24; shift += 8) rgb |= ((cmyk >> shift & 0xFFU) * k + 127) / 255 << shift;
    row[x] = rgb | 0xFF000000U;
  }
}

// It has a frame of its own below setjmp, so that no variable of it is read after the jump.
bool read_rows(JpegState& state, std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8) {
  jpeg_decompress_struct& decoder = state.decoder;
  jpeg_create_decompress(&decoder);
  decoder.client_data = &state;
  decoder.progress = &state.progress;
  jpeg_mem_src(&decoder, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&decoder, TRUE);
  if (decoder.image_width != header.width || decoder.image_height != header.height) {
    std::snprintf(state.message, sizeof state.message, "two headers");
    return false;
  }
  const bool inks = decoder.num_components == 4;
  decoder.out_color_space = inks ? JCS_CMYK : JCS_EXT_RGBA;
  jpeg_start_decompress(&decoder);
  while (decoder.output_scanline < decoder.output_height) {
    auto* row = reinterpret_cast<JSAMPROW>(rgba8 + std::size_t{decoder.output_scanline} * header.width);
    jpeg_read_scanlines(&decoder, &row, 1);
    if (inks)
      lighten(decoder.saw_Adobe_marker != 0, header.width,
              rgba8 + std::size_t{decoder.output_scanline - 1} * header.width);
  }
  jpeg_finish_decompress(&decoder);
  return true;
}

bool run(JpegState& state, std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8) {
  if (setjmp(state.escape) != 0) return false;
  return read_rows(state, bytes, header, rgba8);
}

}  // namespace

PictureHeader jpeg_header(std::span<const std::byte> bytes) {
  const auto fail = [] [[noreturn]] (const char* why) {
    throw InputError(fmt::format("is a JPEG {}; copy or export it again", why));
  };
  const auto byte = [&](std::size_t at) {
    if (at >= bytes.size()) fail("that ends before its header: truncated");
    return std::to_integer<std::uint32_t>(bytes[at]);
  };
  const auto word = [&](std::size_t at) { return byte(at) << 8U | byte(at + 1); };
  for (std::size_t at = 2;;) {
    if (byte(at++) != 0xFF) fail("with something between its segments: damaged");
    while (byte(at) == 0xFF) ++at;  // fill bytes
    const std::uint32_t marker = byte(at++);
    const bool frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame) {
      const std::uint32_t components = byte(at + 7), bits = byte(at + 2);
      const bool is_read = marker <= 0xC2 || marker == 0xC9 || marker == 0xCA;  // sequential or progressive
      if (!is_read) throw InputError("is a lossless or hierarchical JPEG; save it as a baseline or progressive one");
      if (bits != 8) throw InputError(fmt::format("is a JPEG of {} bits per channel; save it with 8", bits));
      PictureHeader header{.format = PictureFormat::jpeg, .width = word(at + 5), .height = word(at + 3)};
      if (components != 1 && components != 3 && components != 4) fail("with neither 1, 3 nor 4 channels: damaged");
      if (header.width == 0 || header.height == 0) fail("that does not say its size in its header");
      const std::uint64_t pixels = std::uint64_t{header.width} * header.height;
      if (pixels > kAlwaysCrediblePixels && pixels > bytes.size() * kMaxPixelsPerByte)
        throw InputError(fmt::format("its header claims {} x {} pixels, which {} bytes cannot hold", header.width,
                                     header.height, bytes.size()));
      // A picture in several scans keeps all of its coefficients until the last.
      header.scratch_bytes = pixels * components * sizeof(JCOEF);
      return header;
    }
    if (marker == 0xD9 || marker == 0xDA || marker == 0) fail("without a header before its data: damaged");
    if (marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8)) continue;  // no content
    const std::uint32_t length = word(at);
    if (length < 2) fail("with a segment of no length: damaged");
    at += length;
  }
}

void decode_jpeg(std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8) {
  JpegState state;
  state.decoder.err = jpeg_std_error(&state.manager);
  state.manager.error_exit = on_error;
  state.manager.emit_message = on_message;
  state.progress.progress_monitor = on_progress;
  // jpeg_create_decompress() keeps err and client_data, and may fail itself.
  state.decoder.client_data = &state;
  const bool good = run(state, bytes, header, rgba8);
  jpeg_destroy_decompress(&state.decoder);
  if (!good) throw InputError(fmt::format("is a damaged JPEG ({}); copy or export it again", state.message));
}

}  // namespace eikon
