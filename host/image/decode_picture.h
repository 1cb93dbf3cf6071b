// SPDX-License-Identifier: Apache-2.0
// Decodes 8-bit pictures from bytes that may be hostile. Only .cpp files of this folder use libpng,
// libjpeg, libwebp and libzstd. The first bytes alone tell the format, never a name or a declared
// type. The first two libraries leave by longjmp on an error; the jump never crosses a frame with a
// destructor, and nothing is printed.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace eikon {

enum class PictureFormat { png, jpeg, ktx2, webp, avif, gif, bmp, tiff, dds, openexr, radiance, unknown };
[[nodiscard]] PictureFormat picture_format(std::span<const std::byte> bytes);

struct PictureHeader {
  PictureFormat format = PictureFormat::unknown;  // png, jpeg, webp or ktx2
  std::uint32_t width = 0, height = 0;            // each 1 to 65536, 2^28 together
  // 16 bits per channel; decode_picture() keeps 8 of them.
  bool deep = false;
  std::uint64_t scratch_bytes = 0;  // of memory that the decoder may take beside the pixels
};

/// Reads the header of a PNG, JPEG, WebP or KTX2 without allocating anything for its pixels.
/// throws InputError (without the file's name): another format, damaged, too large, a size that is
/// not credible for so many bytes, animated, a texture that is no picture
PictureHeader read_picture_header(std::span<const std::byte> bytes);

/// Decodes pixels from the top, R in the low byte. Grey and palettes become RGB; alpha is 255 where
/// there is none. Inks (CMYK) become the light that they leave. Gamma and colour profiles are
/// ignored [glTF 2.0, section 3.8.1].
/// header: of `bytes`, from read_picture_header()
/// throws InputError (without the file's name): truncated, damaged; std::bad_alloc
std::vector<std::uint32_t> decode_picture(std::span<const std::byte> bytes, const PictureHeader& header);

/// The parts of the above for each format. The headers lack the check of the number of pixels;
/// `rgba8` has width * height elements.
PictureHeader png_header(std::span<const std::byte> bytes);
PictureHeader jpeg_header(std::span<const std::byte> bytes);
PictureHeader webp_header(std::span<const std::byte> bytes);
PictureHeader ktx2_header(std::span<const std::byte> bytes);
void decode_png(std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8);
void decode_jpeg(std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8);
void decode_webp(std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8);
void decode_ktx2(std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8);

}  // namespace eikon
