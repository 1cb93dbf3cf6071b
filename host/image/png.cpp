// SPDX-License-Identifier: Apache-2.0
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "io/atomic_file.h"
#include "image/image.h"

namespace eikon {
namespace {


unsigned char to_byte(double unit) { return static_cast<unsigned char>(std::floor(255 * unit + 0.5)); }

/// Encodes by IEC 61966-2-1; negative and non-finite values give 0.
unsigned char to_srgb8(double linear) {
  if (!std::isfinite(linear) || linear <= 0) return 0;
  const double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return to_byte(std::min(encoded, 1.0));
}

/// Clamps alpha to [0, 1], because a pixel filter with negative parts leaves values beyond; NaN
/// gives 0.
double to_opacity(float alpha) { return alpha > 0 ? std::min(static_cast<double>(alpha), 1.0) : 0; }

}  // namespace

std::string encode_png(const PngBytes& picture) {
  png_image header{};  // png_image is the description of an image
  header.version = PNG_IMAGE_VERSION;
  header.width = picture.width;
  header.height = picture.height;
  header.format = picture.channels == 1 ? PNG_FORMAT_GRAY : picture.channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  png_alloc_size_t size_bytes = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string encoded(size_bytes, '\0');
  if (png_image_write_to_memory(&header, encoded.data(), &size_bytes, 0, picture.bytes.data(), 0, nullptr) == 0)
    throw InternalError(fmt::format("a PNG of {} x {} pixels: {}", picture.width, picture.height, header.message));
  encoded.resize(size_bytes);
  return encoded;
}

void write_png(const std::filesystem::path& path, const Image& image, double exposure_ev, ToneMap map) {
  const std::size_t pixels = std::size_t{image.width} * image.height;
  if (pixels == 0 || pixels > (std::size_t{1} << 29))
    throw InputError(fmt::format("cannot write \"{}\": {}x{} pixels are not for a PNG: use .exr", path.string(),
                                 image.width, image.height));
  const double scale = std::exp2(exposure_ev);
  std::array<const std::vector<float>*, 3> planes{};
  for (std::size_t c = 0; c < 3; ++c) {
    planes[c] = image.plane(kRgb[c]);
    if (planes[c] == nullptr)
      throw InputError(fmt::format("cannot write \"{}\": the image has no channel {}", path.string(), kRgb[c]));
  }
  const std::vector<float>* const alpha = image.plane("A");
  const std::size_t channels = alpha != nullptr ? 4 : 3;
  std::vector<unsigned char> bytes(channels * pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    // Colours of a PNG are straight, those of an EXR premultiplied [PNG specification, section
    // 12.8].
    const double opacity = alpha != nullptr ? to_opacity((*alpha)[i]) : 1;
    const double gain = opacity > 0 ? scale / opacity : 0;
    glm::dvec3 linear;
    for (int c = 0; c < 3; ++c) {
      const double value = static_cast<double>((*planes[std::size_t(c)])[i]);
      linear[c] = std::isfinite(value) ? value * gain : 0;
    }
    const glm::dvec3 shown = tone_map(map, linear);
    for (int c = 0; c < 3; ++c) bytes[channels * i + std::size_t(c)] = to_srgb8(shown[c]);
    if (alpha != nullptr) bytes[channels * i + 3] = to_byte(opacity);
  }
  const std::string encoded = encode_png({image.width, image.height, channels, bytes});
  AtomicFile file(path);
  file.write(encoded.data(), encoded.size());
  file.commit();
}

}  // namespace eikon
