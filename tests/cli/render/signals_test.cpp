// SPDX-License-Identifier: Apache-2.0
// Signals at any moment: while a driver compiles, which puts handlers of its own in the place of
// any, and with several renders in one process.
#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "cli/batch/batch_outcome.h"
#include "cli/render/checkpoint_files.h"

namespace eikon::test {
namespace {

using Clock = std::chrono::steady_clock;

void sleep_ms(int milliseconds) { std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds)); }

void wait_until_it_listens(pid_t child, int signal) {
  for (int i = 0; i < 6000 && !listens_to(child, signal) && !has_ended(child); ++i) sleep_ms(10);
  sleep_ms(200);  // it has its checkpoint's name by now
}

/// Once PoCL has something in the cache that it compiles for: it is at it.
void wait_for_compiler(const Workplace& here, pid_t child) {
  const auto is_at_it = [&] {
    std::error_code none;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(here / "cold", none))
      if (entry.is_regular_file(none)) return true;
    return false;
  };
  for (int i = 0; i < 6000 && !is_at_it() && !has_ended(child); ++i) sleep_ms(10);
}

bool appears(const std::filesystem::path& file, pid_t writer) {
  for (int i = 0; i < 6000 && identity(file) == 0 && !has_ended(writer); ++i) sleep_ms(10);
  return identity(file) != 0;
}

const char* const kCold = "POCL_CACHE_DIR=$PWD/cold";
const std::string kForLong = std::string(kEndless) + "--checkpoint c.exr --checkpoint-every 1e6 ";

TEST(Signals, SIGUSR1_during_a_cold_compile_asks_for_a_checkpoint) {
  const Workplace here;
  std::filesystem::create_directory(here / "cold");
  const pid_t child = here.start(cornell(kForLong), kCold);
  wait_until_it_listens(child, SIGUSR1);
  wait_for_compiler(here, child);
  EXPECT_EQ(identity(here / "c.exr"), 0U);
  kill(child, SIGUSR1);  // once
  EXPECT_TRUE(appears(here / "c.exr", child));
  kill(child, SIGINT);
  EXPECT_EQ(here.wait(child).code, 130);
}

TEST(Signals, SIGTERM_during_a_cold_compile_ends_it_without_the_compiler) {
  const Workplace here;
  std::filesystem::create_directory(here / "cold");
  const auto begin = Clock::now();
  const pid_t child = here.start(cornell(kForLong), kCold);
  wait_until_it_listens(child, SIGTERM);
  wait_for_compiler(here, child);
  const auto asked = Clock::now();
  kill(child, SIGTERM);
  const Outcome outcome = here.wait(child);
  const auto ended = Clock::now();
  EXPECT_EQ(outcome.code, 143) << outcome.err;
  EXPECT_EQ(outcome.err, "eikon: interrupted before the first sample: nothing was written\n");
  // What it takes to compile this, on a machine as busy as it is now.
  const auto compile_begin = Clock::now();
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 4x4 --spp 1 --quiet"), "POCL_CACHE_DIR=$PWD/colder")));
  const auto compiled = Clock::now();
  EXPECT_LT(ended - asked, (compiled - compile_begin) / 2 + std::chrono::milliseconds(500)) << (asked - begin).count();
}

TEST(Signals, SIGHUP_leaves_a_checkpoint_to_go_on_from_however_often_it_comes) {
  const Workplace here;
  std::signal(SIGHUP, SIG_DFL);  // inherited; these tests may themselves run under nohup
  const pid_t child = here.start(cornell(std::string(kEndless) + "--checkpoint c.exr --checkpoint-every 0.03"));
  EXPECT_TRUE(wait_for_files(child, here / "c.exr", 1));
  kill(child, SIGHUP);  // the terminal's
  sleep_ms(5);
  kill(child, SIGHUP);  // the shell's
  const Outcome outcome = here.wait(child);
  EXPECT_EQ(outcome.code, 143) << outcome.err;
  EXPECT_EQ(read_exr(here / "out.exr").planes, read_exr(here / "c.exr").planes);
}

