// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>

#include "core/error.h"
#include "io/atomic_file.h"
#include "image/image.h"

namespace eikon {
namespace {

constexpr std::array<const char*, 3> kRgb{"R", "G", "B"};

unsigned char to_byte(double unit) { return static_cast<unsigned char>(std::floor(255 * unit + 0.5)); }

/// IEC 61966-2-1, both pieces; 0 for what is negative or not finite.
unsigned char to_srgb8(double linear) {
  if (!std::isfinite(linear) || linear <= 0) return 0;
  const double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return to_byte(std::min(encoded, 1.0));
}

/// In [0, 1]: a filter with negative parts leaves values beyond. Not a number counts as nothing there.
double to_opacity(float alpha) { return alpha > 0 ? std::min(static_cast<double>(alpha), 1.0) : 0; }

}  // namespace

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
    // A PNG's colours are not multiplied by its alpha; an EXR's are [PNG specification, section 12.8].
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
  // stb hands over everything in one call, which must not throw through its C code: the file is written afterwards.
  std::vector<char> encoded;
  const auto append = [](void* context, void* data, int size) {
    const char* first = static_cast<const char*>(data);
    static_cast<std::vector<char>*>(context)->assign(first, first + size);
  };
  const int width = static_cast<int>(image.width), height = static_cast<int>(image.height);
  const int components = static_cast<int>(channels);
  if (stbi_write_png_to_func(append, &encoded, width, height, components, bytes.data(), components * width) == 0)
    throw InputError(fmt::format("cannot write \"{}\": not enough memory to compress it", path.string()));
  AtomicFile file(path);
  file.write(encoded.data(), encoded.size());
  file.commit();
}

}  // namespace eikon
