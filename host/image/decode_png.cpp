// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <png.h>

#include <cstdio>
#include <cstring>
#include <new>

#include "core/error.h"
#include "image/decode_picture.h"

namespace eikon {
namespace {

constexpr std::size_t kHeaderBytes = 33;  // the magic number and the chunk IHDR
// Deflate shrinks data by a factor of at most 1032, so a file that claims more lies about its size.
constexpr std::uint64_t kMaxPngExpansion = 1032;

std::uint32_t big_endian(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8U | std::to_integer<std::uint32_t>(bytes[at + i]);
  return value;
}

std::uint64_t channels_of(std::uint32_t colour_type) {
  switch (colour_type) {
    case PNG_COLOR_TYPE_GRAY:
    case PNG_COLOR_TYPE_PALETTE:
      return 1;
    case PNG_COLOR_TYPE_GRAY_ALPHA:
      return 2;
    case PNG_COLOR_TYPE_RGB:
      return 3;
    case PNG_COLOR_TYPE_RGB_ALPHA:
      return 4;
    default:
      throw InputError(fmt::format("has colour type {}, which PNG does not know: damaged", colour_type));
  }
}

// The only state that a longjmp may leave behind; it has no destructors.
struct PngState {
  const std::byte* next = nullptr;
  std::size_t left = 0;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::uint32_t width = 0, height = 0;
  char message[160] = {};
};

void on_error(png_structp png, png_const_charp message) {
  auto* state = static_cast<PngState*>(png_get_error_ptr(png));
  std::snprintf(state->message, sizeof state->message, "%s", message);
  png_longjmp(png, 1);
}

// Warnings concern chunks that do not change pixels.
void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep out, std::size_t count) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  if (count > state->left) png_error(png, "truncated");
  std::memcpy(out, state->next, count);
  state->next += count;
  state->left -= count;
}

// It has a frame of its own below setjmp, so that no variable of it is read after the jump.
void read_rows(PngState& state, std::uint32_t* rgba8) {
  png_structp png = state.png;
  png_set_read_fn(png, &state, on_read);
  // Only IHDR, PLTE, tRNS, IDAT and IEND are read: no gamma, no profiles, no compressed texts that
  // could expand to gigabytes.
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_read_info(png, state.info);
  if (png_get_image_width(png, state.info) != state.width || png_get_image_height(png, state.info) != state.height)
    png_error(png, "two headers");
  png_set_expand(png);
  png_set_scale_16(png);
  png_set_gray_to_rgb(png);
  png_set_add_alpha(png, 0xFF, PNG_FILLER_AFTER);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, state.info);
  if (png_get_rowbytes(png, state.info) != std::size_t{state.width} * 4) png_error(png, "rows of an unknown layout");
  for (int pass = 0; pass < passes; ++pass) {
    for (std::uint32_t y = 0; y < state.height; ++y) {
      png_read_row(png, reinterpret_cast<png_bytep>(rgba8 + std::size_t{y} * state.width), nullptr);
    }
  }
  png_read_end(png, nullptr);
}

bool run(PngState& state, std::uint32_t* rgba8) {
  if (setjmp(png_jmpbuf(state.png)) != 0) return false;
  read_rows(state, rgba8);
  return true;
}

}  // namespace

PictureHeader png_header(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeaderBytes) throw InputError("is a PNG without a whole header: truncated? Copy it again");
  if (big_endian(bytes, 8) != 13 || std::memcmp(bytes.data() + 12, "IHDR", 4) != 0)
    throw InputError("is a PNG that does not begin with its header: damaged");
  const PictureHeader header{.format = PictureFormat::png,
                             .width = big_endian(bytes, 16),
                             .height = big_endian(bytes, 20),
                             .deep = bytes[24] == std::byte{16}};
  const auto bits = std::to_integer<std::uint64_t>(bytes[24]) * channels_of(std::to_integer<std::uint32_t>(bytes[25]));
  if (header.width == 0 || header.height == 0) throw InputError("is a PNG of no pixels: damaged");
  // A row may claim 2^32 * 4 * 255 / 8 bytes, and there may be 2^32 of them, so this is in double.
  const double claimed = static_cast<double>(header.height) * (1 + static_cast<double>(header.width * bits) / 8);
  if (claimed > static_cast<double>(bytes.size() * kMaxPngExpansion))
    throw InputError(fmt::format("its header claims {} x {} pixels, which {} bytes cannot hold", header.width,
                                 header.height, bytes.size()));
  return header;
}

void decode_png(std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8) {
  PngState state;
  state.next = bytes.data();
  state.left = bytes.size();
  state.width = header.width;
  state.height = header.height;
  state.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &state, on_error, on_warning);
  if (state.png == nullptr) throw std::bad_alloc();
  state.info = png_create_info_struct(state.png);
  const bool good = state.info != nullptr && run(state, rgba8);
  png_destroy_read_struct(&state.png, &state.info, nullptr);
  if (!good) throw InputError(fmt::format("is a damaged PNG ({}); copy or export it again", state.message));
}

}  // namespace eikon