TEST(Signals, SIGHUP_ends_nothing_under_nohup) {
  const Workplace here;
  const pid_t child =
      here.start(cornell(std::string(kEndless) + "--checkpoint c.exr --checkpoint-every 0.03"), "trap '' HUP;");
  EXPECT_TRUE(wait_for_files(child, here / "c.exr", 1));
  kill(child, SIGHUP);
  EXPECT_TRUE(wait_for_files(child, here / "c.exr", 3));
  kill(child, SIGTERM);
  EXPECT_EQ(here.wait(child).code, 143);
}

TEST(Signals, one_stop_that_comes_twice_leaves_what_was_done) {
  for (const int first : {SIGINT, SIGTERM}) {
    const Workplace here;
    const pid_t child = here.start(cornell(std::string(kEndless) + "--checkpoint c.exr --checkpoint-every 0.03"));
    EXPECT_TRUE(wait_for_files(child, here / "c.exr", 1));
    kill(child, first);
    sleep_ms(1);
    kill(child, SIGTERM);  // as GNU timeout does, and queues that signal every process of a task
    const Outcome outcome = here.wait(child);
    EXPECT_EQ(outcome.code, first == SIGINT ? 130 : 143) << outcome.err;
    ASSERT_EQ(outcome.err.find("eikon: interrupted: "), 0U) << outcome.err;
    EXPECT_EQ(read_exr(here / "out.exr").planes, read_exr(here / "c.exr").planes);
  }
}

TEST(Signals, a_SIGINT_or_SIGTERM_a_second_after_the_first_ends_it_at_once) {
  for (const int second : {SIGINT, SIGTERM}) {
    const Workplace here;
    const pid_t child = here.start(cornell(std::string(kEndless) + "--checkpoint c.exr --checkpoint-every 0.03"),
                                   "EIKON_FAULT=device:0:hang:after=3 EIKON_WATCHDOG=1000");
    EXPECT_TRUE(wait_for_files(child, here / "c.exr", 1));
    sleep_ms(300);  // its device has hung by now
    kill(child, SIGINT);
    sleep_ms(1200);
    EXPECT_FALSE(has_ended(child));
    kill(child, second);
    for (int i = 0; i < 500 && !has_ended(child); ++i) sleep_ms(10);
    EXPECT_TRUE(has_ended(child)) << second;
    kill(child, SIGKILL);
    EXPECT_EQ(here.wait(child).code, 1000 + second);
  }
}

TEST(Signals, one_SIGUSR1_asks_every_render_of_a_batch_for_a_checkpoint) {
  const Workplace here;
  std::string jobs;
  for (int i = 1; i <= 2; ++i)
    jobs += fmt::format("render {0} -o {1}.exr {2} --seed {1} --checkpoint c{1}.exr --checkpoint-every 1e6\n",
                        scene("cornell.gltf"), i, kEndless);
  here.write("jobs", jobs);
  const pid_t batch = here.start("batch jobs --jobs-parallel 2");
  wait_for_lines(here / "jobs.ledger", 2);
  sleep_ms(1000);
  kill(batch, SIGUSR1);  // once
  for (const char* file : {"c1.exr", "c2.exr"}) EXPECT_TRUE(appears(here / file, batch)) << file;
  kill(batch, SIGTERM);
  EXPECT_EQ(here.wait(batch).code, 143);
}

TEST(Signals, a_reader_of_stdout_that_goes_away_ends_no_render) {
  const Workplace here;
  here.write("run.sh", Workplace::binary() + " " + cornell("--size 64x64 --spp 400 --quiet --progress openjd") +
                           " | head -n 1 > first; ls out.exr");
  const Outcome outcome = here.shell("EIKON_FAULT=device:0:slow=20 sh run.sh");
  EXPECT_TRUE(contains(read_bytes(here / "first"), "openjd_status")) << outcome.err;
  EXPECT_EQ(outcome.out, "out.exr\n") << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_EQ(read_exr(here / "out.exr").metadata.at("samples"), std::to_string(64 * 64 * 400));
}

}  // namespace
}  // namespace eikon::test
