// SPDX-License-Identifier: Apache-2.0
#include "guide/learner.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace eikon::test {
namespace {

/// A log that is written by hand, one path after the other.
struct Log {
  explicit Log(std::size_t count) : paths(count), words(std::size_t{EK_LOG_DEPTHS} * LOG_WORDS * count, 0) {}
  void set(std::size_t path, std::uint32_t vertex, std::uint32_t which, std::uint32_t value) {
    words[(std::size_t{vertex} * LOG_WORDS + which) * paths + path] = value;
  }
  void set(std::size_t path, std::uint32_t vertex, std::uint32_t which, float value) {
    set(path, vertex, which, std::bit_cast<std::uint32_t>(value));
  }
  [[nodiscard]] PathLog view() const { return {.words = words, .radiance = {}, .paths = paths, .stride = paths}; }
  std::size_t paths;
  std::vector<std::uint32_t> words;
};

constexpr std::uint32_t kGoesOn = LOG_HIT | LOG_GUIDED | LOG_CONTINUES;

float indirect_of(const GuideTable& table, std::size_t cell = 0) {
  return std::bit_cast<float>(table.cells[cell * EK_GUIDE_CELL_WORDS + GUIDE_indirect]);
}

TEST(GuideWeights, add_up_and_keep_a_least_weight) {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    std::array<double, EK_GUIDE_BINS> target{};
    for (double& t : target) t = random() % 4 == 0 ? 0 : std::pow(double(random()), double(i % 7));
    const auto weights = guide_weights(target);
    EXPECT_EQ(std::accumulate(weights.begin(), weights.end(), 0U), EK_GUIDE_TOTAL);
    for (const std::uint32_t w : weights) EXPECT_TRUE(w >= EK_GUIDE_TOTAL / EK_GUIDE_BINS / 4 && w < 65536) << w;
  }
  for (const std::uint32_t w : guide_weights({})) EXPECT_EQ(w, EK_GUIDE_TOTAL / EK_GUIDE_BINS) << "no preference";
}

TEST(Learner, learns_the_light_that_a_path_meets_next) {
  // From a cell of a wall, through a mirror of reflectance one half, to a lamp.
  Log log(64);
  for (std::size_t path = 0; path < log.paths; ++path) {
    log.set(path, 0, LOG_info, kGoesOn | std::uint32_t(path));  // each bin once
    log.set(path, 0, LOG_xy, 5U);
    log.set(path, 0, LOG_albedo, 0.5F);
    log.set(path, 0, LOG_sampled, 0.25F);
    log.set(path, 1, LOG_info, LOG_HIT | LOG_CONTINUES);
    log.set(path, 1, LOG_weight, 0.5F);
    log.set(path, 2, LOG_info, LOG_HIT);
    log.set(path, 2, LOG_emitted, path < 32 ? 3.0F : 1.0F);
  }
  GuideLearner learner(1, 1);
  learner.add(log.view());
  learner.end_round();
  const GuideTable table = learner.table();
  ASSERT_EQ(table.cell_count(), 3U) << "one of each level";
  EXPECT_NEAR(indirect_of(table), 1.0F, 1e-4F) << "the mean of 1.5 and 0.5";
  EXPECT_NEAR(std::bit_cast<float>(table.cells[GUIDE_direct]), 0.5F, 1e-4F) << "sampled light over the albedo";
  // Bins with three times the light have more weight, less than three times because of the prior.
  const auto weight = [&](std::size_t bin) {
    return (table.cells[GUIDE_weights + bin / 2] >> (16 * (bin % 2))) & 0xffffU;
  };
  EXPECT_GT(weight(3), weight(40) * 5 / 4);
  EXPECT_LT(weight(3), weight(40) * 3);
}

TEST(Learner, light_spreads_by_one_bounce_a_round) {
  // A path between two cells: the second is lit, the first sees the second alone.
  Log log(1);
  log.set(0, 0, LOG_info, kGoesOn);
  log.set(0, 0, LOG_xy, 100U);
  log.set(0, 1, LOG_info, kGoesOn);
  log.set(0, 1, LOG_xy, 900U);
  log.set(0, 1, LOG_albedo, 0.5F);
  log.set(0, 2, LOG_info, LOG_MISS);
  log.set(0, 2, LOG_emitted, 2.0F);
  GuideLearner learner(1, 1);
  const auto cell_of = [&](std::uint32_t xy) {
    // Cells are sorted by id, and those of level 0 come first.
    return indirect_of(learner.table(), xy == 100 ? 0 : 1);
  };
  learner.add(log.view());
  learner.end_round();
  EXPECT_NEAR(cell_of(900), 2.0F, 1e-4F);
  EXPECT_EQ(cell_of(100), 0.0F);
  learner.add(log.view());
  learner.end_round();
  EXPECT_NEAR(cell_of(100), 1.0F, 1e-4F) << "the albedo of the second cell times what arrives there";
}

