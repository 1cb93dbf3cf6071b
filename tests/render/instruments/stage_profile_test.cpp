// SPDX-License-Identifier: Apache-2.0
// The stage table tells the same story whether stages are launched one by one or run inside one
// launch.
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

const std::vector<std::string> kStages = {"intersect", "shade", "shadow"};

/// Shares of kStages in their sum, and the report.
std::pair<std::map<std::string, double>, DeviceReport> profile_of(bool fused) {
  const Scene scene = load_shipped("cornell.gltf");
  const Settings settings = settings_of(scene, 192, 32);
  Execution execution;
  execution.chunked = true, execution.fused = fused;
  execution.chunk = 1024;
  execution.extra_flags = kAsShipped;  // shares are those of the code that users run
  if (!fused) execution.unit_paths = 2048;  // so that the state stays in the caches as it does inside one launch
  const RenderOutput output = output_of(scene, settings, execution);
  const DeviceReport& device = output.report.devices.at(0);
  double sum = 0;
  std::map<std::string, double> shares;
  for (const std::string& stage : kStages) sum += device.stages.at(stage).seconds;
  for (const std::string& stage : kStages) shares[stage] = device.stages.at(stage).seconds / sum;
  return {shares, device};
}

// A stage whose time is booked on its neighbour moves a share by its whole size, 0.2 to 0.6 here,
// in every attempt. Fusing itself moves them by 0.03; other work on the machine moves them by more
// now and then, and then the pair is rendered again.
TEST(StageProfile, one_launch_and_many_agree_on_the_shares) {
  double least = 1;
  for (int attempt = 0; attempt < 30 && least > 0.1; ++attempt) {
    const auto fused = profile_of(true).first, unfused = profile_of(false).first;
    double most = 0;
    for (const std::string& stage : kStages) most = std::max(most, std::abs(fused.at(stage) - unfused.at(stage)));
    least = std::min(least, most);
  }
  EXPECT_LE(least, 0.1);
}

TEST(StageProfile, the_stages_of_one_launch_fill_it) {
  const DeviceReport fused = profile_of(true).second;
  const StageTotals& paths = fused.stages.at("paths");
  EXPECT_EQ(paths.launches, fused.units);
  double within = 0;
  for (const char* stage : {"generate", "intersect", "shade", "shadow"}) {
    EXPECT_EQ(fused.stages.at(stage).launches, 0U) << stage;
    EXPECT_GT(fused.stages.at(stage).seconds, 0) << stage;
    within += fused.stages.at(stage).seconds;
  }
  EXPECT_EQ(fused.stages.count("miss"), 0U) << "this scene has nothing to miss into";
  EXPECT_GE(paths.seconds, 0) << "the launch took less than its stages";
  EXPECT_GT(within, paths.seconds) << "most of the launch is booked on nobody";
  EXPECT_LE(within + paths.seconds, fused.busy_s * 1.001);
}

TEST(StageProfile, counts_the_same_rays_and_items) {
  const DeviceReport fused = profile_of(true).second, unfused = profile_of(false).second;
  for (const char* stage : {"generate", "intersect", "shade", "shadow"})
    EXPECT_EQ(fused.stages.at(stage).items, unfused.stages.at(stage).items) << stage;
}

}  // namespace
}  // namespace eikon::test
