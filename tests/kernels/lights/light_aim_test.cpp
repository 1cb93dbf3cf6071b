// SPDX-License-Identifier: Apache-2.0
// Where light paths are aimed, by what a trial has learned: directions and places come as densely
// as they are said to, whatever the tables are, and targets and bins as often as the host takes
// them for.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <random>
#include <span>

#include "kernels/lights/light_path_probe.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

constexpr std::size_t kStarts = 1 << 17;
constexpr std::size_t kSubdivision = 32;  // rows and columns of a cell, where its expected count is summed up

/// Two that overlap, one apart, and one that holds the first of kPoints.
const std::vector<float4> kBalls = {
    {0, 0, 0, 0.9F}, {0.7F, 0.2F, -0.1F, 0.6F}, {-1.5F, 1.2F, 0.4F, 0.7F}, {2.5F, 2, 1.5F, 0.8F}};
const glm::dvec3 kPoints[] = {{2.3, 2.1, 1.7}, {0.4, -1.6, 0.6}, {-2.4, 2.0, -1.2}};
const glm::dvec3 kSunDirections[] = {{0, 0, -1}, {0.6, 0.64, 0.48}, {-0.36, 0.48, 0.8}};

/// Bins and weights without order, a bin that has nearly everything, and a target that nothing is
/// known of.
LightAim some_aim() {
  std::mt19937 random(5);
  std::vector<AimedTarget> targets(kAimKinds * kBalls.size());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    targets[i].weight = 0.3 + 3.0 * double(uniform(random));
    for (double& bin : targets[i].bins) bin = random() % 3 == 0 ? 0 : double(uniform(random));
  }
  for (const std::size_t kind : {EK_AIM_CONE, EK_AIM_DISC}) {
    targets[2 + kind].bins[19] = 500;
    targets[4 + kind].bins = {};
  }
  return make_light_aim(targets, {1, 1});
}

/// Inputs of items that have the same vector, and more that is to be filled in.
std::vector<Words> with_vector(const glm::dvec3& v, std::size_t count) {
  std::vector<Words> in(3);
  for (std::size_t k = 0; k < 3; ++k) in[k].assign(count, as_word(float(v[int(k)])));
  in.resize(6);
  return in;
}
void put_vector(std::vector<Words>& in, const glm::dvec3& v) {
  for (std::size_t k = 0; k < 3; ++k) in[3 + k].push_back(as_word(float(v[int(k)])));
}

std::vector<Words> starts_from(const Probe& probe, const char* kernel, const glm::dvec3& v, std::mt19937& random) {
  std::vector<Words> in = with_vector(v, kStarts);
  for (std::size_t i = 0; i < kStarts; ++i)
    for (std::size_t k = 3; k < 6; ++k) in[k].push_back(as_word(uniform(random)));
  return probe.run(kernel, in, 5);
}

