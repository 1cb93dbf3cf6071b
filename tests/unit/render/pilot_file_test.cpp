// SPDX-License-Identifier: Apache-2.0
#include "render/pilot/pilot_file.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/error.h"
#include "support/film_builder.h"
#include "support/messages.h"
#include "support/signed_pilot.h"
#include "support/temporary_folder.h"

namespace eikon {
namespace {

using test::error_of;
using test::signed_again;
using test::small_layout;
using test::TemporaryFolder;

std::vector<ImageSetting> settings_of(std::uint32_t seed = 0, std::uint32_t max_depth = 0) {
  Scene scene;
  scene.hash = "0123456789abcdef";
  Settings settings;
  settings.width = 9, settings.height = 7;
  settings.seed = seed, settings.max_depth = max_depth;
  return pilot_settings_of(scene, settings, small_layout(9, 7));
}

Pilot some_pilot() {
  std::vector<GuideCellData> cells;
  for (std::uint32_t i = 0; i < 50; ++i) {
    GuideCellData cell{.id = cell_id(3 * i + 1, 7 * i)};
    for (std::size_t bin = 0; bin < EK_GUIDE_BINS; ++bin) cell.target[bin] = double((bin * i) % 5);
    cell.indirect = 0.1 * i, cell.direct = 0.3;
    cells.push_back(cell);
  }
  GuideTable table = make_guide_table(cells, 0.37F);
  table.roulette_depth = 1;
  Pilot pilot;
  pilot.report = {.guiding_paths = 32768, .guiding_cells = 50, .guiding_gain = 3.0 / 7, .roulette_depth = 1};
  pilot.report.guiding_digest = table.digest();
  pilot.report.arithmetic = "other-12345678";
  pilot.report.light_trial_paths = 16384, pilot.report.light_path_count = 31, pilot.report.light_path_gain = 17.0 / 3;
  pilot.table = std::make_shared<const GuideTable>(std::move(table));
  std::vector<AimedTarget> targets(2 * 3);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    targets[i].weight = 0.5 + double(i);
    for (std::size_t bin = 0; bin < EK_GUIDE_BINS; ++bin) targets[i].bins[bin] = double((bin * i) % 7);
  }
  pilot.light_aim = std::make_shared<const LightAim>(make_light_aim(targets, {4, 0.5F}));
  pilot.report.light_aim_gain = 13.0 / 11;
  return pilot;
}

std::string pilot_refusal(const std::string& bytes, const std::vector<ImageSetting>& settings = settings_of()) {
  return error_of([&] { static_cast<void>(parse_pilot(bytes, settings)); });
}

TEST(PilotFile, comes_back_whole) {
  const TemporaryFolder folder;
  const Pilot pilot = some_pilot();
  write_pilot(folder / "pilot", pilot, settings_of());
  const Pilot found = read_pilot(folder / "pilot", settings_of());
  EXPECT_EQ(found.report.guiding_digest, pilot.report.guiding_digest);
  EXPECT_EQ(found.table->digest(), pilot.table->digest());
  EXPECT_EQ(found.report.guiding_paths, 32768U);
  EXPECT_EQ(found.report.guiding_cells, 50U);
  EXPECT_EQ(found.report.guiding_gain, 3.0 / 7);
  EXPECT_EQ(found.report.roulette_depth, 1U);
  EXPECT_EQ(found.report.light_trial_paths, 16384U);
  EXPECT_EQ(found.report.light_path_count, 31U);
  EXPECT_EQ(found.report.light_path_gain, 17.0 / 3);
  EXPECT_EQ(found.report.light_aim_gain, 13.0 / 11);
  EXPECT_EQ(found.light_aim->words, pilot.light_aim->words);
  EXPECT_EQ(found.light_aim->density_factor, pilot.light_aim->density_factor);
  EXPECT_EQ(found.report.arithmetic, "other-12345678");
  EXPECT_TRUE(found.report.loaded);
  EXPECT_EQ(folder.file_count(), 1U) << "a temporary file is left";
}

TEST(PilotFile, a_decision_not_to_guide_comes_back) {
  Pilot pilot = some_pilot();
  pilot.table.reset();
  pilot.report.roulette_depth = 0;
  const Pilot found = parse_pilot(to_bytes(pilot, settings_of()), settings_of());
  EXPECT_EQ(found.table, nullptr);
  EXPECT_EQ(found.report.guiding_gain, 3.0 / 7);
}

TEST(PilotFile, samples_do_not_decide_it_and_other_settings_do) {
  const std::string bytes = to_bytes(some_pilot(), settings_of());
  EXPECT_EQ(pilot_refusal(bytes, settings_of(5)), "");
  EXPECT_EQ(pilot_refusal(bytes, settings_of(0, 4)), "its depth limit (--max-depth) is 0, not 4");
}

TEST(PilotFile, any_damage_is_seen) {
  const std::string bytes = to_bytes(some_pilot(), settings_of());
  ASSERT_EQ(pilot_refusal(bytes), "");
  const std::size_t step = bytes.size() / 400;
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    EXPECT_NE(pilot_refusal(bytes.substr(0, at)), "") << "cut at " << at;
    std::string flipped = bytes;
    flipped[at] = char(flipped[at] ^ 4);
    EXPECT_NE(pilot_refusal(flipped), "") << "changed at " << at;
  }
  EXPECT_NE(pilot_refusal(bytes + "x"), "");
  EXPECT_EQ(pilot_refusal("something else"), "it is no file of --pilot");
  std::string later = bytes;
  later[std::strlen("eikon pilot ")] = '9';
  EXPECT_EQ(pilot_refusal(signed_again(later)), "another version of eikon wrote it");
}

TEST(PilotFile, a_table_that_would_lead_kernels_astray_is_refused_whoever_signed_it) {
  const Pilot pilot = some_pilot();
  const std::string bytes = to_bytes(pilot, settings_of());
  const std::size_t end = bytes.size() - sizeof(std::uint64_t), cells = end - 4 * pilot.table->cells.size(),
                    slots = cells - 4 * pilot.table->slots.size();
  const auto with = [&](std::size_t at, std::uint32_t word) {
    std::string changed = bytes;
    std::memcpy(changed.data() + at, &word, sizeof word);
    return pilot_refusal(signed_again(changed));
  };
  std::size_t taken = 0;
  while (pilot.table->slots[2 * taken] == 0) ++taken;
  EXPECT_EQ(with(slots + 4 * (2 * taken + 1), pilot.table->slots[2 * taken + 1]), "") << "the same word";
  EXPECT_NE(with(slots + 4 * (2 * taken + 1), 50), "") << "an index beyond the cells";
  EXPECT_NE(with(cells + 4 * GUIDE_weights, 0), "") << "weights of 0";
  EXPECT_NE(with(cells + 4 * GUIDE_bounds, 1), "") << "bounds that are not the weights'";
  EXPECT_NE(with(cells + 4 * GUIDE_indirect, 0x7f800000), "") << "an infinite radiance";
  GuideTable full = *pilot.table;
  for (std::size_t i = 0; i < full.slots.size(); i += 2)
    if (full.slots[i] == 0) full.slots[i] = 1;
  EXPECT_FALSE(full.is_sound()) << "a search would not end";
  EXPECT_TRUE(pilot.table->is_sound());
  EXPECT_TRUE(make_guide_table({}, 1).is_sound()) << "an empty one";
}

}  // namespace
}  // namespace eikon
