// SPDX-License-Identifier: Apache-2.0
#include "image/tonemap.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace eikon {
namespace {

constexpr std::array kMaps = {ToneMap::reinhard, ToneMap::aces, ToneMap::agx, ToneMap::pbr_neutral};

void expect_near(const glm::dvec3& found, const glm::dvec3& expected, double tolerance, const std::string& what) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], tolerance) << what << ", channel " << c;
}

TEST(ToneMap, names_are_those_of_the_command_line) {
  EXPECT_EQ(tone_map_of("none"), ToneMap::none);
  EXPECT_EQ(tone_map_of("reinhard"), ToneMap::reinhard);
  EXPECT_EQ(tone_map_of("aces"), ToneMap::aces);
  EXPECT_EQ(tone_map_of("agx"), ToneMap::agx);
  EXPECT_EQ(tone_map_of("pbr-neutral"), ToneMap::pbr_neutral);
  EXPECT_FALSE(tone_map_of("filmic"));
}

// Worked out from the published formulas by another program, with matrices, logarithms and powers
// of its own.
TEST(ToneMap, each_has_the_values_of_its_paper) {
  struct Row {
    glm::dvec3 linear, reinhard, aces, agx, neutral;
  };
  const Row table[] = {
      {{.18, .18, .18},
       {.152542373, .152542373, .152542373},
       {.105591247, .105591247, .105590191},
       {.214548629, .214502356, .214499165},
       {.14, .14, .14}},
      {{1, 1, 1},
       {.5, .5, .5},
       {.619115427, .619115427, .619109236},
       {.590229442, .590136120, .590102344},
       {.869090909, .869090909, .869090909}},
      {{.5, .25, .125},
       {.386361441, .193180721, .096590360},
       {.366705719, .172954975, .074148394},
       {.435599885, .273721439, .177855586},
       {.46, .21, .085}},
      {{4, 1, .25},
       {1.548197318, .387049329, .096762332},
       {.994891084, .663380620, .316684548},
       {.936479994, .623566894, .437369438},
       {.983255814, .468299174, .339560014}},
      {{0, 0, 20},
       {0, 0, 8.183306056},
       {.782145281, .181131311, 1},
       {.624351022, .763642225, 1},
       {.738100713, .738100713, .997043121}},
      {{.02, .3, .6},
       {.015846203, .237693046, .475386093},
       {0, .209303300, .419964336},
       {.099658358, .334743979, .495476574},
       {.0025, .2825, .5825}},
  };
  for (const Row& row : table) {
    const std::string at =
        std::to_string(row.linear.x) + "," + std::to_string(row.linear.y) + "," + std::to_string(row.linear.z);
    expect_near(tone_map(ToneMap::none, row.linear), row.linear, 0, "none " + at);
    expect_near(tone_map(ToneMap::reinhard, row.linear), row.reinhard, 1e-8, "reinhard " + at);
    expect_near(tone_map(ToneMap::aces, row.linear), row.aces, 1e-8, "aces " + at);
    expect_near(tone_map(ToneMap::agx, row.linear), row.agx, 1e-8, "agx " + at);
    expect_near(tone_map(ToneMap::pbr_neutral, row.linear), row.neutral, 1e-8, "pbr-neutral " + at);
  }
}

TEST(ToneMap, black_stays_black_and_what_is_below_counts_as_black) {
  for (const ToneMap map : kMaps) {
    // AgX and the ACES fit leave a trace: the first step of 8 bits in sRGB is 1.5e-4.
    expect_near(tone_map(map, glm::dvec3(0)), glm::dvec3(0), 1.5e-4, "black");
    EXPECT_EQ(tone_map(map, glm::dvec3(-3, -1, -1e9)), tone_map(map, glm::dvec3(0)));
  }
}

TEST(ToneMap, grey_is_monotone_from_black_to_white_and_stays_grey) {
  for (const ToneMap map : kMaps) {
    double previous = -1;
    for (double stop = -16; stop <= 24; stop += 0.01) {
      const glm::dvec3 shown = tone_map(map, glm::dvec3(std::exp2(stop)));
      // The fit of AgX's curve falls by some 1e-4 below its first stop, which no 8 bits show.
      ASSERT_GE(shown.y, previous - 1e-4) << stop << " stops, map " << int(map);
      ASSERT_NEAR(shown.x, shown.y, 3e-4) << stop;
      ASSERT_NEAR(shown.z, shown.y, 3e-4) << stop;
      previous = shown.y;
    }
    EXPECT_GT(previous, 0.98) << int(map);
    EXPECT_LE(previous, 1) << int(map);
  }
}

// The promise of its name: a base colour under white light of radiance 1 comes out as it is, less
// what a dielectric's surface adds to it.
TEST(ToneMap, pbr_neutral_keeps_base_colours) {
  for (double r = 0.08; r <= 0.8; r += 0.09)
    for (double g = 0.08; g <= 0.8; g += 0.09)
      for (double b = 0.08; b <= 0.8; b += 0.09) {
        const glm::dvec3 colour(r, g, b);
        expect_near(tone_map(ToneMap::pbr_neutral, colour), colour - 0.04, 1e-15, "base colour");
      }
  // And goes on without a step where compression begins.
  const glm::dvec3 hue(1, 0.6, 0.3);
  expect_near(tone_map(ToneMap::pbr_neutral, hue * (0.8 + 1e-9)), tone_map(ToneMap::pbr_neutral, hue * (0.8 - 1e-9)),
              1e-8, "at the shoulder");
}

TEST(ToneMap, reinhard_keeps_the_ratios_of_a_colour) {
  const glm::dvec3 shown = tone_map(ToneMap::reinhard, {6, 3, 1.5});
  EXPECT_DOUBLE_EQ(shown.x / shown.y, 2);
  EXPECT_DOUBLE_EQ(shown.y / shown.z, 2);
}

TEST(ToneMap, the_brightest_that_floats_hold_is_finite) {
  for (const ToneMap map : kMaps)
    for (const glm::dvec3& colour : {glm::dvec3(1e38), glm::dvec3(1e38, 0, 0), glm::dvec3(1e57, 1e57, 0)}) {
      const glm::dvec3 shown = tone_map(map, colour);
      for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(shown[c]) && shown[c] >= 0) << int(map);
    }
}

}  // namespace
}  // namespace eikon
