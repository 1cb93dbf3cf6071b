// SPDX-License-Identifier: Apache-2.0
#include "scene/measured_table.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace eikon {
namespace {

using std::numbers::pi;
constexpr std::size_t kH = EK_MEASURED_THETA_H, kD = EK_MEASURED_THETA_D, kP = EK_MEASURED_PHI_D;
constexpr std::size_t kViews = EK_MEASURED_VIEWS;
constexpr int kAround = 64;          // half vectors of each cell and view, evenly around the normal
constexpr double kMaxHalf = 0.875;   // the cosine's part is 1/8 at least: weights are below 8 pi f
constexpr double kMinHalf = 1e-4;    // of what is reflected; less than that is left to the cosine

double theta_h_of(double cells) { return (cells / kH) * (cells / kH) * pi / 2; }

/// True if both directions of the middle of a cell are above the surface.
bool is_above(std::size_t h, std::size_t d, std::size_t p) {
  const double theta_h = theta_h_of(double(h) + 0.5), theta_d = (double(d) + 0.5) / kD * pi / 2,
               phi_d = (double(p) + 0.5) / kP * pi;
  return std::cos(theta_d) * std::cos(theta_h) > std::abs(std::cos(phi_d)) * std::sin(theta_d) * std::sin(theta_h);
}

/// Fills the entries for which a direction lies below the surface, and sets negative ones to 0.
/// returns the number of entries above the surface that were negative
std::size_t fill(std::vector<float>& rgb) {
  std::size_t holes = 0;
  for (std::size_t h = 0; h < kH; ++h)
    for (std::size_t p = 0; p < kP; ++p)
      for (std::size_t d = 0; d < kD; ++d) {
        float* const entry = &rgb[3 * ((h * kD + d) * kP + p)];
        if (d > 0 && !is_above(h, d, p)) {
          std::copy_n(entry - 3 * kP, 3, entry);
          continue;
        }
        holes += std::any_of(entry, entry + 3, [](float f) { return f < 0; }) ? 1 : 0;
        std::transform(entry, entry + 3, entry, [](float f) { return std::max(f, 0.0F); });
      }
  return holes;
}

/// The entry in whose cell a pair of directions is.
const float* entry_of(const std::vector<float>& rgb, std::size_t h, const glm::dvec3& wo, const glm::dvec3& wi,
                      double cos_d) {
  const auto cell = [](double share, std::size_t count) {
    return std::min(std::size_t(std::max(share, 0.0) * double(count)), count - 1);
  };
  const double turns = std::atan2(2 * (wo.x * wi.y - wo.y * wi.x), (wo.z - wi.z) * 2 * cos_d) / pi;
  const std::size_t d = cell(std::acos(std::min(cos_d, 1.0)) / (pi / 2), kD), p = cell(turns - std::floor(turns), kP);
  return &rgb[3 * ((h * kD + d) * kP + p)];
}

/// The light that half vectors of one cell of theta_h send to a view, and how much of it there
/// would be for f = 1.
struct Share {
  double light = 0, measure = 0;
};
using Shares = std::array<Share, kH>;

/// The albedo of a view, and the share that each cell of theta_h has in it.
/// solid_angle  of the cells of theta_h
glm::dvec3 reflected_to(const std::vector<float>& rgb, double cos_o, const std::array<double, kH>& solid_angle,
                        Shares& shares) {
  const glm::dvec3 wo(std::sqrt(1 - cos_o * cos_o), 0, cos_o);
  glm::dvec3 albedo(0);
  for (std::size_t i = 0; i < kH; ++i) {
    const double theta = theta_h_of(double(i) + 0.5), sin_h = std::sin(theta), cos_h = std::cos(theta);
    for (int k = 0; k < kAround; ++k) {
      const double phi = (k + 0.5) / kAround * 2 * pi;
      const glm::dvec3 h(sin_h * std::cos(phi), sin_h * std::sin(phi), cos_h);
      const double cos_d = glm::dot(wo, h);
      const glm::dvec3 wi = 2 * cos_d * h - wo;
      if (!(cos_d > 0 && wi.z > 0)) continue;
      const float* const f = entry_of(rgb, i, wo, wi, cos_d);
      const double measure = wi.z * 4 * cos_d * solid_angle[i] / kAround;
      const glm::dvec3 light = measure * glm::dvec3(f[0], f[1], f[2]);
      albedo += light;
      shares[i].light += (light.x + light.y + light.z) / 3;
      shares[i].measure += measure;
    }
  }
  return albedo;
}

/// Fills a view's words. The cosine samples the least mean value of f, and half vectors sample what
/// exceeds it.
void fill_view(const Shares& shares, const std::vector<float>& edges, float* words) {
  double base = 1e300, beyond = 0, below = 0;
  for (const Share& s : shares)
    if (s.measure > 0) base = std::min(base, s.light / s.measure);
  std::array<double, kH> part{};
  for (std::size_t i = 0; i < kH; ++i) {
    part[i] = std::max(shares[i].light - base * shares[i].measure, 0.0);
    beyond += part[i];
    below += base * shares[i].measure;
  }
  const double p = beyond > kMinHalf * (beyond + below) ? beyond / (beyond + below) : 0;
  words[0] = float(std::min(p, kMaxHalf));
  float* const cumulative = words + EK_MEASURED_VIEW_CUMULATIVE;
  float* const density = words + EK_MEASURED_VIEW_DENSITY;
  double sum = 0;
  cumulative[0] = 0;
  for (std::size_t i = 0; i < kH; ++i) {
    sum += p > 0 ? part[i] / beyond : 1.0 / kH;
    cumulative[i + 1] = i + 1 == kH ? 1.0F : std::min(float(sum), 1.0F);
    // The density follows from the floats that kernels sample by.
    density[i] = float((double(cumulative[i + 1]) - double(cumulative[i])) /
                       (2 * pi * (double(edges[i + 1]) - double(edges[i]))));
  }
}

}  // namespace

std::size_t MeasuredTable::brightest_view() const {
  const auto most = [](const glm::dvec3& rgb) { return std::max({rgb.x, rgb.y, rgb.z}); };
  return std::size_t(std::ranges::max_element(albedos, {}, most) - albedos.begin());
}

MeasuredTable make_measured_table(std::vector<float> rgb) {
  MeasuredTable table;
  table.holes = fill(rgb);
  std::vector<float> floats(EK_MEASURED_VALUES), edges(EK_MEASURED_EDGES);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const double s = std::sin(theta_h_of(double(i)) / 2);
    edges[i] = float(2 * s * s);  // 1 - cos
  }
  std::array<double, kH> solid_angle{};
  for (std::size_t i = 0; i < kH; ++i) solid_angle[i] = 2 * pi * (double(edges[i + 1]) - double(edges[i]));
  std::ranges::copy(edges, floats.begin());
  for (std::size_t view = 0; view < kViews; ++view) {
    Shares shares{};
    table.albedos[view] = reflected_to(rgb, MeasuredTable::cosine(view), solid_angle, shares);
    fill_view(shares, edges, &floats[EK_MEASURED_EDGES + view * EK_MEASURED_VIEW_WORDS]);
  }
  table.words.reserve(EK_MEASURED_WORDS);
  for (const std::vector<float>* part : {&floats, &rgb})
    for (const float x : *part) table.words.push_back(std::bit_cast<std::uint32_t>(x));
  return table;
}

}  // namespace eikon
