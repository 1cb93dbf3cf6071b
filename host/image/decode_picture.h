// SPDX-License-Identifier: Apache-2.0
// Decodes 8-bit pictures from bytes that may be hostile. Only .cpp files of this folder use libpng and libjpeg. The first bytes
// alone tell the format, never a name or a declared type. Both libraries leave by longjmp on an error; the jump never crosses a
// frame with a destructor, and nothing is printed.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace eikon {

enum class PictureFormat { png, jpeg, ktx2, webp, avif, gif, bmp, tiff, dds, openexr, radiance, unknown };
[[nodiscard]] PictureFormat picture_format(std::span<const std::byte> bytes);

struct PictureHeader {
  PictureFormat format = PictureFormat::unknown;  // png or jpeg
  std::uint32_t width = 0, height = 0;            // each 1 to 65536, 2^28 together
  bool deep = false;                              // 16 bits per channel, of which decode_picture keeps 8
};

/// What a PNG or JPEG says of itself, found without allocating anything.
/// throws InputError (without the file's name): neither of them, damaged, too large, more than so many bytes can hold, CMYK
PictureHeader read_picture_header(std::span<const std::byte> bytes);

/// Pixels from the top, R in the low byte: grey and palettes become RGB, alpha is 255 where there is none. Gamma and colour
/// profiles are ignored [glTF 2.0, section 3.8.1]. `header` is what read_picture_header made of `bytes`.
/// throws InputError (without the file's name): truncated, damaged; std::bad_alloc
std::vector<std::uint32_t> decode_picture(std::span<const std::byte> bytes, const PictureHeader& header);

/// The parts of the above. Headers without the check of the number of pixels; `rgba8` has width x height elements.
PictureHeader png_header(std::span<const std::byte> bytes);
PictureHeader jpeg_header(std::span<const std::byte> bytes);
void decode_png(std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8);
void decode_jpeg(std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8);

}  // namespace eikon
