// SPDX-License-Identifier: Apache-2.0
// Checkpoints and --resume: whatever ends a render, going on from its checkpoint gives the bits of
// one that nothing disturbed.
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <thread>

#include "cli/render/checkpoint_files.h"

namespace eikon::test {
namespace {

using nlohmann::json;

TEST(Checkpoint, N9_a_render_killed_five_times_ends_with_the_bits_of_an_undisturbed_one) {
  const Workplace here;
  std::mt19937 random(9);
  std::uint64_t samples = 0;
  std::string finish;
  for (int i = 0; i < 5; ++i) {
    const pid_t child =
        here.start(cornell(std::string(kEndless) + "--checkpoint c.exr --checkpoint-every 0.03 --resume"));
    EXPECT_TRUE(wait_for_files(child, here / "c.exr", 1 + int(random() % 3)));
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 40000));
    kill(child, SIGKILL);
    EXPECT_EQ(here.wait(child).code, 1000 + SIGKILL);
    const Checkpoint checkpoint = read_checkpoint(here / "c.exr");  // whole, whenever it was
    EXPECT_GT(checkpoint.record.sample_set.sample_count(), samples);
    samples = checkpoint.record.sample_set.sample_count();
    finish = just_beyond(checkpoint);
  }
  ASSERT_TRUE(succeeded(here.eikon(cornell(finish + "--checkpoint c.exr --resume --stats stats.json"))));
  const json stats = read_json(here / "stats.json");
  EXPECT_EQ(stats.at("samples_before").get<std::uint64_t>(), samples);
  EXPECT_GT(stats.at("samples").get<std::uint64_t>(), 0U);
  EXPECT_EQ(here.files(), (std::vector<std::string>{"c.exr", "out.exr", "stats.json"}));  // no temporary files
  expect_undisturbed(here, finish);
}

TEST(Checkpoint, N9_a_signal_that_ends_a_render_leaves_a_checkpoint_to_go_on_from) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const Workplace here;
    const pid_t child = here.start(cornell(std::string(kEndless) + "--checkpoint c.exr --checkpoint-every 0.03"));
    EXPECT_TRUE(wait_for_files(child, here / "c.exr", 1));
    kill(child, signal);
    const Outcome outcome = here.wait(child);
    EXPECT_EQ(outcome.code, 128 + signal) << outcome.err;
    const Checkpoint checkpoint = read_checkpoint(here / "c.exr");
    // The picture has all that was done, and so has the checkpoint.
    const Image picture = read_exr(here / "out.exr");
    EXPECT_EQ(picture.planes, read_exr(here / "c.exr").planes);
    EXPECT_EQ(*picture.plane("G"), to_image(checkpoint.film).planes[1]);
    EXPECT_EQ(picture.metadata.at("samples"), std::to_string(checkpoint.record.sample_set.sample_count()));
    const std::string finish = just_beyond(checkpoint);
    ASSERT_TRUE(succeeded(here.eikon(cornell(finish + "--checkpoint c.exr --resume"))));
    expect_undisturbed(here, finish);
  }
}

