// SPDX-License-Identifier: Apache-2.0
// The tables by which light paths are aimed: what kernels would be led astray by is refused.
#include "guide/light_aim.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>

namespace eikon {
namespace {

LightAim some_aim() {
  std::vector<AimedTarget> targets(kAimKinds * 2);
  targets[1].weight = 3;
  for (std::size_t bin = 0; bin < EK_GUIDE_BINS; ++bin) targets[1].bins[bin] = bin == 7 ? 1 : 0;
  return make_light_aim(targets, {0.5F, 8});
}

TEST(LightAimTables, have_the_densities_of_what_they_are_made_of) {
  const LightAim aim = some_aim();
  EXPECT_EQ(aim.target_count(), 2U);
  double sum = 0;
  for (std::uint32_t bin = 0; bin < EK_GUIDE_BINS; ++bin) {
    const double density = aim.density(EK_AIM_START(0, EK_AIM_DISC, bin));
    EXPECT_GE(density, 3 * 0.25 * (1 - 1e-9));
    sum += density / EK_GUIDE_BINS;
    EXPECT_EQ(aim.density(EK_AIM_START(1, EK_AIM_DISC, bin)), 1) << "nothing is known of it";
  }
  EXPECT_NEAR(sum, 3, 1e-9);
  EXPECT_NEAR(aim.density(EK_AIM_START(0, EK_AIM_DISC, 7)), 3 * (0.25 + 0.75 * EK_GUIDE_BINS), 1e-3);
}

TEST(LightAimTables, that_would_lead_kernels_astray_are_not_sound) {
  EXPECT_TRUE(some_aim().is_sound());
  EXPECT_FALSE(LightAim{}.is_sound()) << "of no target";
  EXPECT_FALSE(with_named_starts(some_aim()).is_sound()) << "of a trial";
  const auto changed = [](std::size_t word, std::uint32_t value) {
    LightAim aim = some_aim();
    aim.words[word] = value;
    return aim.is_sound();
  };
  const std::size_t second = 2 * EK_GUIDE_CELL_WORDS;
  EXPECT_FALSE(changed(AIM_flags, 0));
  EXPECT_FALSE(changed(second + GUIDE_weights, 0));
  EXPECT_FALSE(changed(second + GUIDE_bounds, 5));
  for (const float weight :
       {0.0F, -1.0F, 1e30F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()})
    EXPECT_FALSE(changed(second + AIM_weight, std::bit_cast<std::uint32_t>(weight))) << weight;
  for (const float factor : {0.0F, 3.0F, -2.0F, 0x1p60F, std::numeric_limits<float>::quiet_NaN()}) {
    LightAim aim = some_aim();
    aim.density_factor[1] = factor;
    EXPECT_FALSE(aim.is_sound()) << factor;
  }
  LightAim cut = some_aim();
  cut.words.pop_back();
  EXPECT_FALSE(cut.is_sound());
  cut.words.resize(4 * EK_GUIDE_CELL_WORDS);
  EXPECT_FALSE(cut.is_sound()) << "a target without its disc";
  EXPECT_FALSE(make_light_aim(std::vector<AimedTarget>(kAimKinds * (EK_LIGHT_TARGETS_MOST + 1)), {1, 1}).is_sound());
}

}  // namespace
}  // namespace eikon
