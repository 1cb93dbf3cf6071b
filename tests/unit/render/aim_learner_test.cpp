// SPDX-License-Identifier: Apache-2.0
// Learning where light paths should start, from starts that bring light in a known way.
#include "render/pilot/aim_learner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>
#include <random>

namespace eikon {
namespace {

constexpr std::size_t kStarts = 1 << 13;  // of a trial
/// Of two targets, for cones and discs in turn. All starts are of parallel light.
const std::vector<double> kShares = {0, 0.2, 0, 0.8};

/// What a start brings: the root of its square.
using Carried = std::function<double(std::uint32_t start, std::mt19937& random)>;

/// Starts of a trial with this aim, of which half belong to each replicate.
AimLearner trial_of(const Carried& light, std::shared_ptr<const LightAim> aim, std::mt19937& random) {
  std::vector<double> densities(EK_AIM_START(2, 0, 0));
  for (std::uint32_t start = 0; start < densities.size(); ++start)
    densities[start] = kShares[start / EK_GUIDE_BINS] * (aim ? aim->density(start) : 1);
  std::discrete_distribution<std::uint32_t> choose(densities.begin(), densities.end());
  AimLearner learner(kShares, aim);
  for (std::size_t i = 0; i < kStarts; ++i) {
    const std::uint32_t start = choose(random);
    const double value = light(start, random) / (aim ? aim->density(start) : 1);
    if (value != 0) learner.add(std::uint32_t(i % 2), start, value * value);
  }
  return learner;
}

/// Second moment of even starts over that of aimed ones, by sums and not by chance. square: in the
/// mean, of a start
double true_gain(const LightAim& aim, const std::function<double(std::uint32_t)>& square) {
  double even = 0, aimed = 0;
  for (std::uint32_t start = 0; start < EK_AIM_START(2, 0, 0); ++start) {
    even += kShares[start / EK_GUIDE_BINS] * square(start);
    aimed += kShares[start / EK_GUIDE_BINS] * square(start) / aim.density(start);
  }
  return even / aimed;
}

/// A third of the starts in three of 64 bins of the smaller target bring light.
bool is_lit(std::uint32_t start) {
  const std::uint32_t bin = start % EK_GUIDE_BINS;
  return start / EK_GUIDE_BINS == 1 && (bin == 18 || bin == 19 || bin == 26);
}
double seldom(std::uint32_t start, std::mt19937& random) { return is_lit(start) && random() % 3 == 0 ? 1 : 0; }
double mean_square_of_seldom(std::uint32_t start) { return is_lit(start) ? 1.0 / 3 : 0; }

TEST(AimLearner, finds_the_few_starts_that_bring_light) {
  std::mt19937 random(3);
  AimLearner learner = trial_of(seldom, nullptr, random);
  const LightAim first = learner.result();
  const double gain = true_gain(first, mean_square_of_seldom);
  EXPECT_GT(gain, 8);
  EXPECT_NEAR(learner.gain(), gain, 0.15 * gain) << "what it says of itself";
  EXPECT_GE(first.density_factor[EK_AIM_DISC], 8);
  EXPECT_EQ(first.density_factor[EK_AIM_CONE], 1) << "nothing started there";
  // The weights leave the sum of all shares as it is.
  double sum = 0;
  for (std::uint32_t start = 0; start < EK_AIM_START(2, 0, 0); ++start)
    sum += kShares[start / EK_GUIDE_BINS] * first.density(start) / EK_GUIDE_BINS;
  EXPECT_NEAR(sum, 1, 1e-6);
  EXPECT_TRUE(first.is_sound());

  learner.add(trial_of(seldom, std::make_shared<const LightAim>(first), random));
  EXPECT_GT(true_gain(learner.result(), mean_square_of_seldom), 0.98 * gain) << "more trials teach no worse";
}

TEST(AimLearner, another_trial_with_other_starts_teaches_the_same) {
  // What every start brings is the same, so an aim that prefers some of them must be found out.
  std::vector<AimedTarget> targets(kShares.size());
  for (std::size_t bin = 0; bin < EK_GUIDE_BINS; ++bin) targets[1].bins[bin] = targets[3].bins[bin] = double(bin);
  const auto wrong = std::make_shared<const LightAim>(make_light_aim(targets, {1, 1}));
  const Carried even = [](std::uint32_t /*start*/, std::mt19937& /*random*/) { return 1.0; };
  std::mt19937 random(5);
  AimLearner learner = trial_of(even, nullptr, random);
  learner.add(trial_of(even, wrong, random));
  const LightAim aim = learner.result();
  for (std::uint32_t bin = 0; bin < EK_GUIDE_BINS; ++bin)
    EXPECT_NEAR(aim.density(EK_AIM_START(1, EK_AIM_DISC, bin)), 1, 0.15) << bin;
}

TEST(AimLearner, starts_that_bring_the_same_in_the_mean_gain_nothing_by_chance) {
  // Every start brings the same in the mean, and some bring a hundred times as much as most.
  const Carried heavy = [](std::uint32_t /*start*/, std::mt19937& random) { return random() % 100 == 0 ? 100.0 : 1.0; };
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    EXPECT_LT(trial_of(heavy, nullptr, random).gain(), 1.1) << seed;
  }
}

TEST(AimLearner, without_any_light_starts_stay_even) {
  const AimLearner learner(kShares, nullptr);
  EXPECT_EQ(learner.gain(), 1);
  for (std::uint32_t start = 0; start < EK_AIM_START(2, 0, 0); ++start) EXPECT_EQ(learner.result().density(start), 1);
}

}  // namespace
}  // namespace eikon
