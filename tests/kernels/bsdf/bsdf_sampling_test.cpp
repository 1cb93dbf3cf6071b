// SPDX-License-Identifier: Apache-2.0
// Samples of every lobe against the density that it states, over the whole sphere.
#include <gtest/gtest.h>

#include <map>

#include "kernels/bsdf/bsdf_probe.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

using Vector = std::array<double, 3>;
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector normalized(const Vector& a) {
  const double length = std::sqrt(dot(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}

/// A partition of the sphere into bins that are fine where a lobe is narrow: the directions above
/// the surface in polar coordinates about one axis, those below about another; polar angles by 1 -
/// cos = scale t^6. Along a meridian a side ends at the surface's horizon, where densities jump:
/// bins are integrated up to there.
class Bins {
 public:
  /// What of a bin an integral looks at: parts of its columns and of what its rows have on their
  /// side of the horizon, in 0 .. 1.
  struct Cell {
    std::size_t bin;
    double row = 0, column = 0, size = 1;
  };
  /// A node of a cell's rule, and what of the sphere it stands for.
  struct Point {
    Direction w;
    double solid_angle;
  };

  static constexpr unsigned kRows = 16, kColumns = 24, kNodes = 4;
  static constexpr std::size_t kCount = std::size_t{2} * kRows * kColumns;

  /// axes of the upper and the lower half; whole: polar angles up to 180 degrees (a tilted axis),
  /// else up to the horizon
  Bins(const Vector& up, const Vector& down, bool whole) : axes_{up, down}, scale_(whole ? 2 : 1) {
    for (unsigned side = 0; side < 2; ++side) {
      Vector& z = axes_[side];
      z = normalized(z);
      const Vector helper = std::abs(z[0]) < 0.6 ? Vector{1, 0, 0} : Vector{0, 1, 0};
      Vector& x = x_[side];
      for (std::size_t k = 0; k < 3; ++k) x[k] = helper[k] - dot(helper, z) * z[k];
      x = normalized(x);
      y_[side] = {z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]};
    }
  }

  std::size_t index(const Vector& w) const {
    const unsigned side = w[2] > 0 ? 0 : 1;
    // 1 - cos by the distance: a float vector's length, and the cosine, say too little of small
    // angles.
    Vector d = normalized(w);
    for (std::size_t k = 0; k < 3; ++k) d[k] -= axes_[side][k];
    const double t = std::pow(dot(d, d) / 2 / scale_, 1.0 / 6);
    const double turn = std::atan2(dot(w, y_[side]), dot(w, x_[side])) / (2 * std::numbers::pi) + 0.5;
    const unsigned row = std::min(unsigned(t * kRows), kRows - 1),
                   column = std::min(unsigned(turn * kColumns), kColumns - 1);
    return (std::size_t{side} * kRows + row) * kColumns + column;
  }

  /// The kNodes x kNodes nodes of a cell by Gauss and Legendre's rule; none where all of the cell
  /// is another side's.
  /// returns whether the cell lies low along the horizon, within a strip of which some densities
  /// live, or only a part of it, perhaps without a node, is on its side
  bool add_points(const Cell& cell, std::vector<Point>& points) const {
    constexpr double kAt[] = {0.0694318442029737, 0.330009478207572, 0.669990521792428, 0.930568155797026};
    constexpr double kWeight[] = {0.173927422568727, 0.326072577431273, 0.326072577431273, 0.173927422568727};
    const auto side = unsigned(cell.bin / (std::size_t{kRows} * kColumns)), row = unsigned(cell.bin / kColumns % kRows),
               column = unsigned(cell.bin % kColumns);
    const auto rest = [&](double at) { return horizon(side, (column + at) / kColumns) - double(row) / kRows; };
    bool low = (rest(cell.column) > 0) != (rest(cell.column + cell.size) > 0);
    for (unsigned j = 0; j < kNodes; ++j) {
      const double turn = (column + cell.column + kAt[j] * cell.size) / kColumns;
      const double begin = double(row) / kRows, length = std::min((row + 1.0) / kRows, horizon(side, turn)) - begin;
      low = low || length < 1.0 / kRows;
      if (length <= 0) continue;
      for (unsigned i = 0; i < kNodes; ++i) {
        const double t = begin + length * (cell.row + kAt[i] * cell.size);
        const Vector w = direction(side, t, turn);
        low = low || std::abs(w[2]) < 0.05;
        const double area = scale_ * 6 * std::pow(t, 5) * length * kWeight[i] * 2 * std::numbers::pi / kColumns *
                            kWeight[j] * cell.size * cell.size;
        points.push_back({{float(w[0]), float(w[1]), float(w[2])}, area});
      }
    }
    return low;
  }

 private:
  Vector direction(unsigned side, double t, double turn) const {
    const double rest = scale_ * std::pow(t, 6), z = 1 - rest, r = std::sqrt(rest * (1 + z));
    const double phi = (turn - 0.5) * 2 * std::numbers::pi;
    Vector w;
    for (std::size_t k = 0; k < 3; ++k)
      w[k] = r * (std::cos(phi) * x_[side][k] + std::sin(phi) * y_[side][k]) + z * axes_[side][k];
    return w;
  }

  /// t at which a meridian meets the surface; what is beyond is the other side's
  double horizon(unsigned side, double turn) const {
    const double phi = (turn - 0.5) * 2 * std::numbers::pi;
    const double along = std::cos(phi) * x_[side][2] + std::sin(phi) * y_[side][2];
    // cos * axis + sin * along = 0; both sides begin at their axis, which is theirs.
    const double theta = std::atan2(std::abs(axes_[side][2]), axes_[side][2] > 0 ? -along : along);
    return std::pow((1 - std::cos(theta)) / scale_, 1.0 / 6);
  }

  std::array<Vector, 2> axes_, x_{}, y_{};
  double scale_;
};

/// The bins that differ most, for a failure's message.
std::string worst_bins(const std::vector<double>& observed, const std::vector<double>& expected) {
  std::vector<std::size_t> order(observed.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto surprise = [&](std::size_t i) { return std::pow(observed[i] - expected[i], 2) / (expected[i] + 1e-9); };
  std::partial_sort(order.begin(), order.begin() + 5, order.end(),
                    [&](auto a, auto b) { return surprise(a) > surprise(b); });
  std::string text;
  for (std::size_t k = 0; k < 5; ++k)
    text += "\nbin " + std::to_string(order[k]) + " has " + std::to_string(observed[order[k]]) + " of " +
            std::to_string(expected[order[k]]);
  return text;
}

/// Bins about the normal for wide lobes; about the mirrored and the refracted direction for narrow
/// ones.
Bins bins_for(const Specimen& s, const Direction& wo) {
  if (s.narrowest() > 0.5F) return {{0, 0, 1}, {0, 0, -1}, false};
  const double eta = s.material.solid ? s.eta() : 1, z2 = 1 - (1 - double(wo[2]) * wo[2]) / (eta * eta);
  // Under total reflection what passes at all passes along the surface.
  const Vector below{-wo[0] / eta, -wo[1] / eta, z2 > 0 ? -std::sqrt(z2) : -0.1};
  return {{-wo[0], -wo[1], wo[2]}, below, true};
}

/// What pdf integrates to over each bin: cells are quartered where that still matters, as at the
/// horizons of a coat and of upright microfacets, where densities jump, and at least kLow times
/// along the surface's own.
std::vector<double> integrals(const std::vector<Specimen>& all, std::uint32_t which, const Direction& wo,
                              const Bins& bins, bool compensated) {
  constexpr unsigned kLow = 2, kDeepest = 6;
  // A cell that is cut by a jump is off by less than quartering changes it; some hundred are, to
  // either side. With 50,000 samples this is one sample of the hundred that a bin expects, a tenth
  // of its standard deviation.
  constexpr double kResolved = 2e-5;
  const auto children = [](const Bins::Cell& c) {
    const double h = c.size / 2;
    return std::array<Bins::Cell, 4>{{{c.bin, c.row, c.column, h},
                                      {c.bin, c.row + h, c.column, h},
                                      {c.bin, c.row, c.column + h, h},
                                      {c.bin, c.row + h, c.column + h, h}}};
  };
  std::vector<double> value(Bins::kCount, 0);
  std::vector<Bins::Cell> cells;
  for (std::size_t bin = 0; bin < Bins::kCount; ++bin) cells.push_back({bin});
  std::vector<double> coarse;  // of every four cells: of what they are quarters
  for (unsigned depth = 0; !cells.empty(); ++depth) {
    std::vector<Bins::Point> points;
    std::vector<std::size_t> ends;
    std::vector<bool> low;
    for (const Bins::Cell& cell : cells) {
      low.push_back(bins.add_points(cell, points));
      ends.push_back(points.size());
    }
    std::vector<double> part(cells.size(), 0);
    if (!points.empty()) {
      Queries grid;
      grid.compared = 512;  // the samples, of which pdf is asked too, are compared at greater length
      for (const auto& point : points) grid.add(which, wo, point.w, 0, 0, 0);
      const Answers stated = scatter(all, grid, false, true, compensated);
      for (std::size_t cell = 0, i = 0; cell < cells.size(); ++cell)
        for (; i < ends[cell]; ++i) part[cell] += stated.pdf(i) * points[i].solid_angle;
    }
    std::vector<Bins::Cell> next;
    std::vector<double> next_coarse;
    const auto quarter = [&](std::size_t cell) {
      for (const Bins::Cell& child : children(cells[cell])) next.push_back(child);
      next_coarse.push_back(part[cell]);
    };
    if (depth == 0) {
      for (std::size_t cell = 0; cell < cells.size(); ++cell) quarter(cell);
    } else {
      for (std::size_t first = 0; first < cells.size(); first += 4) {
        const double finer = part[first] + part[first + 1] + part[first + 2] + part[first + 3];
        const bool resolved = std::abs(finer - coarse[first / 4]) <= kResolved;
        for (std::size_t cell = first; cell < first + 4; ++cell) {
          if (depth < kDeepest && (!resolved || (low[cell] && depth < kLow)))
            quarter(cell);
          else
            value[cells[cell].bin] += part[cell];
        }
      }
    }
    cells = std::move(next);
    coarse = std::move(next_coarse);
  }
  return value;
}

constexpr int kRoughnessCount = 6;  // two of them with energy compensation
constexpr double kAngles[] = {0, 45, 85, 89};
constexpr unsigned kDraws = 50000;

void check_sampling(float roughness, bool compensated = false) {
  const double alpha = sidak(specimens(0).size() * kRoughnessCount * std::size(kAngles));
  std::mt19937 random(1);
  double worst_total = 0;
  {
    auto all = specimens(roughness);
    if (compensated)
      std::erase_if(all, [](const Specimen& s) { return s.material.metallic == 0 && s.material.transmission == 0; });
    for (std::uint32_t which = 0; which < all.size(); ++which)
      for (const double angle : kAngles) {
        const Specimen& specimen = all[which];
        SCOPED_TRACE(specimen.name + ", roughness " + std::to_string(roughness) + ", " + std::to_string(angle) +
                     " degrees");
        const Direction wo = from_angle(angle, 0.1);
        const Bins bins = bins_for(specimen, wo);
        Queries q;
        q.draw(kDraws, which, wo, random);
        const Answers sampled = scatter(all, q, false, true, compensated);
        std::vector<double> observed(Bins::kCount, 0), expected = integrals(all, which, wo, bins, compensated);
        double total = 0;
        for (double& share : expected) {
          total += share;
          share *= kDraws;
        }
        double scattered = 0;
        // By direction and probability: two parts, a coat and what it lies on, may send light the
        // same way.
        std::map<std::array<double, 4>, double> delta;
        for (unsigned i = 0; i < kDraws; ++i) {
          const Sampled s = sampled.sample(i);
          if (s.pdf == 0) continue;
          if (s.delta) {
            ++delta[{s.wi[0], s.wi[1], s.wi[2], s.pdf}];
            continue;
          }
          ++scattered;
          ++observed[bins.index(s.wi)];
        }
        // What neither fails nor is delta is what pdf integrates to, here by the midpoint rule.
        const double spread = std::sqrt(std::max(total * (1 - total), 0.0) / kDraws);
        EXPECT_NEAR(total, scattered / kDraws, 4.5 * spread + 2e-3);
        worst_total = std::max(worst_total, std::abs(total - scattered / kDraws) - 4.5 * spread);
        EXPECT_LE(total, 1 + 1e-3);
        // Where the samples that scatter go. A bin of which only a sliver scatters can have no
        // point there.
        std::vector<double> counts, predicted;
        double slivers = 0;
        for (std::size_t i = 0; i < Bins::kCount; ++i) {
          if (expected[i] > 0) {
            counts.push_back(observed[i]);
            predicted.push_back(expected[i] * scattered / (kDraws * total));
          } else {
            slivers += observed[i];
          }
        }
        EXPECT_LE(slivers, 1e-4 * kDraws);
        if (scattered > 0) {
          const ChiSquare test = chi_square(counts, predicted);
          EXPECT_GT(test.p_value, alpha) << test.statistic << " of " << test.degrees << " degrees of freedom"
                                         << worst_bins(counts, predicted);
        } else {
          EXPECT_LT(total, 1e-6);
        }
        // Delta parts are chosen as often as they say.
        if (roughness == 0)
          for (const auto& [part, seen] : delta) {
            const double p = part[3];
            EXPECT_NEAR(seen / kDraws, p, 5 * std::sqrt(p * (1 - p) / kDraws) + 1e-6);
          }
      }
  }
  std::printf("integrals of pdf agree with the samples within %.2g beyond noise\n", std::max(worst_total, 0.0));
}

TEST(BsdfSampling, M1_samples_of_smooth_surfaces_have_the_density_that_pdf_states) { check_sampling(0); }
TEST(BsdfSampling, M1_samples_of_roughness_05_have_the_density_that_pdf_states) { check_sampling(0.05F); }
TEST(BsdfSampling, M1_samples_of_roughness_3_have_the_density_that_pdf_states) { check_sampling(0.3F); }
TEST(BsdfSampling, M1_samples_of_the_roughest_surfaces_have_the_density_that_pdf_states) { check_sampling(1); }

TEST(BsdfSampling, M1_samples_of_roughness_3_with_energy_compensation_have_the_density_that_pdf_states) {
  check_sampling(0.3F, true);
}
TEST(BsdfSampling, M1_samples_of_the_roughest_surfaces_with_energy_compensation_have_the_density_that_pdf_states) {
  check_sampling(1, true);
}

TEST(BsdfSampling, M1_uniform_scattering_of_lambert_has_its_density) {
  const auto all = specimens(1);
  std::mt19937 random(9);
  const Direction wo = from_angle(45, 0.1);
  const Bins bins({0, 0, 1}, {0, 0, -1}, false);
  Queries q;
  q.draw(kDraws, 0, wo, random);
  const Answers sampled = scatter(all, q, true);
  std::vector<double> observed(Bins::kCount, 0), expected(Bins::kCount, 0);
  for (std::size_t bin = 0; bin < Bins::kCount / 2; ++bin) {
    std::vector<Bins::Point> points;
    bins.add_points({bin}, points);
    for (const auto& point : points) expected[bin] += kDraws * point.solid_angle / (2 * std::numbers::pi);
  }
  for (unsigned i = 0; i < kDraws; ++i) {
    const Sampled s = sampled.sample(i);
    ++observed[bins.index(s.wi)];
    ASSERT_FLOAT_EQ(float(s.pdf), float(0.5 / std::numbers::pi));
    for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(s.weight[c] * s.pdf, s.eval[c], 1e-6);
  }
  EXPECT_GT(chi_square(observed, expected).p_value, kSignificance);
}

}  // namespace
}  // namespace eikon::test
