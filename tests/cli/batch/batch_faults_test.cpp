// SPDX-License-Identifier: Apache-2.0
// `eikon batch` when devices fail, hang, or the process is killed: what is left is true, and goes
// on to the bits of single renders.
#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <thread>

#include "cli/batch/batch_outcome.h"
#include "cli/render/checkpoint_files.h"

namespace eikon::test {
namespace {

using nlohmann::json;

const char* const kCores = "POCL_MAX_PTHREAD_COUNT=2";  // of PoCL's device, wherever the tests run

/// Renders of the Cornell box to 1.exr, 2.exr, ...
std::string jobs_of(int count, const std::string& flags) {
  std::string jobs;
  for (int i = 1; i <= count; ++i)
    jobs += fmt::format("render {} -o {}.exr --seed {} {}\n", scene("cornell.gltf"), i, i, flags);
  return jobs;
}

void expect_single_renders(const Workplace& here, int count, const std::string& flags) {
  for (int i = 1; i <= count; ++i) {
    ASSERT_TRUE(succeeded(here.eikon(
        fmt::format("render {} -o single.exr --seed {} {} --quiet --devices cpu", scene("cornell.gltf"), i, flags))));
    EXPECT_TRUE(same_picture(here / "single.exr", here / fmt::format("{}.exr", i))) << i;
  }
}

TEST(BatchFaults, a_device_that_fails_is_made_up_for_by_another) {
  const Workplace here;
  const std::string image = "--size 64x48 --spp 16";
  here.write("jobs", jobs_of(3, image + " --devices cpu:2x1"));
  // The first device is so slow that the second one has work whenever it is ready.
  const Outcome outcome =
      here.eikon("batch jobs", std::string(kCores) + " EIKON_FAULT='device:0:slow=20;device:1:after=1'");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_EQ(states(outcome), (States{{1, "done"}, {2, "done"}, {3, "done"}})) << outcome.out;
  EXPECT_TRUE(contains(outcome.err, "eikon: jobs:") && contains(outcome.err, "CL_OUT_OF_RESOURCES")) << outcome.err;
  for (const json& entry : entries(here / "jobs.ledger")) EXPECT_EQ(entry.at("exit_code"), 0);
  expect_single_renders(here, 3, image);
}

// Two units go through, the next three fail, which is when a device is given up; each job here is
// one unit.
constexpr const char* kOneJobFails = "EIKON_FAULT=device:0:after=2:times=3";

TEST(BatchFaults, a_job_whose_only_device_fails_stops_no_other) {
  const Workplace here;
  here.write("jobs", jobs_of(4, std::string(kSmall) + " --devices cpu"));
  const Outcome outcome = here.eikon("batch jobs", kOneJobFails);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(states(outcome), (States{{1, "done"}, {2, "done"}, {3, "failed"}, {4, "done"}})) << outcome.out;
  EXPECT_EQ(here.files(), (std::vector<std::string>{"1.exr", "2.exr", "4.exr", "jobs", "jobs.ledger"}));
  for (const json& entry : entries(here / "jobs.ledger")) {
    if (entry.at("state") == "started") continue;
    const bool failed = entry.at("line") == 3;
    EXPECT_EQ(entry.at("state"), failed ? "failed" : "done");
    EXPECT_EQ(entry.at("exit_code"), failed ? 4 : 0);
    EXPECT_EQ(contains(entry.at("message"), "CL_OUT_OF_RESOURCES"), failed) << entry;
  }
  const Outcome again = here.eikon("batch jobs");
  EXPECT_TRUE(succeeded(again));
  EXPECT_EQ(states(again), (States{{1, "skipped"}, {2, "skipped"}, {3, "done"}, {4, "skipped"}})) << again.out;
  expect_single_renders(here, 4, kSmall);
}

TEST(BatchFaults, a_job_whose_device_fails_is_tried_again) {
  const Workplace here;
  here.write("jobs", jobs_of(4, std::string(kSmall) + " --devices cpu"));
  const Outcome outcome = here.eikon("batch jobs --retry 1", kOneJobFails);
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.err, "eikon: jobs:3: ") && contains(outcome.err, "it will be tried again"))
      << outcome.err;
  const std::vector<std::string> once = {"started", "done"}, twice = {"started", "started", "done"};
  EXPECT_EQ(told(here / "jobs.ledger"),
            (std::map<int, std::vector<std::string>>{{1, once}, {2, once}, {3, twice}, {4, once}}));
  expect_single_renders(here, 4, kSmall);
}

