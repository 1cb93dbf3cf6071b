// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>

#include "core/error.h"
#include "image/atomic_file.h"
#include "image/image.h"

namespace eikon {
namespace {

/// IEC 61966-2-1, both pieces; 0 for what is negative or not finite.
unsigned char to_srgb8(double linear) {
  if (!std::isfinite(linear) || linear <= 0) return 0;
  const double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return static_cast<unsigned char>(std::floor(255 * std::min(encoded, 1.0) + 0.5));
}

}  // namespace

void write_png(const std::filesystem::path& path, const Image& image, double exposure_ev) {
  const std::size_t pixels = std::size_t{image.width} * image.height;
  if (pixels == 0 || pixels > (std::size_t{1} << 29))
    throw InputError(fmt::format("cannot write \"{}\": {}x{} pixels are not for a PNG: use .exr", path.string(),
                                 image.width, image.height));
  const double scale = std::exp2(exposure_ev);
  std::vector<unsigned char> bytes(3 * pixels);
  std::size_t channel = 0;
  for (const char* name : {"R", "G", "B"}) {
    const auto* plane = image.plane(name);
    if (plane == nullptr)
      throw InputError(fmt::format("cannot write \"{}\": the image has no channel {}", path.string(), name));
    for (std::size_t i = 0; i < pixels; ++i)
      bytes[3 * i + channel] = to_srgb8(static_cast<double>((*plane)[i]) * scale);
    ++channel;
  }
  // stb hands over everything in one call, which must not throw through its C code: the file is written afterwards.
  std::vector<char> encoded;
  const auto append = [](void* context, void* data, int size) {
    const char* first = static_cast<const char*>(data);
    static_cast<std::vector<char>*>(context)->assign(first, first + size);
  };
  const int width = static_cast<int>(image.width), height = static_cast<int>(image.height);
  if (stbi_write_png_to_func(append, &encoded, width, height, 3, bytes.data(), 3 * width) == 0)
    throw InputError(fmt::format("cannot write \"{}\": not enough memory to compress it", path.string()));
  AtomicFile file(path);
  file.write(encoded.data(), encoded.size());
  file.commit();
}

Image to_image(const Film& film) {
  const Crop& crop = film.layout().crop;
  Image image{
      .width = crop.width(), .height = crop.height(), .channels = {"R", "G", "B"}, .planes = {}, .metadata = {}};
  for (std::uint32_t c = 0; c < 3; ++c) {
    std::vector<float>& plane = image.planes.emplace_back();
    plane.reserve(crop.pixel_count());
    for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
      for (std::uint32_t x = crop.x0; x < crop.x1; ++x) plane.push_back(static_cast<float>(film.mean(x, y, c)));
  }
  return image;
}

}  // namespace eikon
