// SPDX-License-Identifier: Apache-2.0
// When --target-error and --time end a render, on films of known error.
#include "job/goal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/clock.h"
#include "support/film_builder.h"

namespace eikon::test {
namespace {

/// An image of independent pixels whose samples have mean 1 and standard deviation `deviation`, in
/// gray.
class NoisyImage {
 public:
  NoisyImage(std::uint32_t side, double deviation, unsigned seed)
      : film_(small_layout(side, side)), deviation_(deviation), random_(seed) {}

  /// Adds samples until each pixel has so many; sums of samples are drawn at once.
  void grow_to(std::uint64_t samples) {
    const std::uint64_t each = (samples - samples_) / 2;
    const std::uint32_t side = film_.layout().width;
    std::normal_distribution<double> normal(double(each), deviation_ * std::sqrt(double(each)));
    for (std::uint32_t y = 0; y < side; ++y)
      for (std::uint32_t x = 0; x < side; ++x)
        for (std::uint32_t replicate = 0; replicate < 2; ++replicate) {
          const auto more = int128(normal(random_) * 0x1p64);
          for (std::uint32_t channel = 0; channel < 3; ++channel)
            film_.set(x, y, replicate, channel, film_.sum(x, y, replicate, channel) + more);
          film_.set_count(x, y, replicate, film_.count(x, y, replicate) + each);
        }
    samples_ = samples;
  }
  [[nodiscard]] const Film& film() const { return film_; }
  [[nodiscard]] double true_relmse() const { return deviation_ * deviation_ / double(samples_) / 1.01; }

 private:
  Film film_;
  double deviation_;
  std::mt19937_64 random_;
  std::uint64_t samples_ = 0;
};

Settings settings_for(std::uint32_t side, std::uint64_t most) {
  Settings settings;
  settings.width = settings.height = side;
  settings.crop = {0, 0, side, side};
  settings.sample_end = most;
  return settings;
}

Goal goal_of(const GoalOptions& options, const Settings& settings, double end_s = 0) {
  return {options, settings, end_s, [](const Film&) { return 0.0; }, [](const std::string&) {}};
}

/// Samples after each round, until the goal ends the render or `most` are done.
/// exact: of RoundEnd; false: nothing is judged
std::vector<std::uint64_t> rounds(const GoalOptions& options, std::uint64_t most, bool exact = true) {
  constexpr std::uint32_t kSide = 8;
  NoisyImage image(kSide, 1, 1);
  Goal goal = goal_of(options, settings_for(kSide, most), host_seconds() + 1e6);
  std::vector<std::uint64_t> ends;
  for (std::uint64_t done = 0; done < most;) {
    const std::uint64_t end = goal.next({done, exact, 0, image.film()}).end;
    if (end == done) break;
    ends.push_back(done = end);
    if (done % 2 == 0) image.grow_to(done);
  }
  return ends;
}

TEST(Goal, judges_four_times_in_each_doubling_from_sixteen_samples_on) {
  const GoalOptions options{.relmse = 1e-2};
  EXPECT_EQ(rounds(options, 70, false), (std::vector<std::uint64_t>{16, 20, 24, 28, 32, 40, 48, 56, 64, 70}));
  EXPECT_EQ(rounds(options, 18), (std::vector<std::uint64_t>{16, 18}));
}

TEST(Goal, leaves_out_judgements_that_cannot_end_the_render) {
  const std::vector<std::uint64_t> ends = rounds({.relmse = 1e-4}, 256);
  ASSERT_GE(ends.size(), 2U);
  EXPECT_EQ(ends[0], 16U);
  EXPECT_GE(ends[1], 96U) << "the error at 16 samples is 600 times the target";
}

TEST(Goal, with_time_the_first_rounds_are_short) {
  EXPECT_EQ(rounds({.seconds = 1}, 100), (std::vector<std::uint64_t>{1, 2, 4, 8, 16, 32, 64, 100}));
  EXPECT_EQ(rounds({.relmse = 1e-2, .seconds = 1}, 24, false), (std::vector<std::uint64_t>{1, 2, 4, 8, 16, 20, 24}));
}

TEST(Goal, an_image_in_which_nothing_was_found_does_not_reach_it) {
  Goal goal = goal_of({.relmse = 1}, settings_for(8, 1024));
  Film black(small_layout(8, 8));
  for (std::uint32_t y = 0; y < 8; ++y)
    for (std::uint32_t x = 0; x < 8; ++x)
      for (std::uint32_t replicate = 0; replicate < 2; ++replicate) black.set_count(x, y, replicate, 32);
  EXPECT_GT(goal.next({64, true, 0, black}).end, 64U);
}

TEST(Goal, a_film_with_more_samples_in_some_pixels_is_not_judged) {
  NoisyImage image(8, 1e-3, 1);
  image.grow_to(32);
  Goal goal = goal_of({.relmse = 1}, settings_for(8, 1024));
  EXPECT_EQ(goal.next({32, false, 0, image.film()}).end, 40U);
  EXPECT_EQ(goal.next({32, true, 0, image.film()}).end, 32U);
}

TEST(Goal, time_is_left_for_what_follows_the_last_sample) {
  NoisyImage image(8, 1, 1);
  image.grow_to(2);
  int asked = 0;
  const auto finish_s = [&](const Film&) {
    ++asked;
    return 3.0;
  };
  Goal goal({.seconds = 10}, settings_for(8, 1024), 100, finish_s, [](const std::string&) {});
  EXPECT_LT(goal.next({1, true, 0, image.film()}).latest_s, 100);
  EXPECT_EQ(goal.next({2, true, 0, image.film()}).latest_s, 97);
  EXPECT_EQ(goal.next({4, true, 0, image.film()}).latest_s, 97);
  EXPECT_EQ(asked, 1);
}

TEST(Goal, seconds_of_rendering_begin_with_the_first_sample) {
  NoisyImage image(8, 1, 1);
  image.grow_to(64);
  Goal goal = goal_of({.seconds = 10, .times_rendering = true}, settings_for(8, 1024));
  const Round first = goal.next({48, true, 0, image.film()});
  EXPECT_EQ(first.end, 49U) << "a render that goes on is not to take long before it is timed";
  EXPECT_TRUE(std::isinf(first.latest_s));
  const double before_s = host_seconds();
  const Round second = goal.next({49, true, 3, image.film()});
  EXPECT_EQ(second.end, 64U);
  EXPECT_GE(second.latest_s, before_s + 7);
  EXPECT_LE(second.latest_s, host_seconds() + 7);
}

// The claim is 5 %. Of 400 renders more than 33 would end above their target with a probability of
// less than 0.3 % if it were true. With the 95 % interval of each judgement alone, it is 60 and
// more.
TEST(Goal, at_most_five_percent_of_renders_end_above_their_target) {
  constexpr std::uint32_t kSide = 12;
  int above = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    NoisyImage image(kSide, 1, seed);
    // Targets lie between judgements in all ways.
    const double target = 1.0 / (30 + 40.0 * seed / 400);
    Goal goal = goal_of({.relmse = target}, settings_for(kSide, 4096));
    for (std::uint64_t done = 0;;) {
      const std::uint64_t end = goal.next({done, true, 0, image.film()}).end;
      if (end == done) break;
      image.grow_to(done = end);
    }
    above += image.true_relmse() > target ? 1 : 0;
  }
  EXPECT_LE(above, 33);
}

}  // namespace
}  // namespace eikon::test