TEST(Checkpoint, SIGUSR1_asks_for_one_and_the_render_goes_on) {
  const Workplace here;
  const pid_t child =
      here.start(cornell("--size 64x64 --spp 100000000 --quiet --checkpoint c.exr --checkpoint-every 1e6"));
  const auto ask = [&] {
    const ino_t before = identity(here / "c.exr");
    for (int i = 0; i < 1200 && identity(here / "c.exr") == before && !has_ended(child); ++i) {
      if (listens_to(child, SIGUSR1)) kill(child, SIGUSR1);
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    EXPECT_FALSE(has_ended(child));
    return read_checkpoint(here / "c.exr").record.sample_set.sample_count();
  };
  const std::uint64_t first = ask(), second = ask();
  EXPECT_GT(first, 0U);
  EXPECT_GT(second, first);
  kill(child, SIGTERM);
  EXPECT_EQ(here.wait(child).code, 128 + SIGTERM);
  EXPECT_GE(read_checkpoint(here / "c.exr").record.sample_set.sample_count(), second);
}

TEST(Checkpoint, a_device_that_disappears_leaves_one_to_go_on_from) {
  const Workplace here;
  const Outcome lost = here.eikon(cornell(std::string(kEndless) + "--checkpoint c.exr --devices cpu"),
                                  "EIKON_FAULT=device:0:after=3:lost");
  EXPECT_TRUE(refused(lost, 4));
  EXPECT_TRUE(contains(lost.err, "no device is left") && contains(lost.err, "CL_DEVICE_NOT_AVAILABLE")) << lost.err;
  EXPECT_EQ(here.files(), std::vector<std::string>{"c.exr"});
  const std::string finish = just_beyond(read_checkpoint(here / "c.exr"));
  ASSERT_TRUE(succeeded(here.eikon(cornell(finish + "--checkpoint c.exr --resume"))));
  expect_undisturbed(here, finish);
}

TEST(Checkpoint, a_render_that_was_stopped_for_a_while_goes_on) {
  const Workplace here;
  const pid_t child =
      here.start(cornell(std::string(kEndless) + "--checkpoint c.exr --checkpoint-every 0.03"), "EIKON_WATCHDOG=0.5");
  EXPECT_TRUE(wait_for_files(child, here / "c.exr", 3));
  kill(child, SIGSTOP);  // Ctrl-Z: longer than any device may take for a unit, 20 times what it usually does
  std::this_thread::sleep_for(std::chrono::milliseconds(4000));
  kill(child, SIGCONT);
  EXPECT_TRUE(wait_for_files(child, here / "c.exr", 3));
  kill(child, SIGINT);
  const Outcome outcome = here.wait(child);
  EXPECT_EQ(outcome.code, 130) << outcome.err;
  EXPECT_FALSE(contains(outcome.err, "given up"));
}

TEST(Checkpoint, is_a_picture_and_a_finished_one_takes_more_samples_but_no_fewer) {
  const Workplace here;
  const std::string keep = "--size 24x20 --quiet --checkpoint c.exr --resume ";
  ASSERT_TRUE(succeeded(here.eikon(cornell(keep + "--spp 6"))));  // there is none yet: from the start
  EXPECT_EQ(read_exr(here / "c.exr").planes, read_exr(here / "out.exr").planes);
  const Outcome more = here.eikon(cornell(keep + "--spp 16"));
  EXPECT_TRUE(succeeded(more));
  EXPECT_TRUE(contains(more.out, "2880 samples before and 4800 samples"));
  expect_undisturbed(here, "--size 24x20 --quiet --spp 16");
  const std::string before = read_bytes(here / "out.exr");
  const Outcome fewer = here.eikon(cornell(keep + "--spp 8"));
  EXPECT_EQ(fewer.code, 1);
  EXPECT_TRUE(contains(fewer.err, "3840 samples beyond"));
  EXPECT_EQ(read_exr(here / "out.exr").planes, read_exr(here / "whole.exr").planes);
  // Nothing left to do: all the same picture.
  EXPECT_TRUE(succeeded(here.eikon(cornell(keep + "--spp 16"))));
  expect_undisturbed(here, "--size 24x20 --quiet --spp 16");
}

TEST(Checkpoint, of_a_part_goes_on_as_the_whole) {
  const Workplace here;
  const std::string keep = "--size 24x20 --quiet --checkpoint c.exr --resume ";
  ASSERT_TRUE(succeeded(here.eikon(cornell(keep + "--samples 3:7 --crop 2,4,20,16"))));
  ASSERT_TRUE(succeeded(here.eikon(cornell(keep + "--samples 0:5 --crop 2,4,20,16"))) ==
              false);  // 5:7 stay, which is said
  ASSERT_TRUE(succeeded(here.eikon(cornell(keep + "--spp 9"))));
  expect_undisturbed(here, "--size 24x20 --quiet --spp 9");
  const Outcome smaller = here.eikon(cornell(keep + "--spp 9 --crop 0,0,8,8"));
  EXPECT_TRUE(refused(smaller, 3));
  EXPECT_TRUE(contains(smaller.err, "0,0,24,20") && contains(smaller.err, "0,0,8,8")) << smaller.err;
}

TEST(Checkpoint, of_another_image_is_refused_with_what_differs_and_left_as_it_is) {
  const Workplace here;
  const std::string usual = "--quiet --checkpoint c.exr --spp 4 ", size = "--size 24x20 ";
  ASSERT_TRUE(succeeded(here.eikon(cornell(usual + size))));
  const std::string before = read_bytes(here / "c.exr");
  const std::pair<std::string, std::string> cases[] = {
      {"--seed 1", "its seed (--seed) is 0, not 1"},
      {"--size 20x24", "its size (--size) is 24x20, not 20x24"},
      {"--filter gaussian", "its filter (--filter) is box:1, not gauss"},
      {"--cull none", "its culling (--cull) is camera, not none"},
      {"--max-depth 3", "its depth limit (--max-depth) is 0, not 3"},
      {"--light-sampling light", "is mis, not light"},
      {"--roulette 0.5", "its roulette (--roulette) is by throughput, not 0.5"},
      {"--integrator direct", "its depth limit (--integrator direct, --max-depth) is 0, not 2"},
      {"--integrator raycast", "its integrator (--integrator) is path, not raycast"},
      {"--transparent", "its transparency (--transparent) is off, not on"},
      {"--aov depth", "its channels (--aov) lack depth.Z"},
      {"--depth-series 1,3", "its channels (--depth-series) lack scattered.1.R and 8 more\n"},
      {"--fov 20", "its field of view (--fov) is"},
      {"--look-at 0.2,0.3,-0.8:0.3,0.2,0.3", "its camera's position"},
      {"--env 1,1,1", "its environment (--env"}};
  for (const auto& [flag, what] : cases) {
    const Outcome outcome = here.eikon(cornell(usual + "--resume " + (contains(flag, "--size") ? flag : size + flag)));
    EXPECT_TRUE(refused(outcome, 3)) << flag;
    EXPECT_TRUE(contains(outcome.err, what) && contains(outcome.err, "c.exr")) << flag << ": " << outcome.err;
  }
  const Outcome other = here.eikon("render " + scene("furnace.gltf") + " -o out.exr --resume " + usual + size);
  EXPECT_TRUE(refused(other, 3));
  EXPECT_TRUE(contains(other.err, "its scene's hash is"));
  EXPECT_EQ(read_bytes(here / "c.exr"), before);
}

TEST(Checkpoint, that_cannot_be_read_is_refused_and_left_as_it_is) {
  const Workplace here;
  const std::string usual = "--size 24x20 --quiet --spp 4 ";
  ASSERT_TRUE(succeeded(here.eikon(cornell(usual + "--checkpoint c.exr"))));
  const std::string whole = read_bytes(here / "c.exr");
  std::string newer = whole;
  const std::string name("eikon.format\0int\0\4\0\0\0", 21);
  const std::size_t at = newer.find(name);
  ASSERT_NE(at, std::string::npos);
  newer[at + name.size()] = 4;  // 2 has mattes, and 3 splats
  const std::pair<std::string, std::string> cases[] = {{whole.substr(0, whole.size() / 2), "d.exr"},
                                                       {whole.substr(0, whole.size() - 1), "d.exr"},
                                                       {"", "is empty (0 bytes)"},
                                                       {"some text that is no image at all\n", "no OpenEXR file"},
                                                       {newer, "newer eikon"},
                                                       {read_bytes(here / "out.exr"), "plain picture"}};
  for (const auto& [bytes, what] : cases) {
    here.write("d.exr", bytes);
    const Outcome outcome = here.eikon(cornell(usual + "--checkpoint d.exr --resume"));
    EXPECT_TRUE(refused(outcome, 3));
    EXPECT_TRUE(contains(outcome.err, what) && contains(outcome.err, "d.exr")) << outcome.err;
    EXPECT_EQ(read_bytes(here / "d.exr"), bytes);
  }
}

TEST(Checkpoint, bad_options_are_refused_before_any_work) {
  const Workplace here;
  EXPECT_TRUE(refused(here.eikon(cornell("--quiet --resume")), 2));
  EXPECT_TRUE(refused(here.eikon(cornell("--quiet --checkpoint c.exr --checkpoint-every 0")), 2));
  EXPECT_TRUE(refused(here.eikon(cornell("--quiet --checkpoint c.exr --checkpoint-every nan")), 2));
  EXPECT_TRUE(refused(here.eikon(cornell("--quiet --checkpoint out.exr")), 2));
  EXPECT_TRUE(refused(here.eikon(cornell("--quiet --checkpoint missing/c.exr")), 3));
  EXPECT_TRUE(here.files().empty());
}

TEST(Checkpoint, on_a_full_disk_the_older_one_stays_and_the_render_ends_with_a_line) {
  const Workplace here;
  // A disk of its own, which a second checkpoint of that size does not fit on beside the first.
  const std::string disk = "mkdir disk && mount -t tmpfs -o size=300k none disk";
  if (here.shell("unshare -m sh -c '" + disk + "'; rmdir disk").code != 0 ||
      here.shell("unshare -m sh -c '" + disk + "' && rmdir disk").code != 0)
    GTEST_SKIP() << "not allowed to mount a file system";
  const std::string render =
      Workplace::binary() + " " + cornell("--size 64x64 --quiet --checkpoint disk/c.exr --resume ");
  here.write("run.sh", disk + " && " + render + "--spp 4 && cp disk/c.exr first.exr && " + render +
                           "--spp 8; code=$?; cp disk/c.exr second.exr; ls -A disk > left; exit $code");
  const Outcome outcome = here.shell("unshare -m sh run.sh");
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "No space left on device") && contains(outcome.err, "holds 16384 samples"))
      << outcome.err;
  EXPECT_EQ(read_bytes(here / "first.exr"), read_bytes(here / "second.exr"));
  EXPECT_EQ(read_bytes(here / "left"), "c.exr\n");
  EXPECT_EQ(read_exr(here / "out.exr").metadata.at("samples"), std::to_string(64 * 64 * 8));  // the picture has all
}