TEST(BatchFaults, a_lost_device_stays_lost_for_all_jobs) {
  const Workplace here;
  here.write("jobs", jobs_of(3, std::string(kSmall) + " --devices cpu"));
  const Outcome outcome = here.eikon("batch jobs", "EIKON_FAULT=device:0:after=1:lost");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(states(outcome), (States{{1, "done"}, {2, "failed"}, {3, "failed"}})) << outcome.out;
  EXPECT_TRUE(contains(outcome.err, "CL_DEVICE_NOT_AVAILABLE"));
}

TEST(BatchFaults, a_device_that_hangs_is_waited_for_once) {
  const Workplace here;
  const std::string image = "--size 64x48 --spp 64";
  here.write("jobs", jobs_of(4, image + " --devices cpu:2x1"));
  // The other one is slow, or it would be done before this one has begun.
  const Outcome outcome = here.eikon(
      "batch jobs", std::string(kCores) + " EIKON_WATCHDOG=0.5 EIKON_FAULT='device:0:slow=20;device:1:hang'");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_EQ(states(outcome), (States{{1, "done"}, {2, "done"}, {3, "done"}, {4, "done"}})) << outcome.out;
  const auto count = [&](const std::string& words) {
    int times = 0;
    for (std::size_t at = 0; (at = outcome.err.find(words, at)) != std::string::npos; ++at) ++times;
    return times;
  };
  EXPECT_EQ(count("is used no more"), 1) << outcome.err;
  EXPECT_EQ(count("did not end within"), 2) << outcome.err;  // as it was found, and in the line above
  expect_single_renders(here, 4, image);
}

TEST(BatchFaults, when_the_only_device_hangs_no_other_job_waits_for_it) {
  const Workplace here;
  here.write("jobs", jobs_of(3, std::string(kSmall) + " --devices cpu"));
  const Outcome outcome = here.eikon("batch jobs", "EIKON_WATCHDOG=0.5 EIKON_FAULT=device:0:hang:after=1");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(states(outcome), (States{{1, "done"}, {2, "failed"}, {3, "failed"}})) << outcome.out;
  EXPECT_TRUE(contains(outcome.err, "jobs:3: device 0 is used no more: "));
  EXPECT_TRUE(contains(outcome.err, "start again"));
}

TEST(BatchFaults, killed_within_a_job_it_goes_on_from_the_job_s_checkpoint) {
  const Workplace here;
  const std::string image = "--size 48x48 --spp 400";
  here.write("jobs", jobs_of(1, image + " --devices cpu --checkpoint c.exr --checkpoint-every 0.02 --stats s.json"));
  // A device that is slow, so that it does not end before it is killed.
  for (int i = 0; i < 2; ++i) {
    const pid_t child = here.start("batch jobs", "EIKON_FAULT=device:0:slow=40");
    EXPECT_TRUE(wait_for_files(child, here / "c.exr", 2));
    kill(child, SIGKILL);
    EXPECT_EQ(here.wait(child).code, 1000 + SIGKILL);
  }
  const std::uint64_t before = read_checkpoint(here / "c.exr").record.sample_set.sample_count();
  EXPECT_TRUE(succeeded(here.eikon("batch jobs")));
  const json stats = read_json(here / "s.json");
  EXPECT_EQ(stats.at("samples_before").get<std::uint64_t>(), before);
  EXPECT_EQ(stats.at("samples").get<std::uint64_t>(), 48U * 48U * 400U - before);
  expect_single_renders(here, 1, image);
  EXPECT_EQ(told(here / "jobs.ledger").at(1), (std::vector<std::string>{"started", "started", "started", "done"}));
  // All that is done stays done, and skipped.
  EXPECT_EQ(states(here.eikon("batch jobs")), (States{{1, "skipped"}}));
}

