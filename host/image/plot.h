// SPDX-License-Identifier: Apache-2.0
// Curves as an SVG picture, both axes logarithmic.
#pragma once
#include <string>
#include <vector>

namespace eikon {

struct PlotPoint {
  double x = 0, y = 0;
};

struct PlotSeries {
  std::string label;
  std::vector<PlotPoint> points;  // those not finite and above 0 are left out
};

struct PlotPanel {
  std::string x_label, y_label;
  std::vector<PlotSeries> series;  // at most four
};

/// The least powers of ten, as exponents, that enclose all values: at least a decade. {0, 1} where there is none.
struct Decades {
  int first = 0, last = 1;
};
[[nodiscard]] Decades enclosing_decades(const std::vector<double>& values);

/// The panels side by side, each with decades as grid, its curves with a dot per point, and their labels. Any text is allowed.
[[nodiscard]] std::string log_log_svg(const std::string& title, const std::vector<PlotPanel>& panels);

}  // namespace eikon
