// SPDX-License-Identifier: Apache-2.0
// --target-error and --time, as a user meets them.
#include <sys/wait.h>

#include <csignal>
#include <fstream>

#include "cli/render/checkpoint_files.h"

namespace eikon::test {
namespace {

using nlohmann::json;

const std::string kTarget = "render " + scene("cornell.gltf") + " --size 32x32 --target-error 4e-3 ";

TEST(Goals, a_target_ends_the_render_where_its_error_is_below) {
  const Workplace here;
  const Outcome outcome = here.eikon(kTarget + "-o out.exr --stats stats.json");
  ASSERT_TRUE(succeeded(outcome));
  const json stats = read_json(here / "stats.json");
  EXPECT_EQ(stats.at("ended_by"), "target-error");
  EXPECT_FALSE(stats.at("interrupted").get<bool>());
  EXPECT_LT(stats.at("relmse_interval")[1].get<double>(), 4e-3);
  const auto spp = stats.at("sample_range")[1].get<std::uint64_t>();
  EXPECT_GT(spp, 16U);
  EXPECT_EQ(stats.at("samples").get<std::uint64_t>(), 32U * 32 * spp);
  EXPECT_TRUE(contains(outcome.out, "ended by --target-error, at " + std::to_string(spp) + " samples per pixel\n"));
  // It has the bits of a render of so many samples, on any devices.
  ASSERT_TRUE(succeeded(here.eikon("render " + scene("cornell.gltf") + " --size 32x32 -o same.exr --spp " + std::to_string(spp))));
  EXPECT_EQ(read_exr(here / "out.exr").planes, read_exr(here / "same.exr").planes);
  ASSERT_TRUE(succeeded(here.eikon(kTarget + "-o one.exr --threads 1 --layout bvh8")));
  EXPECT_EQ(read_exr(here / "out.exr").planes, read_exr(here / "one.exr").planes);
}

TEST(Goals, a_target_in_percent_is_the_root_of_one) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon("render " + scene("cornell.gltf") + " --size 32x32 --target-error 10% -o out.exr --stats stats.json")));
  const json stats = read_json(here / "stats.json");
  EXPECT_LT(stats.at("relmse_interval")[1].get<double>(), 0.01);
  EXPECT_GT(stats.at("relmse_interval")[1].get<double>(), 0.002);
}

TEST(Goals, a_render_that_was_killed_ends_at_the_same_samples) {
  const Workplace here;
  const std::string command = kTarget + "--seed 3 --checkpoint c.exr --checkpoint-every 0.02 --resume -o out.exr ";
  ASSERT_TRUE(succeeded(here.eikon(kTarget + "--seed 3 -o undisturbed.exr")));
  for (int i = 0; i < 3; ++i) {
    const pid_t child = here.start(command);
    (void)wait_for_files(child, here / "c.exr", 1 + i);
    kill(child, SIGKILL);
    (void)here.wait(child);
  }
  ASSERT_TRUE(succeeded(here.eikon(command)));
  EXPECT_EQ(read_exr(here / "out.exr").planes, read_exr(here / "undisturbed.exr").planes);
  // Once it is there, nothing is left to do.
  ASSERT_TRUE(succeeded(here.eikon(command + "--stats again.json")));
  EXPECT_EQ(read_json(here / "again.json").at("samples").get<std::uint64_t>(), 0U);
  EXPECT_EQ(read_exr(here / "out.exr").planes, read_exr(here / "undisturbed.exr").planes);
}

TEST(Goals, the_limit_of_samples_ends_it_before_the_target) {
  const Workplace here;
  const Outcome outcome = here.eikon(kTarget + "--spp 17 -o out.exr --stats stats.json");
  ASSERT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.out, "ended by the limit of 17 samples per pixel\n"));
  EXPECT_EQ(read_json(here / "stats.json").at("ended_by"), "spp");
}

TEST(Goals, time_ends_a_render_and_leaves_a_whole_picture) {
  const Workplace here;
  Outcome outcome;
  // A machine may need any number of seconds before the first sample, to compile.
  for (int seconds = 2; outcome.code != 0 && seconds <= 256; seconds *= 2)
    outcome = here.eikon("render " + scene("cornell.gltf") + " --size 32x32 --target-error 1e-9 -o out.exr --png out.png " +
                         "--stats stats.json --time " + std::to_string(seconds));
  ASSERT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.out, "ended by --time, at "));
  const json stats = read_json(here / "stats.json");
  EXPECT_EQ(stats.at("ended_by"), "time");
  EXPECT_FALSE(stats.at("interrupted").get<bool>());
  EXPECT_EQ(here.files(), (std::vector<std::string>{"out.exr", "out.png", "stats.json"}));
  EXPECT_EQ(read_exr(here / "out.exr").metadata.at("endedBy"), "time");
}

TEST(Goals, no_time_for_a_sample_is_told_and_writes_nothing) {
  const Workplace here;
  const Outcome outcome = here.eikon("render " + scene("cornell.gltf") + " --size 32x32 --time 0.01 -o out.exr");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.err, "eikon: the time was over before the first sample: nothing was written; give --time more seconds\n");
  EXPECT_TRUE(here.files().empty());
}

TEST(Goals, that_make_no_sense_are_usage_errors) {
  const Workplace here;
  for (const char* flags :
       {"--target-error 0", "--target-error -1", "--target-error nan", "--target-error 1e-13", "--target-error 0%",
        "--target-error %", "--target-error few", "--target-error 1e9", "--target-error 1e-3 --samples 0:4",
        "--target-error 1e-3 --pixel 1,1 --sample 0", "--time 0", "--time -1", "--time nan",
        "--time 1 --pixel 1,1 --sample 0"}) {
    const Outcome outcome = here.eikon(cornell("--size 16x12 ") + flags);
    EXPECT_TRUE(refused(outcome, kUsage)) << flags;
    const std::string text = flags, flag = text.substr(0, text.find(' '));
    EXPECT_TRUE(contains(outcome.err, flag)) << flags << ": " << outcome.err;
  }
  EXPECT_TRUE(here.files().empty());
}

TEST(Goals, lines_of_a_batch_end_by_their_own_goals) {
  const Workplace here;
  std::ofstream(here / "jobs") << (scene("cornell.gltf") + " --size 32x32 --target-error 4e-3 -o target.exr --stats target.json\n" +
                                scene("cornell.gltf") + " --size 32x32 --time 0.2 -o time.exr --stats time.json\n");
  ASSERT_TRUE(succeeded(here.eikon("batch jobs")));
  EXPECT_EQ(read_json(here / "target.json").at("ended_by"), "target-error");
  EXPECT_EQ(read_json(here / "time.json").at("ended_by"), "time");
  ASSERT_TRUE(succeeded(here.eikon(kTarget + "-o alone.exr")));
  EXPECT_EQ(read_exr(here / "target.exr").planes, read_exr(here / "alone.exr").planes);
}

}  // namespace
}  // namespace eikon::test
