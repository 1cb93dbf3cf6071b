// SPDX-License-Identifier: Apache-2.0
// `eikon batch` as a user runs it: which jobs run, which are skipped, what is left after failures
// and interruptions.
#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "cli/batch/batch_outcome.h"

namespace eikon::test {
namespace {

using nlohmann::json;

TEST(Batch, runs_every_line_with_the_bits_of_single_renders) {
  const Workplace here;
  std::filesystem::create_directories(here / "jobs" / "out");
  copy_scene(here, "cornell.gltf", "jobs/a scene.gltf");
  here.write("jobs/list.txt",
             fmt::format("# a comment, then a blank line\n\n"
                         "eikon render 'a scene.gltf' -o out/one.exr {0}\n"
                         "render \"a scene.gltf\" {0} -o out/two.exr --seed 5 --png out/two.png # end\n"
                         "a\\ scene.gltf {0} \\\n  --aov albedo\r\n"
                         "render {1} {0} -o out/four.exr --stats out/four.json",
                         kSmall, scene("window_room.gltf")));
  const Outcome outcome = here.eikon("batch jobs/list.txt");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_TRUE(outcome.err.empty()) << outcome.err;
  EXPECT_EQ(states(outcome), (States{{3, "done"}, {4, "done"}, {5, "done"}, {7, "done"}})) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "4 jobs in ") && contains(outcome.out, "4 done")) << outcome.out;

  const auto single = [&](const std::string& flags, const std::filesystem::path& found) {
    EXPECT_TRUE(succeeded(here.eikon("render " + flags + " -o single.exr --quiet")));
    EXPECT_TRUE(same_picture(here / "single.exr", found)) << flags;
  };
  single(fmt::format("'jobs/a scene.gltf' {}", kSmall), here / "jobs/out/one.exr");
  single(fmt::format("'jobs/a scene.gltf' {} --seed 5", kSmall), here / "jobs/out/two.exr");
  single(fmt::format("'jobs/a scene.gltf' {} --aov albedo", kSmall), here / "jobs/a scene.exr");
  single(fmt::format("{} {}", scene("window_room.gltf"), kSmall), here / "jobs/out/four.exr");
  EXPECT_TRUE(std::filesystem::exists(here / "jobs/out/two.png"));
  const json stats = read_json(here / "jobs/out/four.json");
  EXPECT_EQ(stats.at("samples").get<int>(), 12 * 8 * 2);

  const std::vector<std::string> each = {"started", "done"};
  EXPECT_EQ(told(here / "jobs/list.txt.ledger"),
            (std::map<int, std::vector<std::string>>{{3, each}, {4, each}, {5, each}, {7, each}}));
}

// The wavefront of a pilot stays ready, and its last picture had no light paths.
TEST(Batch, a_pilot_after_another_one_tries_light_paths_as_one_alone) {
  const Workplace here;
  const std::string view = scene("cornell_spheres.gltf") + " --size 160x120 --spp 2 --fov 40";
  here.write("jobs.txt",
             fmt::format("render {} --size 160x120 --spp 2 -o first.exr\nrender {} -o second.exr --stats second.json",
                         scene("cornell_spheres.gltf"), view));
  EXPECT_TRUE(succeeded(here.eikon("batch jobs.txt")));
  EXPECT_TRUE(succeeded(here.eikon("render " + view + " -o alone.exr --quiet --stats alone.json")));
  EXPECT_TRUE(same_picture(here / "second.exr", here / "alone.exr"));
  EXPECT_EQ(read_json(here / "second.json").at("pilot").at("light_path_count"),
            read_json(here / "alone.json").at("pilot").at("light_path_count"));
}