TEST(Checkpoint, of_a_finished_render_gives_the_picture_without_any_device) {
  const Workplace here;
  const std::string keep = "--size 24x20 --spp 6 --quiet --checkpoint c.exr --aov albedo ";
  ASSERT_TRUE(succeeded(here.eikon(cornell(keep + "--png out.png"))));
  std::filesystem::rename(here / "out.exr", here / "first.exr");
  const std::string checkpoint = read_bytes(here / "c.exr"), png = read_bytes(here / "out.png");
  std::filesystem::remove(here / "out.png");
  const std::string none = "OCL_ICD_VENDORS=/nonexistent";
  ASSERT_EQ(here.eikon(cornell("--size 24x20 --spp 7 --quiet --checkpoint c.exr --aov albedo --resume"), none).code, 4);
  const Outcome outcome = here.eikon(cornell(keep + "--png out.png --resume --stats s.json --profile p.json"), none);
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.out, "2880 samples before and 0 samples"));
  EXPECT_EQ(read_exr(here / "out.exr").planes, read_exr(here / "first.exr").planes);
  EXPECT_EQ(read_bytes(here / "out.png"), png);
  EXPECT_EQ(read_bytes(here / "c.exr"), checkpoint);
  EXPECT_TRUE(read_json(here / "s.json").at("devices").empty());
}

