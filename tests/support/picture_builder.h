// SPDX-License-Identifier: Apache-2.0
// PNG, JPEG, WebP and KTX2 files made on the spot, for the tests of the decoders and of textures.
#pragma once
#include <png.h>

#include <cstdint>
#include <cstdio>  // before jpeglib.h, which uses FILE without it
#include <cstdlib>
#include <jpeglib.h>
#include <webp/encode.h>

#include <initializer_list>
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

/// `rows`: the samples as PNG has them, row by row, each row padded to whole bytes, 16-bit ones
/// big-endian.
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

enum class JpegKind { baseline, progressive, hundreds_of_scans, ycck, unmarked };

/// `components` 1: grey, 3: RGB, 4: CMYK, with Adobe's marker unless `unmarked`. Hundreds of scans:
/// grey, each bit of each coefficient by itself, as is legal.
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
  if (kind == JpegKind::ycck) jpeg_set_colorspace(&encoder, JCS_YCCK);
  if (kind == JpegKind::unmarked) encoder.write_Adobe_marker = FALSE;
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

/// `rgba`: four samples a pixel. A lossy file has the best quality.
inline std::string webp(int width, int height, const Samples& rgba, bool lossless) {
  std::uint8_t* bytes = nullptr;
  const std::size_t size = lossless ? WebPEncodeLosslessRGBA(rgba.data(), width, height, 4 * width, &bytes)
                                    : WebPEncodeRGBA(rgba.data(), width, height, 4 * width, 100, &bytes);
  std::string out(reinterpret_cast<const char*>(bytes), size);
  WebPFree(bytes);
  return out;
}

struct Ktx2Options {
  std::uint32_t format = 37;  // VkFormat: RGBA of 8 bits
  std::uint32_t scheme = 0;   // of supercompression
  std::uint32_t depth = 0, layers = 0, faces = 1, levels = 1;
  std::uint64_t unpacked = 0;  // bytes of the first level, where they are packed
};

/// `texels` is the first level, and stands behind a header without a description of the format.
inline std::string ktx2(std::uint32_t width, std::uint32_t height, const Samples& texels,
                        const Ktx2Options& options = {}) {
  std::string out = "\xABKTX 20\xBB\r\n\x1A\n";
  const auto put = [&](std::initializer_list<std::uint64_t> values, int bytes) {
    for (const std::uint64_t value : values)
      for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i) & 0xFFU);
  };
  put({options.format, 1, width, height, options.depth, options.layers, options.faces, options.levels, options.scheme},
      4);
  put({0, 0, 0, 0}, 4);
  put({0, 0, 104, texels.size(), options.unpacked != 0 ? options.unpacked : texels.size()}, 8);
  return out + std::string(texels.begin(), texels.end());
}

// 8 x 8 pixels in four quarters: red, blue, green, and light grey of alpha 128. Written by Basis
// Universal's encoder. This file has codec ETC1S.
constexpr const char* kEtc1sQuarters =
    "ab4b5458203230bb0d0a1a0a0000000001000000080000000800000000000000000000000100000001000000010000006800"
    "00003c000000a400000024000000c8000000000000009a000000000000006201000000000000040000000000000000000000"
    "000000003c0000000000000002003800a301020003030000080800000000000000003f000000000000000000ffffffff4000"
    "3f0f0000000000000000ffffffff1f0000004b545877726974657200426173697320556e6976657273616c20322e31300000"
    "06000300350000000d000000300000000000000000000000000000000200000002000000020000001840140001000040d00a"
    "9a0ec10a200a8000000000647b9208600600000000200c8361d00f80290000000000104887b8b69c934305acaaaaaafaffff"
    "ff575555550500c144000000000000f2df2748013001400000000002b990005103060000004113a2d1130c00260000000000"
    "001040000b09e653";
// This file has codec UASTC, packed by Zstandard.
constexpr const char* kUastcQuarters =
    "ab4b5458203230bb0d0a1a0a0000000001000000080000000800000000000000000000000100000001000000020000006800"
    "00002c000000940000002400000000000000000000000000000000000000b800000000000000330000000000000040000000"
    "000000002c0000000000000002002800a601020003030000100000000000000000007f030000000000000000ffffffff1f00"
    "00004b545877726974657200426173697320556e6976657273616c20322e3130000028b52ffd2040550100f0171b05e37fc6"
    "2300170409fa3f1e08030c19e85f328c001e1e1e1074ce010400801850ccccc209c005";

inline std::string from_hex(const char* digits) {
  std::string out;
  for (; *digits != '\0'; digits += 2) out += static_cast<char>(std::stoi(std::string(digits, 2), nullptr, 16));
  return out;
}

inline std::string etc1s_quarters() { return from_hex(kEtc1sQuarters); }
inline std::string uastc_quarters() { return from_hex(kUastcQuarters); }

}  // namespace picture_test
