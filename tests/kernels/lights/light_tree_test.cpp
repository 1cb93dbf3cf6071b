// SPDX-License-Identifier: Apache-2.0
// The tree of lights as kernels walk it: what it chooses, with which probability, and that both
// agree.
#include "pack/lights/light_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kernels/probe.h"
#include "kernels/statistics.h"
#include "support/random.h"

namespace eikon::test {
namespace {

/// A point that light arrives at, and its normal.
struct Place {
  glm::dvec3 p, n;
  bool both_sides = false;
};

/// Small lamps between 0 and 10 m in every direction, facing anywhere; some are points or closed.
std::vector<LightMoments> lamps(std::size_t count, double decades) {
  std::mt19937 random(2);
  std::vector<LightMoments> lights(count);
  for (LightMoments& l : lights) {
    l.power = std::pow(10.0, decades * (uniform(random) - 0.5));
    l.centroid = glm::dvec3(uniform(random), uniform(random), uniform(random)) * 10.0;
    l.variance = random() % 4 == 0 ? 0 : 1e-3 * uniform(random);
    if (random() % 4 != 0) l.mean_direction = random_direction(random);
  }
  return lights;
}

/// Among the lights, at one, far from all, and where most are below the horizon.
std::vector<Place> places(const std::vector<LightMoments>& lights) {
  const glm::dvec3 oblique = glm::normalize(glm::dvec3(1, -2, 0.5));
  return {{{5, 5, 5}, {0, 0, 1}},      {{5, 5, 5}, oblique, true}, {lights[0].centroid, oblique},
          {{1e4, -3e3, 2e3}, oblique}, {{5, 5, 9.9}, {0, 0, 1}},   {{5, 5, 40}, {0, 0, 1}},
          {{0, 0, 0}, {0.6, -0.8, 0}}};
}

struct Choices {
  Words light;
  std::vector<float> probability, u, asked, asked_of;
};

/// One sample per word a at a place; asked_of: the probability of light of[i] there.
Choices choose(const LightTree& tree, const Place& place, const Words& a, const Words& b, const Words& of) {
  std::vector<Words> in{a, b};
  for (const glm::dvec3& v : {place.p, place.n})
    for (int k = 0; k < 3; ++k) in.emplace_back(a.size(), as_word(float(v[k])));
  in.emplace_back(a.size(), place.both_sides ? 1U : 0U);
  in.push_back(of);
  const auto out = Probe("light")
                       .define("EK_HAS_light_tree", "1")
                       .buffer("light_nodes", tree.nodes)
                       .value("light_count", std::uint32_t(tree.order.size()))
                       .value("scale", as_word(tree.scale))
                       .run("probe_light_tree", in, 5);
  Choices c;
  c.light = out[0];
  for (std::size_t i = 0; i < a.size(); ++i) {
    c.probability.push_back(as_float(out[1][i]));
    c.u.push_back(as_float(out[2][i]));
    c.asked.push_back(as_float(out[3][i]));
    c.asked_of.push_back(as_float(out[4][i]));
  }
  return c;
}

Words one_of_each(std::size_t count) {
  Words all(count);
  for (std::uint32_t i = 0; i < count; ++i) all[i] = i;
  return all;
}

TEST(LightTree, the_probability_of_a_choice_is_what_is_asked_for_later_bit_for_bit) {
  std::mt19937 random(3);
  for (const auto& lights : {lamps(2, 1), lamps(300, 4), lamps(5000, 20)}) {
    const LightTree tree = build_light_tree(lights);
    for (const Place& place : places(lights)) {
      Words a = random_words(random, 4096), b = random_words(random, 4096);
      a[0] = 0, a[1] = 0xffffffffU, a[2] = 0xfffffffeU, b[0] = 0xffffffffU;  // N2
      const Choices c = choose(tree, place, a, b, Words(a.size(), 0));
      for (std::size_t i = 0; i < a.size(); ++i) {
        ASSERT_LT(c.light[i], lights.size());
        ASSERT_TRUE(c.probability[i] > 0 && c.probability[i] <= 1) << c.probability[i];
        ASSERT_EQ(as_word(c.probability[i]), as_word(c.asked[i])) << "light " << c.light[i];
        ASSERT_TRUE(c.u[i] >= 0 && c.u[i] < 1) << c.u[i];
      }
    }
  }
}

TEST(LightTree, L16_probabilities_add_to_one_at_any_point_and_none_is_zero) {
  std::vector<std::vector<LightMoments>> scenes{lamps(2, 1), lamps(3, 30), lamps(1000, 4), lamps(100000, 20)};
  scenes.back()[54321].power = 1e30;
  for (const auto& lights : scenes) {
    const LightTree tree = build_light_tree(lights);
    const Words words(lights.size(), 0);
    for (const Place& place : places(lights)) {
      const Choices c = choose(tree, place, words, words, one_of_each(lights.size()));
      double sum = 0;
      for (const float p : c.asked_of) {
        ASSERT_GT(p, 0);
        sum += double(p);
      }
      EXPECT_NEAR(sum, 1, 1e-5) << lights.size() << " lights";
    }
  }
}

TEST(LightTree, lights_are_chosen_as_often_as_said_and_what_is_left_of_the_word_is_uniform) {
  std::mt19937 random(4);
  const auto lights = lamps(200, 4);
  const LightTree tree = build_light_tree(lights);
  const auto where = places(lights);
  const double alpha = sidak(2 * where.size());
  for (const Place& place : where) {
    const Words a = random_words(random, 1 << 19), b = random_words(random, a.size());
    Words of(a.size(), 0);
    for (std::uint32_t i = 0; i < lights.size(); ++i) of[i] = i;
    const Choices c = choose(tree, place, a, b, of);
    std::vector<double> chosen(lights.size(), 0), expected, cells(64, 0);
    for (std::size_t i = 0; i < lights.size(); ++i) expected.push_back(double(c.asked_of[i]) * double(a.size()));
    for (std::size_t i = 0; i < a.size(); ++i) {
      ++chosen[c.light[i]];
      ++cells[std::size_t(c.u[i] * 64)];
    }
    const ChiSquare choice = chi_square(chosen, expected);
    EXPECT_GT(choice.p_value, alpha) << choice.table;
    EXPECT_GT(chi_square(cells, std::vector<double>(64, double(a.size()) / 64)).p_value, alpha);
  }
}

// Chosen so rarely that its range of words is widened by random bits on the way.
TEST(LightTree, an_unlikely_light_is_chosen_as_often_as_said_and_sampled_all_over) {
  std::mt19937 random(5);
  auto lights = lamps(4000, 0);
  for (LightMoments& l : lights) l.centroid.z = 0;
  const LightTree tree = build_light_tree(lights);
  const Place place{{5, 5, 0.5}, {0, 0, -1}};
  const Words a = random_words(random, 1 << 21), b = random_words(random, a.size());
  Words of(a.size(), 0);
  for (std::uint32_t i = 0; i < lights.size(); ++i) of[i] = i;
  const Choices c = choose(tree, place, a, b, of);
  std::vector<double> chosen(lights.size(), 0), expected, cells(16, 0);
  double rare = 0;
  for (std::size_t i = 0; i < lights.size(); ++i) expected.push_back(double(c.asked_of[i]) * double(a.size()));
  for (std::size_t i = 0; i < a.size(); ++i) {
    ++chosen[c.light[i]];
    if (c.probability[i] > 0x1p-13F) continue;
    ++rare;
    ++cells[std::size_t(c.u[i] * 16)];
  }
  ASSERT_GT(rare, 10000) << "nothing was widened";
  EXPECT_GT(chi_square(chosen, expected).p_value, sidak(2));
  EXPECT_GT(chi_square(cells, std::vector<double>(16, rare / 16)).p_value, sidak(2));
}

TEST(LightTree, strata_of_the_word_are_strata_of_the_lights) {
  const auto lights = lamps(500, 2);
  const LightTree tree = build_light_tree(lights);
  Words a;
  for (std::uint32_t k = 0; k < 4096; ++k) a.push_back(k << 20);
  const Choices c = choose(tree, places(lights)[0], a, Words(a.size(), 0), Words(a.size(), 0));
  for (std::size_t i = 1; i < a.size(); ++i) ASSERT_GE(c.light[i], c.light[i - 1]) << "lights are chosen in order";
}

// What the tree is for: near lights are preferred, and those that face away or lie below the
// horizon hardly ever chosen.
TEST(LightTree, light_that_arrives_is_what_is_chosen) {
  std::vector<LightMoments> lights(4);
  for (LightMoments& l : lights) l.power = 1, l.variance = 1e-4, l.mean_direction = {0, 0, -1};
  lights[0].centroid = {0, 0, 1};                               // above, facing down
  lights[1].centroid = {0, 0, 10};                              // the same, ten times as far
  lights[2].centroid = {1, 0, 1}, lights[2].mean_direction = {0, 0, 1};   // facing away
  lights[3].centroid = {0, 1, -1}, lights[3].mean_direction = {0, 0, 1};  // below the surface
  const LightTree tree = build_light_tree(lights);
  std::vector<double> p(4);
  const Choices c = choose(tree, {{0, 0, 0}, {0, 0, 1}}, Words(4, 0), Words(4, 0), one_of_each(4));
  for (std::size_t leaf = 0; leaf < 4; ++leaf) p[tree.order[leaf]] = double(c.asked_of[leaf]);
  EXPECT_GT(p[0], 0.95);
  EXPECT_GT(p[1], 1e-3);
  EXPECT_LT(p[2], 0.01);
  EXPECT_LT(p[3], 0.01);
}

}  // namespace
}  // namespace eikon::test