TEST(Batch, what_is_done_is_skipped_by_its_content) {
  const Workplace here;
  copy_scene(here, "cornell.gltf");
  copy_scene(here, "textured.gltf");
  for (const char* file : {"tiles_color.png", "tiles_metallic_roughness.png", "tiles_normal.png", "sky.hdr"})
    copy_scene(here, file);
  const std::string jobs = fmt::format(
      "render cornell.gltf -o 1.exr {0}\nrender textured.gltf -o 2.exr {0} --png 2.png\n"
      "render cornell.gltf -o 3.exr {0} --env sky.hdr\n",
      kSmall);
  here.write("jobs", jobs);
  const auto run = [&](const std::string& flags = "") {
    const Outcome outcome = here.eikon("batch jobs " + flags);
    EXPECT_TRUE(succeeded(outcome));
    return states(outcome);
  };
  const States all = {{1, "done"}, {2, "done"}, {3, "done"}};
  const States none = {{1, "skipped"}, {2, "skipped"}, {3, "skipped"}};
  const auto but = [&](std::initializer_list<int> lines) {
    States expected = none;
    for (const int line : lines) expected[line] = "done";
    return expected;
  };
  EXPECT_EQ(run(), all);
  const std::string first = read_bytes(here / "1.exr");
  EXPECT_EQ(run(), none);
  EXPECT_EQ(read_bytes(here / "1.exr"), first);

  for (const char* file : {"cornell.gltf", "tiles_color.png", "sky.hdr", "1.exr"})
    std::filesystem::last_write_time(here / file, std::filesystem::file_time_type::clock::now());
  EXPECT_EQ(run(), none) << "dates do not count";
  // A trailing blank changes bytes and no picture.
  std::ofstream(here / "cornell.gltf", std::ios::app) << "\n";
  EXPECT_EQ(run(), but({1, 3}));
  copy_scene(here, "tiles_normal.png", "tiles_color.png");
  EXPECT_EQ(run(), but({2})) << "a picture of the scene";
  std::filesystem::remove(here / "2.png");
  EXPECT_EQ(run(), but({2})) << "an output is missing";
  here.write("1.exr", "something else");
  EXPECT_EQ(run(), but({1})) << "an output is another file";
  EXPECT_EQ(run("--force"), all);

  here.write("jobs", "# moved down, and how it runs is another matter\n" + jobs);
  EXPECT_EQ(run(), (States{{2, "skipped"}, {3, "skipped"}, {4, "skipped"}}));
  here.write(
      "jobs",
      fmt::format("render cornell.gltf -o 1.exr {0} --devices cpu\nrender -o 3.exr --env sky.hdr {0} cornell.gltf\n"
                  "render cornell.gltf -o 4.exr {0} --seed 3",
                  kSmall));
  EXPECT_EQ(run(), but({3}));
}

TEST(Batch, one_bad_line_stops_no_other) {
  const Workplace here;
  here.write("jobs",
             fmt::format("render {0} -o 1.exr {1}\nrender {0} -o 2.exr --spp many\nrender absent.gltf -o 3.exr\n"
                         "render {0} -o '4.exr {1}\nmerge 1.exr -o 5.exr\nrender {0} -o 6.exr --pixel 1,1 --sample 2\n"
                         "render {0} -o no/folder.exr {1}\nrender {0} -o 8.exr {1} --camera nobody\n"
                         "render $HOME/a.gltf\nrender {0} -o 10.exr {1}\n",
                         scene("cornell.gltf"), kSmall));
  const Outcome outcome = here.eikon("batch jobs");
  EXPECT_EQ(outcome.code, 1);
  States expected;
  for (int line = 1; line <= 10; ++line) expected[line] = line == 1 || line == 10 ? "done" : "failed";
  EXPECT_EQ(states(outcome), expected) << outcome.out;
  for (int line = 2; line < 10; ++line)
    EXPECT_TRUE(contains(outcome.err, fmt::format("eikon: jobs:{}: ", line))) << line << "\n" << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 8) << outcome.err;
  EXPECT_EQ(here.files(), (std::vector<std::string>{"1.exr", "10.exr", "jobs", "jobs.ledger"}));
  for (const json& entry : entries(here / "jobs.ledger"))
    if (entry.at("line") == 3) {
      EXPECT_EQ(entry.at("state"), "failed");
      EXPECT_EQ(entry.at("exit_code"), 3);
    }
}