TEST(Learner, a_sample_counts_for_a_bounded_amount_whatever_it_is) {
  const auto learned = [](float emitted) {
    Log log(6400);
    for (std::size_t path = 0; path < log.paths; ++path) {
      log.set(path, 0, LOG_info, kGoesOn | std::uint32_t(path % EK_GUIDE_BINS));
      log.set(path, 0, LOG_xy, 5U);
      log.set(path, 0, LOG_albedo, 0.5F);
      log.set(path, 1, LOG_info, LOG_HIT);
      log.set(path, 1, LOG_emitted, path == 0 ? emitted : 1.0F);
    }
    GuideLearner learner(1, 1);
    learner.add(log.view());
    learner.end_round();
    return learner.table();
  };
  constexpr float kMost = 65536;  // of the usual luminance, which is 1 here
  const GuideTable most = learned(kMost);
  EXPECT_LT(indirect_of(learned(1000)), indirect_of(most));
  for (const float more : {2 * kMost, 1e30F, std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(learned(more).digest(), most.digest()) << more;
    EXPECT_TRUE(learned(more).is_sound()) << more;
  }
  // What is no radiance counts for nothing, and leaves the others alone.
  EXPECT_NEAR(indirect_of(learned(std::numeric_limits<float>::quiet_NaN())), 1, 0.01);
  EXPECT_NEAR(indirect_of(learned(-1e30F)), 1, 0.01);
}

TEST(Learner, the_order_of_paths_does_not_matter) {
  std::mt19937 random(2);
  Log log(3000), turned(3000);
  for (std::size_t path = 0; path < log.paths; ++path)
    for (std::uint32_t v = 0; v < 4; ++v) {
      const auto below = [&](std::uint32_t n) { return std::uint32_t(random() % n); };
      const std::uint32_t values[] = {kGoesOn | below(64), below(9), below(5)};
      const float numbers[] = {0.5F, 0.25F, float(below(1000)) * 0.01F, float(below(100))};
      for (Log* each : {&log, &turned}) {
        const std::size_t at = each == &log ? path : log.paths - 1 - path;
        for (std::uint32_t k = 0; k < 3; ++k) each->set(at, v, LOG_info + k, values[k]);
        for (std::uint32_t k = 0; k < 4; ++k) each->set(at, v, LOG_weight + k, numbers[k]);
      }
    }
  const auto digest = [](const Log& of) {
    GuideLearner learner(1, 1);
    for (int round = 0; round < 2; ++round) learner.add(of.view()), learner.end_round();
    return learner.table().digest();
  };
  EXPECT_EQ(digest(log), digest(turned));
  log.set(7, 1, LOG_sampled, 1e4F);
  EXPECT_NE(digest(log), digest(turned)) << "the comparison sees nothing";
}

TEST(Learner, rounds_that_are_kept_count_together) {
  const auto log_of = [](float emitted, std::size_t count) {
    Log log(count);
    for (std::size_t path = 0; path < count; ++path) {
      log.set(path, 0, LOG_info, kGoesOn | std::uint32_t(path % EK_GUIDE_BINS));
      log.set(path, 0, LOG_xy, 5U);
      log.set(path, 0, LOG_albedo, 0.5F);
      log.set(path, 1, LOG_info, LOG_HIT);
      log.set(path, 1, LOG_emitted, emitted);
    }
    return log;
  };
  for (const bool keep : {false, true}) {
    const Log first = log_of(1, 6400), second = log_of(4, 19200);
    GuideLearner learner(1, 1);
    learner.add(first.view());
    learner.end_round(keep);
    EXPECT_NEAR(indirect_of(learner.table()), 1, 0.01);
    learner.add(second.view());
    learner.end_round();
    EXPECT_NEAR(indirect_of(learner.table()), keep ? 0.25 + 3 : 4, 0.05);
  }
}

}  // namespace
}  // namespace eikon::test