/// Axes across a direction, which need not be those of the kernels.
std::array<glm::dvec3, 2> axes_across(const glm::dvec3& dir) {
  const glm::dvec3 aside = std::abs(dir.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 x = glm::normalize(glm::cross(aside, dir));
  return {x, glm::cross(dir, x)};
}

/// A map of the unit square that keeps area but for a constant, and its cells.
struct SphereCells {
  static constexpr std::size_t kRows = 48, kColumns = 96;
  double area = 4 * std::numbers::pi;
  explicit SphereCells(const glm::dvec3& /*from*/) {}
  [[nodiscard]] glm::dvec3 at(double u, double v) const {
    const double z = 1 - 2 * u, r = std::sqrt(std::max(1 - z * z, 0.0)), phi = 2 * std::numbers::pi * v;
    return {r * std::cos(phi), r * std::sin(phi), z};
  }
  [[nodiscard]] std::size_t cell(const glm::dvec3& dir) const {
    const double turn = std::atan2(dir.y, dir.x) / (2 * std::numbers::pi);
    return cell_of_unit(0.5 - 0.5 * dir.z, kRows) * kColumns + cell_of_unit(turn < 0 ? turn + 1 : turn, kColumns);
  }
  static std::size_t cell_of_unit(double u, std::size_t count) {
    return std::min(std::size_t(std::max(u, 0.0) * double(count)), count - 1);
  }
};
struct PlaneCells {
  static constexpr std::size_t kRows = 64, kColumns = 64;
  static constexpr double kSide = 8;  // holds all targets
  double area = kSide * kSide;
  std::array<glm::dvec3, 2> axes;
  explicit PlaneCells(const glm::dvec3& dir) : axes(axes_across(dir)) {}
  [[nodiscard]] glm::dvec3 at(double u, double v) const { return kSide * ((u - 0.5) * axes[0] + (v - 0.5) * axes[1]); }
  [[nodiscard]] std::size_t cell(const glm::dvec3& p) const {
    return SphereCells::cell_of_unit(glm::dot(p, axes[0]) / kSide + 0.5, kRows) * kColumns +
           SphereCells::cell_of_unit(glm::dot(p, axes[1]) / kSide + 0.5, kColumns);
  }
};

/// Compares what starts with the integral of their density.
template <class Space>
void expect_starts_as_dense_as_stated(const char* start, const char* density, std::span<const glm::dvec3> given) {
  const Probe probe = light_path_probe(kBalls, some_aim());
  std::mt19937 random(14);
  for (const glm::dvec3& v : given) {
    const Space space(v);
    const std::size_t rows = kSubdivision * Space::kRows, columns = kSubdivision * Space::kColumns;
    std::vector<Words> asked = with_vector(v, rows * columns);
    for (std::size_t row = 0; row < rows; ++row)
      for (std::size_t column = 0; column < columns; ++column) {
        const double u = double(row) + double(uniform(random)), w = double(column) + double(uniform(random));
        put_vector(asked, space.at(u / double(rows), w / double(columns)));
      }
    const std::vector<Words> stated = probe.run(density, asked, 1);
    std::vector<double> expected(Space::kRows * Space::kColumns), observed(expected.size());
    double all = 0;
    for (std::size_t i = 0; i < rows * columns; ++i) {
      const double share = double(as_float(stated[0][i])) * space.area / double(rows * columns);
      expected[i / columns / kSubdivision * Space::kColumns + i % columns / kSubdivision] += share * double(kStarts);
      all += share;
    }
    EXPECT_NEAR(all, 1, 2e-3) << "it is no density";
    const std::vector<Words> out = starts_from(probe, start, v, random);
    for (std::size_t i = 0; i < kStarts; ++i) {
      ++observed[space.cell(glm::dvec3(as_float(out[0][i]), as_float(out[1][i]), as_float(out[2][i])))];
      ASSERT_GT(as_float(out[3][i]), 0.0F) << "a start that has no density";
    }
    for (double& count : expected) count += 1e-9;  // cells that a rim grazes are pooled with others
    const ChiSquare test = chi_square(observed, expected);
    EXPECT_GT(test.p_value, sidak(6)) << start << ": " << test.statistic << " of " << test.degrees;
  }
}

TEST(LightAim, directions_come_as_densely_as_stated) {
  expect_starts_as_dense_as_stated<SphereCells>("probe_target_directions", "probe_target_pdf_sr", kPoints);
}

TEST(LightAim, places_come_as_densely_as_stated) {
  expect_starts_as_dense_as_stated<PlaneCells>("probe_target_origins", "probe_parallel_pdf_m2", kSunDirections);
}

/// Probability of each start, by the host: of targets by weights times cones over 2 pi or squared
/// radii, of bins by the table.
std::vector<double> probabilities(const LightAim& aim, std::uint32_t kind, const std::vector<double>& sizes) {
  std::vector<double> shares(EK_AIM_STARTS);
  double all = 0;
  for (std::uint32_t target = 0; target < sizes.size(); ++target)
    for (std::uint32_t bin = 0; bin < EK_GUIDE_BINS; ++bin) {
      const std::uint32_t start = EK_AIM_START(target, kind, bin);
      all += shares[start] = sizes[target] * aim.density(start);
    }
  for (double& share : shares) share /= all;
  return shares;
}

void expect_probabilities(const std::vector<double>& shares, const Words& starts) {
  std::vector<double> expected, observed(shares.size());
  for (const double share : shares) expected.push_back(share * double(kStarts));
  for (const std::uint32_t start : starts) ++observed[start];
  const ChiSquare test = chi_square(observed, expected);
  EXPECT_GT(test.p_value, sidak(6)) << test.statistic << " of " << test.degrees;
}

TEST(LightAim, targets_and_bins_are_chosen_as_the_host_has_it) {
  const LightAim aim = some_aim();
  const Probe probe = light_path_probe(kBalls, aim);
  std::mt19937 random(14);
  for (const glm::dvec3& from : kPoints) {
    std::vector<double> cones;
    for (const float4& ball : kBalls) {
      const double sine = double(ball.w) / glm::length(glm::dvec3(ball.x, ball.y, ball.z) - from);
      cones.push_back(sine < 1 ? 1 - std::sqrt(1 - sine * sine) : 2);
    }
    expect_probabilities(probabilities(aim, EK_AIM_CONE, cones),
                         starts_from(probe, "probe_target_directions", from, random)[4]);
  }
  for (const glm::dvec3& dir : kSunDirections) {
    std::vector<double> squares;
    for (const float4& ball : kBalls) squares.push_back(double(ball.w) * double(ball.w));
    expect_probabilities(probabilities(aim, EK_AIM_DISC, squares),
                         starts_from(probe, "probe_target_origins", dir, random)[4]);
  }
}

}  // namespace
}  // namespace eikon::test
