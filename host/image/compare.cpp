// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/error.h"
#include "image/image.h"
#include "image/relative_error.h"
#include "image/srgb.h"

namespace eikon {
namespace {

struct Pair {
  const std::vector<float>* test = nullptr;
  const std::vector<float>* reference = nullptr;
};

std::array<Pair, 3> paired_planes(const Image& test, const Image& reference) {
  if (test.width != reference.width || test.height != reference.height)
    throw InputError(fmt::format("cannot compare an image of {}x{} with one of {}x{}: render both at one size",
                                 test.width, test.height, reference.width, reference.height));
  std::array<Pair, 3> pairs;
  for (std::size_t c = 0; c < 3; ++c) {
    pairs[c] = {.test = test.plane(kRgb[c]), .reference = reference.plane(kRgb[c])};
    if (pairs[c].test == nullptr || pairs[c].reference == nullptr)
      throw InputError(fmt::format("cannot compare: the {} image has no channel {}",
                                   pairs[c].test == nullptr ? "test" : "reference", kRgb[c]));
  }
  return pairs;
}

/// sRGB-encoded anchors of a perceptually ordered ramp, close to matplotlib's "inferno" with white
/// at the end.
constexpr std::array<std::array<double, 3>, 8> kRamp{{{0.00, 0.00, 0.01},
                                                      {0.16, 0.04, 0.33},
                                                      {0.40, 0.08, 0.43},
                                                      {0.63, 0.17, 0.39},
                                                      {0.85, 0.29, 0.25},
                                                      {0.96, 0.52, 0.06},
                                                      {0.97, 0.80, 0.25},
                                                      {1.00, 1.00, 1.00}}};

std::array<double, 3> ramp(double value) {
  const double at = std::clamp(value, 0.0, 1.0) * (kRamp.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kRamp.size() - 2);
  std::array<double, 3> colour{};
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] = linear_from_srgb(std::lerp(kRamp[i][c], kRamp[i + 1][c], at - static_cast<double>(i)));
  return colour;
}

}  // namespace

Comparison compare_images(const Image& test, const Image& reference) {
  const auto pairs = paired_planes(test, reference);
  Comparison result;
  double squares = 0, relative_squares = 0, relative = 0, test_sum = 0, reference_sum = 0;
  std::uint64_t kept = 0;
  for (const Pair& pair : pairs) {
    for (std::size_t row = 0; row < pair.test->size(); row += test.width) {
      // Rows are summed first, so that the rounding error grows with the sides of the image and not
      // with its area.
      double row_squares = 0, row_relative_squares = 0, row_relative = 0, row_test = 0, row_reference = 0;
      for (std::size_t i = row; i < row + test.width; ++i) {
        const auto x = static_cast<double>((*pair.test)[i]), r = static_cast<double>((*pair.reference)[i]);
        if (!std::isfinite(x) || !std::isfinite(r)) continue;
        ++kept;
        const double d = x - r;
        row_squares += d * d;
        row_relative_squares += d * d / (r * r + kErrorEpsilon);
        row_relative += std::abs(d) / (std::abs(r) + kErrorEpsilon);
        row_test += x;
        row_reference += r;
      }
      squares += row_squares;
      relative_squares += row_relative_squares;
      relative += row_relative;
      test_sum += row_test;
      reference_sum += row_reference;
    }
  }
  result.nonfinite = std::uint64_t{3} * test.width * test.height - kept;
  const double n = kept > 0 ? static_cast<double>(kept) : std::numeric_limits<double>::quiet_NaN();
  result.mse = squares / n;
  result.relmse = relative_squares / n;
  result.mape = relative / n;
  result.ratio_of_means = test_sum == 0 && reference_sum == 0 ? n / n : test_sum / reference_sum;
  return result;
}

Image difference_image(const Image& test, const Image& reference) {
  const auto pairs = paired_planes(test, reference);
  const std::size_t pixels = std::size_t{test.width} * test.height;
  Image image{.width = test.width,
              .height = test.height,
              .channels = {"R", "G", "B"},
              .planes = std::vector<std::vector<float>>(3, std::vector<float>(pixels)),
              .metadata = {}};
  for (std::size_t i = 0; i < pixels; ++i) {
    double error = 0;
    for (const Pair& pair : pairs) {
      const auto x = static_cast<double>((*pair.test)[i]), r = static_cast<double>((*pair.reference)[i]);
      error += std::abs(x - r) / (std::abs(r) + kErrorEpsilon) / 3;
      if (!std::isfinite(x) || !std::isfinite(r)) error = std::numeric_limits<double>::quiet_NaN();
    }
    const std::array<double, 3> colour = std::isnan(error) ? std::array<double, 3>{0, 1, 0} : ramp(error);
    for (std::size_t c = 0; c < 3; ++c) image.planes[c][i] = static_cast<float>(colour[c]);
  }
  return image;
}

}  // namespace eikon