TEST(Checkpoint, N13_memory_does_not_grow_with_the_samples) {
  const Workplace here;
  const auto peak_bytes = [&](int spp) {
    return here.peak_bytes(
        cornell("--size 32x32 --quiet --checkpoint c.exr --checkpoint-every 0.05 --spp " + std::to_string(spp)));
  };
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 32x32 --quiet --spp 1000"))));  // compiled
  // Five million samples more, and not a byte for each.
  EXPECT_LT(peak_bytes(6000) - peak_bytes(1000), 32 * 32 * 5000);
}

TEST(Progress, of_a_resumed_render_counts_what_was_done_before) {
  const Workplace here;
  const std::string keep = "--size 32x32 --quiet --checkpoint c.exr --resume --devices cpu ";
  ASSERT_TRUE(succeeded(here.eikon(cornell(keep + "--spp 300"))));
  const Outcome outcome =
      here.eikon(cornell(keep + "--spp 400 --progress openjd"), "EIKON_FAULT=device:0:slow=30");  // so that it tells
  EXPECT_TRUE(succeeded(outcome));
  std::vector<double> told;
  std::istringstream lines(outcome.out);
  for (std::string line; std::getline(lines, line);)
    if (line.rfind("openjd_progress: ", 0) == 0) told.push_back(std::stod(line.substr(17)));
  ASSERT_GE(told.size(), 2U) << outcome.out;
  EXPECT_GT(told.front(), 75) << outcome.out;
  EXPECT_EQ(told.back(), 100);
}

TEST(Progress, openjd_lines_rise_to_a_hundred_and_say_what_fails) {
  const Workplace here;
  const Outcome done = here.eikon(cornell("--size 64x64 --spp 256 --quiet --progress openjd"));
  EXPECT_TRUE(succeeded(done));
  std::istringstream lines(done.out);
  double last = -1;
  int statuses = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("openjd_status: ", 0) == 0) ++statuses;
    if (line.rfind("openjd_progress: ", 0) != 0) continue;
    const double now = std::stod(line.substr(17));
    EXPECT_GT(now, last);
    EXPECT_LE(now, 100);
    last = now;
  }
  EXPECT_EQ(last, 100);
  EXPECT_GE(statuses, 3);
  const Outcome failed = here.eikon("render missing.gltf --quiet --progress openjd");
  EXPECT_EQ(failed.code, 3);
  EXPECT_TRUE(contains(failed.out, "openjd_fail: ") && contains(failed.out, "missing.gltf")) << failed.out;
  EXPECT_FALSE(contains(failed.out, "openjd_progress: 100"));
}

}  // namespace
}  // namespace eikon::test
