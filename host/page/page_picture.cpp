// SPDX-License-Identifier: Apache-2.0
#include "page/page_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "image/relative_error.h"
#include "io/text.h"

namespace eikon {
namespace {

using Planes = std::array<const std::vector<float>*, 3>;

std::optional<Planes> planes_of(const Image& image, const std::string& prefix) {
  Planes planes{};
  for (std::size_t c = 0; c < 3; ++c) {
    planes[c] = image.plane(prefix + kRgb[c]);
    if (planes[c] == nullptr) return std::nullopt;
  }
  return planes;
}

/// Calls `visit` with each pixel of an image that belongs to a block of `side` times `side`.
template <class Visit>
void for_each_of_block(const Image& image, std::uint32_t side, std::size_t x, std::size_t y, const Visit& visit) {
  for (std::size_t v = y * side; v < std::min<std::size_t>((y + 1) * side, image.height); ++v)
    for (std::size_t u = x * side; u < std::min<std::size_t>((x + 1) * side, image.width); ++u)
      visit(v * image.width + u);
}

/// The square of the relative standard error of a pixel; NaN where its variance is unknown.
double relative_variance(const Planes& mean, const Planes& variance, std::size_t pixel) {
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double m = double((*mean[c])[pixel]);
    sum += double((*variance[c])[pixel]) / (m * m + kErrorEpsilon) / 3;
  }
  return sum;
}

unsigned char error_grey(double relative_error) {
  constexpr double kMinExponent = -4, kStep = 51;
  if (!(relative_error > 0)) return 0;
  return static_cast<unsigned char>(
      std::clamp(std::lround((std::log10(relative_error) - kMinExponent) * kStep), 0L, 255L));
}

std::string data_address(const std::string& png) { return "data:image/png;base64," + base64(png); }

}  // namespace

void append_rgbe(std::vector<unsigned char>& bytes, const float (&rgb)[3]) {
  const auto sane = [](float value) { return std::isfinite(value) && value > 0 ? value : 0.0F; };
  const float most = std::max({sane(rgb[0]), sane(rgb[1]), sane(rgb[2])});
  int exponent = 0;
  (void)std::frexp(most, &exponent);
  if (most == 0 || exponent <= -128) return bytes.insert(bytes.end(), 4, 0), void();
  for (const float value : rgb) bytes.push_back(static_cast<unsigned char>(std::ldexp(sane(value), 8 - exponent)));
  bytes.push_back(static_cast<unsigned char>(std::min(exponent + 128, 255)));
}

Json page_picture(const Image& image) {
  const std::optional<Planes> mean = planes_of(image, ""), variance = planes_of(image, "variance.");
  if (!mean || image.width == 0 || image.height == 0) throw InputError("the image has no pixels of R, G and B");
  const std::uint32_t side = (std::max(image.width, image.height) - 1) / kMaxPageSide + 1;
  const std::uint32_t width = (image.width - 1) / side + 1, height = (image.height - 1) / side + 1;
  std::vector<unsigned char> mantissas, exponents, errors;
  bool known = false;
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      double sum[3] = {}, error = 0;
      int count = 0;
      for_each_of_block(image, side, x, y, [&](std::size_t pixel) {
        for (std::size_t c = 0; c < 3; ++c) sum[c] += double((*(*mean)[c])[pixel]);
        if (variance) error += relative_variance(*mean, *variance, pixel);
        ++count;
      });
      std::vector<unsigned char> rgbe;
      append_rgbe(rgbe, {float(sum[0] / count), float(sum[1] / count), float(sum[2] / count)});
      mantissas.insert(mantissas.end(), rgbe.begin(), rgbe.begin() + 3);
      exponents.insert(exponents.end(), 3, rgbe[3]);
      errors.push_back(error_grey(std::sqrt(error / count)));
      known = known || (variance && std::isfinite(error));
    }
  mantissas.insert(mantissas.end(), exponents.begin(), exponents.end());
  Json picture = {{"width", width}, {"height", height}, {"reduced", side}, {"error", nullptr}};
  picture["rgbe"] = data_address(encode_png({width, 2 * height, 3, mantissas}));
  if (known) picture["error"] = data_address(encode_png({width, height, 1, errors}));
  return picture;
}

}  // namespace eikon
