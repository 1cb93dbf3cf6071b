// SPDX-License-Identifier: Apache-2.0
// PNG and JPEG files made on the spot, for the tests of the decoders and of textures.
#pragma once
#include <png.h>

#include <cstdint>
#include <cstdio>  // before jpeglib.h, which uses FILE without it
#include <cstdlib>
#include <jpeglib.h>
#include <string>
#include <vector>

namespace picture_test {

using Samples = std::vector<std::uint8_t>;

struct PngOptions {
  int colour_type = PNG_COLOR_TYPE_RGB;
  int depth = 8;
  bool interlaced = false;
  std::vector<png_color> palette{};
  Samples palette_alpha{};         // tRNS of a palette
  std::vector<int> transparent{};  // tRNS of grey or RGB: the colour that is transparent
  double gamma = 0;                // gAMA; 0: none
};

/// `rows`: the samples as PNG has them, row by row, each row padded to whole bytes, 16-bit ones big-endian.
inline std::string png(std::uint32_t width, std::uint32_t height, const Samples& rows, const PngOptions& options = {}) {
  std::string out;
  png_structp writer = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(writer);
  png_set_write_fn(
      writer, &out,
      [](png_structp p, png_bytep data, png_size_t size) {
        static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<const char*>(data), size);
      },
      nullptr);
  png_set_IHDR(writer, info, width, height, options.depth, options.colour_type,
               options.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (!options.palette.empty())
    png_set_PLTE(writer, info, options.palette.data(), static_cast<int>(options.palette.size()));
  if (!options.palette_alpha.empty())
    png_set_tRNS(writer, info, options.palette_alpha.data(), static_cast<int>(options.palette_alpha.size()), nullptr);
  if (!options.transparent.empty()) {
    png_color_16 colour{};
    colour.gray = colour.red = static_cast<png_uint_16>(options.transparent[0]);
    if (options.transparent.size() == 3) {
      colour.green = static_cast<png_uint_16>(options.transparent[1]);
      colour.blue = static_cast<png_uint_16>(options.transparent[2]);
    }
    png_set_tRNS(writer, info, nullptr, 0, &colour);
  }
  if (options.gamma > 0) png_set_gAMA(writer, info, options.gamma);
  png_write_info(writer, info);
  const std::size_t stride = rows.size() / height;
  std::vector<png_bytep> pointers;
  for (std::uint32_t y = 0; y < height; ++y) pointers.push_back(const_cast<png_bytep>(rows.data() + y * stride));
  png_write_image(writer, pointers.data());
  png_write_end(writer, info);
  png_destroy_write_struct(&writer, &info);
  return out;
}

/// An RGB picture of one colour.
inline std::string plain_png(std::uint32_t width, std::uint32_t height, int r = 10, int g = 20, int b = 30) {
  Samples rows;
  for (std::uint32_t i = 0; i < width * height; ++i) {
    for (const int c : {r, g, b}) rows.push_back(static_cast<std::uint8_t>(c));
  }
  return png(width, height, rows);
}

/// The same file with another size in its header, its checksum right.
inline std::string with_png_size(std::string file, std::uint32_t width, std::uint32_t height) {
  const auto put = [&](std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) file[at + i] = static_cast<char>(value >> (24 - 8 * i));
  };
  put(16, width);
  put(20, height);
  std::uint32_t crc = 0xFFFFFFFFU;  // [PNG specification, annex D]
  for (std::size_t i = 12; i < 29; ++i) {
    crc ^= static_cast<std::uint8_t>(file[i]);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? 0xEDB88320U ^ (crc >> 1U) : crc >> 1U;
  }
  put(29, ~crc);
  return file;
}

enum class JpegKind { baseline, progressive, hundreds_of_scans };

/// `components` 1: grey, 3: RGB, 4: CMYK. Hundreds of scans: grey, each bit of each coefficient by itself, as is legal.
inline std::string jpeg(std::uint32_t width, std::uint32_t height, int components, const Samples& pixels,
                        JpegKind kind = JpegKind::baseline) {
  jpeg_compress_struct encoder{};
  jpeg_error_mgr manager{};
  encoder.err = jpeg_std_error(&manager);
  jpeg_create_compress(&encoder);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&encoder, &bytes, &size);
  encoder.image_width = width;
  encoder.image_height = height;
  encoder.input_components = components;
  encoder.in_color_space = components == 1 ? JCS_GRAYSCALE : components == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&encoder);
  jpeg_set_quality(&encoder, 100, TRUE);
  if (kind == JpegKind::progressive) jpeg_simple_progression(&encoder);
  std::vector<jpeg_scan_info> scans;
  if (kind == JpegKind::hundreds_of_scans) {
    const auto add = [&](int coefficient, int high, int low) {
      scans.push_back({1, {0, 0, 0, 0}, coefficient, coefficient, high, low});
    };
    add(0, 0, 0);
    for (int coefficient = 1; coefficient < 64; ++coefficient) {
      add(coefficient, 0, 5);
      for (int low = 4; low >= 0; --low) add(coefficient, low + 1, low);
    }
    encoder.scan_info = scans.data();
    encoder.num_scans = static_cast<int>(scans.size());
  }
  jpeg_start_compress(&encoder, TRUE);
  while (encoder.next_scanline < height) {
    auto* row = const_cast<JSAMPROW>(pixels.data() +
                                     std::size_t{encoder.next_scanline} * width * static_cast<std::size_t>(components));
    jpeg_write_scanlines(&encoder, &row, 1);
  }
  jpeg_finish_compress(&encoder);
  std::string out(reinterpret_cast<const char*>(bytes), size);
  jpeg_destroy_compress(&encoder);
  std::free(bytes);
  return out;
}

}  // namespace picture_test
