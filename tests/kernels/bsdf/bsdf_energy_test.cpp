// SPDX-License-Identifier: Apache-2.0
// --energy-compensation: what single scattering between microfacets loses comes back, no more and
// no less.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kernels/bsdf/bsdf_probe.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

/// What a specimen under even light shows along wo, in units of that light; radiance beyond a
/// refracting surface is eta^2 of it.
Mean furnace(const Specimen& specimen, const Direction& wo, bool compensated, unsigned seed) {
  constexpr int kSamples = 100000;
  std::mt19937 random(seed);
  Queries q;
  q.compared = 1024;
  q.draw(kSamples, 0, wo, random);
  const Answers answers = scatter({specimen}, q, false, specimen.material.roughness_x >= 0, compensated);
  std::vector<double> shown;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Sampled s = answers.sample(i);
    const double beyond = s.wi[2] < 0 && specimen.material.solid ? specimen.eta() * specimen.eta() : 1;
    shown.push_back(s.pdf > 0 ? s.weight[0] * beyond : 0);
  }
  return mean_of(shown);
}

void check_furnace(const Specimen& made, double bound, double bound_at_grazing) {
  double worst = 0, without = 1;
  unsigned seed = 1;
  for (const float roughness : {0.0F, 0.1F, 0.2F, 0.35F, 0.5F, 0.7F, 0.85F, 1.0F})
    for (const double angle : {0.0, 30.0, 60.0, 80.0, 87.0, 89.5}) {
      Specimen specimen = made;
      specimen.material.roughness = roughness;
      const Direction wo = from_angle(angle, 0.1);
      const Mean m = furnace(specimen, wo, true, seed++);
      SCOPED_TRACE(made.name + ", roughness " + std::to_string(roughness) + ", " + std::to_string(angle) + " degrees");
      EXPECT_NEAR(m.mean, 1, 4 * m.standard_error + (angle > 85 ? bound_at_grazing : bound));
      worst = std::max(worst, std::abs(m.mean - 1));
      if (roughness == 1) without = std::min(without, furnace(specimen, wo, false, seed).mean);
    }
  std::printf("%s: within %.4f of 1; at roughness 1 without compensation as little as %.3f\n", made.name.c_str(), worst,
              without);
}

TEST(EnergyCompensation, M4_white_metal_cannot_be_seen_in_the_white_furnace) {
  check_furnace({"white metal", kLobe_metallic_roughness, {.metallic = 1}}, 0.005, 0.005);
  ProbeMaterial perfect{.metallic = 1};
  perfect.eta = {1, 1, 1};
  perfect.k = {16384, 16384, 16384};
  check_furnace({"conductor that reflects everything", kLobe_conductor, perfect}, 0.005, 0.005);
}

TEST(EnergyCompensation, M4_clear_glass_cannot_be_seen_in_the_white_furnace_from_either_side) {
  ProbeMaterial glass{.transmission = 1};
  glass.solid = true;
  for (const float ior : {1.2F, 1.5F, 2.4F})
    for (const bool front : {true, false}) {
      glass.ior = ior;
      check_furnace(
          {"glass of index " + std::to_string(ior) + (front ? "" : ", from inside"), kLobe_transmission, glass, front},
          0.01, 0.02);
    }
  check_furnace({"pane", kLobe_transmission, {.transmission = 1}}, 0.005, 0.005);
}

TEST(EnergyCompensation, coloured_metal_darkens_where_light_meets_it_more_than_once) {
  ProbeMaterial gold{.base_color = {0.5F, 0.5F, 0.5F}, .metallic = 1, .roughness = 1};
  const Specimen specimen{"half reflecting metal", kLobe_metallic_roughness, gold};
  const Mean m = furnace(specimen, {0, 0, 1}, true, 5), single = furnace(specimen, {0, 0, 1}, false, 6);
  // Each further reflection is by the mean reflectance f; a share of 1 - .4091 (the mean albedo)
  // goes on to the next one.
  const double f = 0.5 + 0.5 / 21, lost = 1 - 0.4091;
  const double more = f * f * (1 - lost) / (1 - f * lost) * (1 - 0.306852819);
  EXPECT_NEAR(m.mean - single.mean, more, 4 * (m.standard_error + single.standard_error) + 2e-3);
}

TEST(EnergyCompensation, brushed_metal_is_nearly_as_bright_as_its_surroundings) {
  for (const auto& [x, y] :
       {std::pair(1.0F, 0.3F), std::pair(1.0F, 0.6F), std::pair(0.7F, 0.2F), std::pair(1.0F, 0.05F)})
    for (const double angle : {0.0, 30.0, 60.0, 80.0})
      for (const double turn : {0.0, 0.125, 0.25}) {
        ProbeMaterial material{.metallic = 1, .roughness = y};
        material.roughness_x = x;
        const Mean m = furnace({"brushed", kLobe_metallic_roughness, material}, from_angle(angle, turn), true, 7);
        // The tables say at most .11 too little is lost, and the mean at most .0055 too little, in
        // parts of what is lost (tools/tables/make_anisotropy_table.py --check).
        SCOPED_TRACE(std::to_string(x) + " " + std::to_string(y) + ", " + std::to_string(angle) +
                     " degrees, turned by " + std::to_string(turn));
        EXPECT_LE(m.mean, 1 + 4 * m.standard_error + 0.012);
        EXPECT_GE(m.mean, 1 - 0.11 - 4 * m.standard_error);
      }
}

// Directions differ more than their mean does, as the tables are those of isotropic glass that
// loses as much.
TEST(EnergyCompensation, brushed_glass_loses_a_twentieth_in_the_mean_where_it_lost_a_third) {
  for (const auto& [x, y] :
       {std::pair(0.9F, 0.05F), std::pair(0.91F, 0.3F), std::pair(0.73F, 0.3F), std::pair(1.0F, 0.7F)}) {
    ProbeMaterial glass{.roughness = y, .transmission = 1};
    glass.solid = true;
    glass.ior = 1.5F;
    glass.roughness_x = x;
    double shown = 0, weight = 0;
    for (const double angle : {5.0, 15.0, 25.0, 35.0, 45.0, 55.0, 65.0, 75.0, 85.0})
      for (const double turn : {0.0, 0.125, 0.25}) {
        const Mean m = furnace({"brushed glass", kLobe_transmission, glass}, from_angle(angle, turn), true, 8);
        const double solid = std::sin(2 * angle * std::numbers::pi / 180) * (turn == 0.125 ? 2 : 1);
        shown += solid * m.mean, weight += solid;
        EXPECT_LE(m.mean, 1.2) << x << " " << y << ", " << angle << " degrees, turned by " << turn;
      }
    EXPECT_NEAR(shown / weight, 0.99, 0.04) << x << " " << y;
  }
}

}  // namespace
}  // namespace eikon::test