/// The job of a line that is edited after it was done, and rendered to the end with the new one's
/// bits whatever happens on the way.
void expect_edited_job_ends(const std::function<void(const Workplace&)>& disturb) {
  const Workplace here;
  const std::string job =
      "render " + scene("cornell.gltf") + " -o 1.exr --size 48x48 --devices cpu --checkpoint c.exr ";
  here.write("jobs", job + "--spp 16 --seed 1\n");
  ASSERT_TRUE(succeeded(here.eikon("batch jobs")));
  here.write("jobs", job + "--spp 400 --seed 2 --checkpoint-every 1000\n");
  disturb(here);
  const Outcome outcome = here.eikon("batch jobs");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_EQ(states(outcome), (States{{1, "done"}}));
  EXPECT_TRUE(contains(outcome.err, "its seed is 1, not 2; the first checkpoint replaces it") ||
              contains(outcome.err, "its seed (--seed) is 1, not 2; the first checkpoint replaces it"))
      << outcome.err;
  ASSERT_TRUE(
      succeeded(here.eikon("render " + scene("cornell.gltf") + " -o s.exr --size 48x48 --spp 400 --seed 2 --quiet")));
  EXPECT_TRUE(same_picture(here / "s.exr", here / "1.exr"));
  EXPECT_EQ(read_checkpoint(here / "c.exr").record.sample_set.sample_count(), 48U * 48U * 400U);
}

TEST(BatchFaults, a_job_killed_before_its_first_checkpoint_begins_anew_whatever_its_file_holds) {
  expect_edited_job_ends([](const Workplace& here) {
    const pid_t child = here.start("batch jobs", "EIKON_FAULT=device:0:slow=40");
    wait_for_lines(here / "jobs.ledger", 3);
    kill(child, SIGKILL);
    EXPECT_EQ(here.wait(child).code, 1000 + SIGKILL);
    EXPECT_EQ(told(here / "jobs.ledger").at(1).back(), "started");
  });
}

TEST(BatchFaults, a_job_that_failed_before_its_first_checkpoint_begins_anew_whatever_its_file_holds) {
  expect_edited_job_ends([](const Workplace& here) {
    const Outcome failed = here.eikon("batch jobs", "EIKON_FAULT=device:0");
    EXPECT_EQ(states(failed), (States{{1, "failed"}})) << failed.out;
  });
}

TEST(BatchFaults, a_job_that_is_tried_again_begins_anew_whatever_its_checkpoint_holds) {
  const Workplace here;
  const std::string job =
      "render " + scene("cornell.gltf") + " -o 1.exr --size 48x48 --devices cpu --checkpoint c.exr ";
  here.write("jobs", job + "--spp 16 --seed 1\n");
  ASSERT_TRUE(succeeded(here.eikon("batch jobs")));
  here.write("jobs", job + "--spp 8 --seed 1\n");  // fewer samples than the checkpoint has
  const Outcome outcome = here.eikon("batch jobs --retry 1", "EIKON_FAULT=device:0:times=3");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_EQ(states(outcome), (States{{1, "done"}})) << outcome.err;
  EXPECT_EQ(read_checkpoint(here / "c.exr").record.sample_set.sample_count(), 48U * 48U * 8U);
}

TEST(BatchFaults, what_was_done_before_a_job_s_only_device_failed_is_in_its_picture) {
  const Workplace here;
  here.write("jobs", jobs_of(1, "--size 64x48 --spp 400 --devices cpu"));
  const Outcome outcome = here.eikon("batch jobs", "EIKON_FAULT=device:0:after=4:lost");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(states(outcome), (States{{1, "failed"}}));
  EXPECT_TRUE(contains(outcome.err, "what is done is in 1.exr"));
  EXPECT_GT(read_checkpoint(here / "1.exr").record.sample_set.sample_count(), 0U);
  const Outcome again = here.eikon("batch jobs");
  EXPECT_EQ(states(again), (States{{1, "done"}})) << "it is not taken for done";
  expect_single_renders(here, 1, "--size 64x48 --spp 400");
}

