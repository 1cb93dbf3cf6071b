// SPDX-License-Identifier: Apache-2.0
#include "image/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace eikon {
namespace {

constexpr double kWidth = 460, kHeight = 360;                       // of a panel, pixels
constexpr double kLeft = 70, kRight = 20, kTop = 50, kBottom = 50;  // margins
constexpr std::array<const char*, 4> kColours{"#0072b2", "#d55e00", "#009e73",
                                              "#cc79a7"};  // told apart by all [Okabe, Ito]

bool usable(const PlotPoint& point) {
  return std::isfinite(point.x) && std::isfinite(point.y) && point.x > 0 && point.y > 0;
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else
      safe += static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126 ? '?' : c;
  }
  return safe;
}

std::string text(double x, double y, const char* anchor, const std::string& words, const std::string& more = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor, more,
                     escaped(words));
}

std::string line(double x0, double y0, double x1, double y1) {
  return fmt::format("<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\" stroke=\"#ccc\"/>\n", x0, y0, x1, y1);
}

std::string power_of_ten(int exponent) {
  return exponent >= -2 && exponent <= 4 ? fmt::format("{:g}", std::pow(10.0, exponent))
                                         : fmt::format("1e{}", exponent);
}

std::string panel_svg(const PlotPanel& panel, double offset) {
  std::vector<double> xs, ys;
  for (const PlotSeries& series : panel.series)
    for (const PlotPoint& point : series.points)
      if (usable(point)) {
        xs.push_back(point.x);
        ys.push_back(point.y);
      }
  const Decades across = enclosing_decades(xs), up = enclosing_decades(ys);
  const double left = offset + kLeft, right = offset + kWidth - kRight, bottom = kHeight - kBottom;
  const auto x_of = [&](double log_x) {
    return left + (right - left) * (log_x - across.first) / (across.last - across.first);
  };
  const auto y_of = [&](double log_y) { return bottom + (kTop - bottom) * (log_y - up.first) / (up.last - up.first); };

  std::string out;
  for (int e = across.first; e <= across.last; ++e)
    out += line(x_of(e), kTop, x_of(e), bottom) + text(x_of(e), bottom + 18, "middle", power_of_ten(e));
  for (int e = up.first; e <= up.last; ++e)
    out += line(left, y_of(e), right, y_of(e)) + text(left - 8, y_of(e) + 4, "end", power_of_ten(e));
  out += text((left + right) / 2, kHeight - 12, "middle", panel.x_label);
  const double middle = (kTop + bottom) / 2;
  out += text(offset + 16, middle, "middle", panel.y_label,
              fmt::format(" transform=\"rotate(-90 {:.1f} {:.1f})\"", offset + 16, middle));
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const char* colour = kColours[i % kColours.size()];
    std::string path, dots;
    for (const PlotPoint& point : panel.series[i].points) {
      if (!usable(point)) continue;
      const double x = x_of(std::log10(point.x)), y = y_of(std::log10(point.y));
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x, y);
      dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\"/>\n", x, y, colour);
    }
    if (!path.empty())
      out += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\"/>\n", path, colour);
    out += dots + text(right - 6, kTop + 16 + 16 * double(i), "end", panel.series[i].label,
                       fmt::format(" fill=\"{}\"", colour));
  }
  return out;
}

}  // namespace

Decades enclosing_decades(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  Decades decades{int(std::floor(std::log10(*least))), int(std::ceil(std::log10(*most)))};
  if (decades.last == decades.first) ++decades.last;
  return decades;
}

std::string log_log_svg(const std::string& title, const std::vector<PlotPanel>& panels) {
  const double width = kWidth * double(std::max<std::size_t>(panels.size(), 1));
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      width, kHeight);
  out += text(width / 2, 28, "middle", title, " font-size=\"15\"");
  for (std::size_t i = 0; i < panels.size(); ++i) out += panel_svg(panels[i], kWidth * double(i));
  return out + "</svg>\n";
}

}  // namespace eikon
