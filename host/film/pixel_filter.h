// SPDX-License-Identifier: Apache-2.0
// How a pixel weighs what the film around it receives. A filter is separable, symmetric, and drawn from: a sample is placed
// with density |f| around the middle of its pixel and carries the sign of f as its weight, so it belongs to that pixel alone.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace eikon {

/// x in pixels from the middle of the pixel, r = width / 2; all are 0 beyond r.
enum class FilterKind {
  box,              // 1
  triangle,         // 1 - |x| / r
  gaussian,         // exp(-x^2 / (2 s^2)) less its value at r, s = width / 6
  mitchell,         // B = C = 1/3, its knots at 0, r / 2, r [Mitchell and Netravali 1988]; negative beyond 4/7 r
  blackman_harris,  // four terms, 92 dB [Harris 1978]
};

struct PixelFilter {
  FilterKind kind = FilterKind::box;
  double width = 1;  // full, pixels

  /// Of the pixel's own square alone, everywhere alike: what kernels do without a table.
  [[nodiscard]] bool is_pixel_box() const { return kind == FilterKind::box && width == 1; }
  /// As on the command line: "gaussian:3".
  [[nodiscard]] std::string name() const;
  /// f(x), 1 at x = 0 except for mitchell (8/9) and gaussian (less its rim); not normalised.
  [[nodiscard]] double operator()(double x) const;
};

/// "gaussian" with the filter's usual width, or "gaussian:2.5".
/// throws UsageError for another name, or a width that is not between 0.01 and 100
[[nodiscard]] PixelFilter parse_filter(std::string_view text);
/// "box (1), triangle (2), ...": names and usual widths, for --help.
[[nodiscard]] std::string filter_names();

/// What kernels/film/filter.h draws from: EK_FILTER_WORDS floats.
[[nodiscard]] std::vector<float> filter_table(const PixelFilter& filter);

}  // namespace eikon
