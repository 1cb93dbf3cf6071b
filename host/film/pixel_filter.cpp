// SPDX-License-Identifier: Apache-2.0
#include "film/pixel_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "core/error.h"
#include "io/text.h"
#include "shared/records.h"

namespace eikon {
namespace {

struct Known {
  const char* name;
  double width;
};
// In the order of FilterKind, with default widths. Triangle and Mitchell have the published widths;
// Gaussian and Blackman-Harris blur about as much as each other.
constexpr std::array<Known, 5> kKnown = {
    {{"box", 1}, {"triangle", 2}, {"gaussian", 3}, {"mitchell", 4}, {"blackman-harris", 3}}};
constexpr double kMinWidth = 0.01, kMaxWidth = 100;
// Cells of the integral over half of the filter.
constexpr std::size_t kCells = std::size_t{1} << 16;

double mitchell(double x) {  // x in [0, 2]
  constexpr double B = 1.0 / 3.0, C = 1.0 / 3.0;
  if (x < 1) return ((12 - 9 * B - 6 * C) * x * x * x + (-18 + 12 * B + 6 * C) * x * x + (6 - 2 * B)) / 6;
  return ((-B - 6 * C) * x * x * x + (6 * B + 30 * C) * x * x + (-12 * B - 48 * C) * x + (8 * B + 24 * C)) / 6;
}

double blackman_harris(double turn) {  // turn: 0 at one rim, 1 at the other
  const double a = 2 * std::numbers::pi * turn;
  return 0.35875 - 0.48829 * std::cos(a) + 0.14128 * std::cos(2 * a) - 0.01168 * std::cos(3 * a);
}

}  // namespace

double PixelFilter::operator()(double x) const {
  const double r = 0.5 * width, distance = std::abs(x);
  if (!(distance <= r)) return 0;
  switch (kind) {
    case FilterKind::box:
      break;
    case FilterKind::triangle:
      return 1 - distance / r;
    case FilterKind::gaussian: {
      const double in_sigmas = distance / (width / 6);
      return std::exp(-0.5 * in_sigmas * in_sigmas) - std::exp(-4.5);
    }
    case FilterKind::mitchell:
      return mitchell(2 * distance / r);
    case FilterKind::blackman_harris:
      return blackman_harris(0.5 + distance / width);
  }
  return 1;
}

std::string PixelFilter::name() const { return fmt::format("{}:{}", kKnown.at(std::size_t(kind)).name, width); }

std::string filter_names() {
  std::string names;
  for (const Known& known : kKnown)
    names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", known.name, known.width);
  return names;
}

std::vector<std::string> filter_words() {
  std::vector<std::string> words;
  for (const Known& known : kKnown) words.emplace_back(known.name);
  return words;
}

PixelFilter parse_filter(std::string_view text) {
  const std::size_t colon = text.find(':');
  const std::string_view name = text.substr(0, colon);
  const auto known = std::find_if(kKnown.begin(), kKnown.end(), [&](const Known& k) { return name == k.name; });
  if (known == kKnown.end())
    throw UsageError(fmt::format("--filter {}: no such filter; there is {}", text, filter_names()));
  PixelFilter filter{static_cast<FilterKind>(known - kKnown.begin()), known->width};
  if (colon == std::string_view::npos) return filter;
  filter.width = number_in<double>(text.substr(colon + 1)).value_or(0);
  if (!(filter.width >= kMinWidth && filter.width <= kMaxWidth))
    throw UsageError(fmt::format("--filter {}: a width is a number of pixels between {} and {}, e.g. {}:{}", text,
                                 kMinWidth, kMaxWidth, name, known->width));
  return filter;
}

std::vector<float> filter_table(const PixelFilter& filter) {
  const double r = 0.5 * filter.width, cell = r / kCells;
  // Integrates |f| from the rim inwards by Simpson's rule, which is exact for cubics between their
  // knots.
  std::vector<double> mass(kCells + 1, 0.0);
  for (std::size_t i = 0; i < kCells; ++i) {
    const double x = r - double(i) * cell;
    mass[i + 1] = mass[i] + cell / 6 *
                                (std::abs(filter(x)) + 4 * std::abs(filter(x - 0.5 * cell)) +
                                 std::abs(filter(i + 1 == kCells ? 0 : x - cell)));
  }
  std::vector<float> table;
  std::size_t i = 0;
  for (int m = 0; m <= EK_FILTER_BINS; ++m) {
    const double share = double(m) / EK_FILTER_BINS, target = share * share * mass[kCells];
    while (i + 1 < kCells && mass[i + 1] < target) ++i;
    const double within =
        mass[i + 1] > mass[i] ? std::clamp((target - mass[i]) / (mass[i + 1] - mass[i]), 0.0, 1.0) : 0;
    table.push_back(m == 0 ? float(r) : m == EK_FILTER_BINS ? 0.0F : float(r - (double(i) + within) * cell));
  }
  // The begin of Mitchell's negative outer lobe, and the excess of the integral of |f| over that of
  // f.
  double rim = 2 * r, negative = 0;
  if (filter.kind == FilterKind::mitchell) {
    rim = r * 4 / 7;  // 6 f = (2 - x)^2 (8 - 7 x) / 3 on the outer piece
    const auto bin = std::find_if(table.begin(), table.end(), [&](float x) { return double(x) < rim; });
    const double m = double(bin - table.begin() - 1), outer = double(bin[-1]), inner = double(bin[0]);
    const double in_bin = (outer - rim) / (outer - inner);
    negative = (m * m + in_bin * (2 * m + 1)) / double(EK_FILTER_BINS * EK_FILTER_BINS);
  }
  table.push_back(float(rim));
  table.push_back(float(1 / (1 - 2 * negative)));
  return table;
}

}  // namespace eikon