TEST(Batch, what_fails_is_tried_again_after_the_others) {
  const Workplace here;
  here.write("jobs",
             fmt::format("render absent.gltf -o 1.exr\nrender {} -o 2.exr {}\n", scene("cornell.gltf"), kSmall));
  const Outcome outcome = here.eikon("batch jobs --retry 2");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(states(outcome), (States{{1, "failed"}, {2, "done"}}));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 3) << outcome.err;
  // What is mended meanwhile is done the next time, and nothing else.
  copy_scene(here, "cornell.gltf", "absent.gltf");
  const Outcome again = here.eikon("batch jobs");
  EXPECT_TRUE(succeeded(again));
  EXPECT_EQ(states(again), (States{{1, "done"}, {2, "skipped"}}));
}

TEST(Batch, jobs_that_would_overwrite_each_other_are_refused) {
  const Workplace here;
  copy_scene(here, "cornell.gltf");
  const auto refuse = [&](const std::string& second, const std::string& why) {
    here.write("jobs", fmt::format("render cornell.gltf -o a.exr {}\nrender cornell.gltf {}\n", kSmall, second));
    const Outcome outcome = here.eikon("batch jobs");
    EXPECT_TRUE(refused(outcome, 2)) << second;
    EXPECT_TRUE(contains(outcome.err, "jobs:2:") && contains(outcome.err, why)) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(here / "a.exr")) << second;
  };
  refuse("-o ./x/../a.exr", "line 1");
  refuse("-o b.exr --stats a.exr", "line 1");
  refuse("-o b --png b", "two outputs");
  refuse("-o cornell.gltf", "an input");
  refuse("-o jobs", "the batch itself");
  refuse("-o jobs.ledger", "the batch itself");
}

TEST(Batch, bad_input_gets_one_line) {
  const Workplace here;
  EXPECT_TRUE(refused(here.eikon("batch absent.txt"), 3));
  EXPECT_TRUE(refused(here.eikon("batch ."), 3));
  EXPECT_TRUE(refused(here.eikon("batch"), 2));
  here.write("jobs", "");
  EXPECT_TRUE(refused(here.eikon("batch jobs --jobs-parallel 0"), 2));
  here.write("jobs.ledger", "no ledger\n");
  EXPECT_TRUE(refused(here.eikon("batch jobs"), 3));
  const Outcome empty = here.eikon("batch jobs --ledger other");
  EXPECT_TRUE(succeeded(empty));
  EXPECT_TRUE(contains(empty.out, "nothing to do"));
}

TEST(Batch, lines_may_come_from_a_pipe_and_a_ledger_may_be_named) {
  const Workplace here;
  const std::string run = fmt::format("echo render {} -o a.exr {} | {} batch - --ledger l", scene("cornell.gltf"),
                                      kSmall, Workplace::binary());
  EXPECT_EQ(states(here.shell(run)), (States{{1, "done"}}));
  EXPECT_EQ(states(here.shell(run)), (States{{1, "skipped"}}));
  EXPECT_EQ(here.files(), (std::vector<std::string>{"a.exr", "l"}));
}

TEST(Batch, a_job_may_read_what_an_earlier_one_writes) {
  const Workplace here;
  here.write(
      "jobs",
      fmt::format("render {0} -o sky.exr {1}\nrender {0} -o other.exr {1}\nrender {0} -o 3.exr {1} --env sky.exr\n",
                  scene("sphere_in_sky.gltf"), kSmall));
  const Outcome outcome = here.eikon("batch jobs --jobs-parallel 2");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_EQ(states(outcome), (States{{1, "done"}, {2, "done"}, {3, "done"}}));
}

TEST(Batch, jobs_at_a_time_have_the_same_bits) {
  const Workplace here;
  std::string jobs;
  for (int i = 1; i <= 4; ++i)
    jobs += fmt::format("render {} -o {}.exr {} --seed {}\n", scene("cornell.gltf"), i, kSmall, i);
  here.write("jobs", jobs);
  EXPECT_TRUE(succeeded(here.eikon("batch jobs --jobs-parallel 3")));
  for (int i = 1; i <= 4; ++i)
    std::filesystem::rename(here / fmt::format("{}.exr", i), here / fmt::format("{}p.exr", i));
  EXPECT_TRUE(succeeded(here.eikon("batch jobs")));
  for (int i = 1; i <= 4; ++i)
    EXPECT_TRUE(same_picture(here / fmt::format("{}.exr", i), here / fmt::format("{}p.exr", i)));
  ASSERT_TRUE(succeeded(here.eikon(fmt::format("render {} -o 1p.exr {} --seed 1", scene("cornell.gltf"), kSmall))));
  EXPECT_TRUE(same_picture(here / "1.exr", here / "1p.exr"));
}