TEST(BatchFaults, jobs_at_a_time_know_of_a_device_that_hung_for_one_of_them) {
  const Workplace here;
  // One of the others may be beside the first on either half of the machine; the fourth reads the
  // first one's image, so it follows them.
  const std::string two = " --devices cpu:2x1 --size 64x48 --spp 64", one = " --devices cpu:1x1 --size 64x48 --spp ";
  const std::string render = "render " + scene("cornell.gltf") + " -o ";
  here.write("jobs", render + "1.exr" + two + "\n" + render + "2.exr" + one + "400\n" + render + "3.exr" + one + "4\n" +
                         render + "4.exr" + two + " --env 1.exr\n");
  const Outcome outcome =
      here.eikon("batch jobs --jobs-parallel 2",
                 std::string(kCores) + " EIKON_WATCHDOG=0.5 EIKON_FAULT='device:0:slow=20;device:1:hang'");
  EXPECT_TRUE(succeeded(outcome));
  const auto told = [&](const std::string& of) {
    const std::size_t at = outcome.err.find(of);
    return at == std::string::npos ? "" : outcome.err.substr(at, outcome.err.find('\n', at) - at);
  };
  EXPECT_TRUE(contains(told("jobs:1: device"), "was given up")) << outcome.err;
  EXPECT_TRUE(contains(told("jobs:4: device"), "is used no more")) << outcome.err;
}

TEST(BatchFaults, interrupted_while_its_device_hangs_it_ends_with_a_checkpoint) {
  const Workplace here;
  here.write("jobs", fmt::format("render {0} -o 1.exr {1} --checkpoint c.exr --checkpoint-every 0.02 --devices cpu\n"
                                 "render {0} -o 2.exr {2}\n",
                                 scene("cornell.gltf"), kEndless, kSmall));
  const pid_t child = here.start("batch jobs", "EIKON_WATCHDOG=0.4 EIKON_FAULT=device:0:hang:after=3");
  EXPECT_TRUE(wait_for_files(child, here / "c.exr", 1));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));  // it has hung by now, and has not been given up
  kill(child, SIGINT);
  const Outcome outcome = here.wait(child);
  EXPECT_EQ(outcome.code, 130) << outcome.err;
  EXPECT_EQ(states(outcome), (States{{1, "interrupted"}, {2, "not"}})) << outcome.out;
  EXPECT_TRUE(contains(outcome.err, "was given up"));
  const Checkpoint checkpoint = read_checkpoint(here / "c.exr");
  EXPECT_GT(checkpoint.record.sample_set.sample_count(), 0U);
  EXPECT_EQ(read_exr(here / "1.exr").planes, read_exr(here / "c.exr").planes);
  EXPECT_EQ(told(here / "jobs.ledger"), (std::map<int, std::vector<std::string>>{{1, {"started", "interrupted"}}}));
}

TEST(BatchFaults, openjd_lines_tell_one_progress_for_all_jobs) {
  const Workplace here;
  const auto progress = [](const Outcome& outcome) {
    std::vector<double> told;
    std::istringstream lines(outcome.out);
    for (std::string line; std::getline(lines, line);)
      if (line.rfind("openjd_progress: ", 0) == 0) told.push_back(std::stod(line.substr(17)));
    return told;
  };
  here.write("jobs", jobs_of(3, kSmall) + "render absent.gltf --size 12x8 --spp 2\nrender --no-such-flag\n");
  const Outcome outcome = here.eikon("batch jobs --progress openjd --quiet");
  EXPECT_EQ(outcome.code, 1);
  const std::vector<double> shares = progress(outcome);
  ASSERT_GE(shares.size(), 4U) << outcome.out;
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end())) << outcome.out;
  EXPECT_EQ(std::adjacent_find(shares.begin(), shares.end()), shares.end()) << "a line twice";
  EXPECT_EQ(shares.back(), 100);
  EXPECT_EQ(*(shares.end() - 2), 75) << "jobs of equal size count the same; lines that are none do not count";
  EXPECT_TRUE(contains(outcome.out, "openjd_status: 2 of 4 jobs\n"));
  EXPECT_TRUE(contains(outcome.out, "openjd_fail: "));
  EXPECT_EQ(progress(here.eikon("batch jobs --progress openjd")).back(), 100);  // also when most are skipped

  here.write("endless", fmt::format("render {} -o 9.exr {}\n", scene("cornell.gltf"), kEndless));
  const pid_t child = here.start("batch endless --progress openjd");
  wait_for_lines(here / "endless.ledger", 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  kill(child, SIGTERM);
  const Outcome stopped = here.wait(child);
  EXPECT_EQ(stopped.code, 143) << stopped.err;
  EXPECT_FALSE(contains(stopped.out, "openjd_progress: 100"));
}

}  // namespace
}  // namespace eikon::test
