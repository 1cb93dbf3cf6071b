// SPDX-License-Identifier: Apache-2.0
// Pixel filters. A filter f is separable and symmetric, and is importance-sampled: a sample is
// placed with density |f| around the middle of its pixel and carries the sign of f as its weight.
// So a sample belongs to one pixel.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace eikon {

/// Formulas for x in pixels from the middle of the pixel and r = width / 2; all are 0 beyond r.
enum class FilterKind {
  box,              // 1
  triangle,         // 1 - |x| / r
  gaussian,         // exp(-x^2 / (2 s^2)) minus its value at r, s = width / 6
  // B = C = 1/3, its knots at 0, r / 2, r [Mitchell and Netravali 1988]; negative beyond 4/7 r.
  mitchell,
  blackman_harris,  // four terms, 92 dB [Harris 1978]
};

struct PixelFilter {
  FilterKind kind = FilterKind::box;
  double width = 1;  // full width in pixels

  /// The filter is the square of the pixel, which kernels sample without a table.
  [[nodiscard]] bool is_pixel_box() const { return kind == FilterKind::box && width == 1; }
  /// The text for the command line, e.g. "gaussian:3".
  [[nodiscard]] std::string name() const;
  /// f(x), not normalised: 1 at x = 0, except for mitchell (8/9) and gaussian (1 minus its value at
  /// r).
  [[nodiscard]] double operator()(double x) const;
};

/// Parses "gaussian" (with the default width) or "gaussian:2.5".
/// throws UsageError for another name, or a width that is not between 0.01 and 100
[[nodiscard]] PixelFilter parse_filter(std::string_view text);
/// Names and default widths for --help: "box (1), triangle (2), ...".
[[nodiscard]] std::string filter_names();
/// The names alone.
[[nodiscard]] std::vector<std::string> filter_words();

/// The table from which kernels/film/filter.h samples: EK_FILTER_WORDS floats.
[[nodiscard]] std::vector<float> filter_table(const PixelFilter& filter);

}  // namespace eikon