TEST(Batch, interrupted_and_killed_it_goes_on_with_the_bits_of_single_renders) {
  const Workplace here;
  std::string jobs;
  for (int i = 1; i <= 6; ++i)
    jobs += fmt::format("render {} -o {}.exr --size 40x30 --spp {} --seed {}\n", scene("cornell.gltf"), i,
                        i == 3 ? 400 : 4, i);
  here.write("jobs", jobs);
  // The ledger gets two lines for each job: that it began, and how it ended.
  const pid_t first = here.start("batch jobs");
  wait_for_lines(here / "jobs.ledger", 2);
  kill(first, SIGKILL);
  EXPECT_EQ(here.wait(first).code, 1000 + SIGKILL);
  // It may have come further than that; the second one has begun a job when it has written a line
  // of its own.
  const std::string left = read_bytes(here / "jobs.ledger");
  const pid_t second = here.start("batch jobs");
  wait_for_lines(here / "jobs.ledger", std::max<std::ptrdiff_t>(5, std::count(left.begin(), left.end(), '\n') + 1));
  kill(second, SIGINT);
  const Outcome stopped = here.wait(second);
  EXPECT_EQ(stopped.code, 130) << stopped.err;
  EXPECT_TRUE(contains(stopped.out, "6 jobs in "));

  const Outcome last = here.eikon("batch jobs");
  EXPECT_TRUE(succeeded(last));
  EXPECT_EQ(states(last).at(1), "skipped");
  for (int i = 1; i <= 6; ++i) {
    ASSERT_TRUE(succeeded(here.eikon(fmt::format("render {} -o single.exr --size 40x30 --spp {} --seed {}",
                                                 scene("cornell.gltf"), i == 3 ? 400 : 4, i))));
    EXPECT_TRUE(same_picture(here / "single.exr", here / fmt::format("{}.exr", i))) << i;
  }
}

TEST(Batch, an_interrupted_part_goes_on_from_what_its_own_file_holds) {
  const Workplace here;
  const std::string part = fmt::format("render {} --size 64x64 --samples 100:1700 -o ", scene("cornell.gltf"));
  here.write("jobs", part + "part.exr");
  const pid_t child = here.start("batch jobs", "EIKON_FAULT=device:0:slow=50");
  wait_for_lines(here / "jobs.ledger", 1);
  std::this_thread::sleep_for(std::chrono::seconds(2));
  kill(child, SIGTERM);
  EXPECT_EQ(here.wait(child).code, 143);
  EXPECT_TRUE(succeeded(here.eikon("batch jobs")));

  std::uint64_t rendered = 0;
  int runs = 0;
  for (const json& entry : entries(here / "jobs.ledger")) {
    if (entry.at("state") == "started") continue;
    EXPECT_GT(entry.at("samples"), 0U) << entry;
    rendered += entry.at("samples").get<std::uint64_t>();
    ++runs;
  }
  EXPECT_EQ(runs, 2);
  EXPECT_EQ(rendered, 64U * 64 * 1600);
  ASSERT_TRUE(succeeded(here.eikon(part + "whole.exr")));
  EXPECT_TRUE(same_picture(here / "whole.exr", here / "part.exr"));
}

TEST(Batch, terminated_it_says_so) {
  const Workplace here;
  here.write("jobs", fmt::format("render {0} -o 1.exr --size 64x64 --spp 100000000\nrender {0} -o 2.exr {1}\n",
                                 scene("cornell.gltf"), kSmall));
  const pid_t child = here.start("batch jobs");
  wait_for_lines(here / "jobs.ledger", 1);
  std::this_thread::sleep_for(std::chrono::seconds(3));
  kill(child, SIGTERM);
  const Outcome outcome = here.wait(child);
  EXPECT_EQ(outcome.code, 143) << outcome.err;
  EXPECT_EQ(states(outcome), (States{{1, "interrupted"}, {2, "not"}})) << outcome.out;
}

}  // namespace
}  // namespace eikon::test
