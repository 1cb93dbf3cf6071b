// SPDX-License-Identifier: Apache-2.0
// `eikon batch` with many jobs, odd job files, and without space: it takes no more memory, and says
// what is wrong in a line.
#include <fmt/format.h>
#include <sys/resource.h>

#include <csignal>

#include "cli/batch/batch_outcome.h"
#include "io/text.h"

namespace eikon::test {
namespace {

using nlohmann::json;

TEST(BatchLimits, N13_memory_does_not_grow_with_the_jobs) {
  const Workplace here;
  const auto peak = [&](int jobs, const std::vector<std::string>& scenes) {
    std::string lines;
    for (int i = 0; i < jobs; ++i)
      lines += fmt::format("render {} -o {}.exr --size 128x96 --spp 1 --seed {}\n",
                           scene(scenes[std::size_t(i) % scenes.size()]), i, i);
    here.write("jobs", lines);
    const std::int64_t bytes = here.peak_bytes("batch jobs --force");
    EXPECT_GT(bytes, 0);
    return bytes;
  };
  constexpr int kFew = 10, kMany = 60;
  const std::vector<std::string> scenes = {"cornell.gltf", "cornell.gltf", "furnace.gltf"};
  peak(int(scenes.size()), scenes);  // compiles
  // The allocator of the C library keeps what threads give back, in a pool for each that it began;
  // runs alike differ by what lay where, which two of them tell. What each job kept would count as
  // often as there are more jobs: a film alone is 1.4 MB.
  const std::int64_t one = peak(kFew, scenes), other = peak(kFew, scenes);
  constexpr std::int64_t film = 128 * 96 * (2 * 3 * 16 + 2 * 8);
  const std::int64_t noise =
      std::abs(one - other) + 4 * film;  // four are in hand at most: staged, rendered, written, freed
  EXPECT_LT(peak(kMany, scenes) - std::max(one, other), noise) << one << " " << other;
  static_assert((kMany - kFew) * film > 10 * 4 * film);
}

TEST(BatchLimits, ten_thousand_lines_are_read_and_what_is_wrong_with_each_is_said) {
  const Workplace here;
  std::string lines;
  for (int i = 1; i <= 10000; ++i)
    lines += i % 2000 == 0 ? fmt::format("render {} -o {}.exr {}\n", scene("cornell.gltf"), i, kSmall)
             : i % 2 == 0  ? "# nothing\n"
                           : fmt::format("render a.gltf --spp no{}\n", i);
  here.write("jobs", lines);
  const Outcome outcome = here.eikon("batch jobs");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(contains(outcome.out, "5005 jobs in ") && contains(outcome.out, "5 done, 5000 failed")) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 5000);
  EXPECT_TRUE(contains(outcome.err, "eikon: jobs:9999: "));
}

TEST(BatchLimits, job_files_of_other_editors_are_read) {
  const Workplace here;
  const std::string odd = "bild mit \xc3\xa4 'und' \"leer\".exr";
  copy_scene(here, "cornell.gltf", "sc\xc3\xa8ne #1.gltf");
  here.write("jobs",
             fmt::format("\xef\xbb\xbf# a byte order mark, and CR LF\r\n\r\nrender \"sc\xc3\xa8ne #1.gltf\" {0} -o "
                         "'bild mit \xc3\xa4 '\\''und'\\'' \"leer\".exr'\r\n\trender\t'sc\xc3\xa8ne #1.gltf' {0} "
                         "\\\r\n -o 2.exr",
                         kSmall));
  EXPECT_EQ(states(here.eikon("batch jobs")), (States{{3, "done"}, {4, "done"}}));
  EXPECT_TRUE(std::filesystem::exists(here / odd));
  EXPECT_EQ(states(here.eikon("batch jobs")), (States{{3, "skipped"}, {4, "skipped"}}));
  here.write("blank", "\r\n  \r\n# only\r\n");
  EXPECT_TRUE(contains(here.eikon("batch blank").out, "nothing to do"));
}

TEST(BatchLimits, names_that_are_not_utf_8_are_skipped_and_listed_by_their_bytes) {
  const Workplace here;
  here.write("jobs", fmt::format("render {0} -o a\xff.exr {1}\nrender {0} -o a\xfe.exr {1} --seed 2\n",
                                 scene("cornell.gltf"), kSmall));
  EXPECT_EQ(states(here.eikon("batch jobs")), (States{{1, "done"}, {2, "done"}}));
  EXPECT_EQ(states(here.eikon("batch jobs")), (States{{1, "skipped"}, {2, "skipped"}}));
  const json listed = json::parse(split(here.eikon("batch jobs --list").out, '\n').front());
  const std::string name("a\0ff.exr", 8);
  EXPECT_EQ(listed.at("output"), name);
  EXPECT_EQ(listed.at("results"), json{name});
  EXPECT_EQ(listed.at("words").at(2), name);
}

TEST(BatchLimits, what_is_true_of_a_scene_is_said_once) {
  const Workplace here;
  std::string jobs;
  for (int i = 0; i < 5; ++i) jobs += fmt::format("render {} -o {}.exr {}\n", scene("sun_room.gltf"), i, kSmall);
  here.write("jobs",
             jobs + fmt::format("render {} -o 6.exr --light-sampling cosine {}\n", scene("sun_room.gltf"), kSmall));
  const Outcome outcome = here.eikon("batch jobs");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 2) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "transmissive") && contains(outcome.err, "eikon: jobs:6: --light-sampling bsdf"))
      << outcome.err;
}

TEST(BatchLimits, without_space_for_the_ledger_the_pictures_are_there_and_it_says_so) {
  const Workplace here;
  here.write("jobs",
             fmt::format("render {0} -o 1.exr {1}\nrender {0} -o 2.exr {1} --seed 2\n", scene("cornell.gltf"), kSmall));
  ASSERT_TRUE(succeeded(here.eikon("batch jobs")));
  std::filesystem::remove(here / "1.exr");
  std::filesystem::remove(here / "2.exr");
  // Entries of other files, up to a few bytes below what one may have: pictures fit, and what the
  // driver writes; the next entry does not.
  constexpr std::size_t kBlocks = 12288, kBytes = 512 * kBlocks;  // of ulimit -f
  const std::string entry = read_bytes(here / "jobs.ledger");
  std::string full;
  while (full.size() + entry.size() + 20 < kBytes) full += entry;
  full += std::string(kBytes - full.size() - 20, '\n');
  here.write("jobs.ledger", full);
  const Outcome outcome = here.eikon("batch jobs", fmt::format("ulimit -f {};", kBlocks));
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  EXPECT_EQ(states(outcome), (States{{1, "done"}, {2, "done"}})) << outcome.out;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "jobs.ledger: cannot write the ledger") && contains(outcome.err, "done again"))
      << outcome.err;
  EXPECT_EQ(states(here.eikon("batch jobs")), (States{{1, "done"}, {2, "done"}})) << "the torn line is no entry";
  EXPECT_EQ(states(here.eikon("batch jobs")), (States{{1, "skipped"}, {2, "skipped"}}));
}

TEST(BatchLimits, without_space_for_a_picture_the_job_fails_and_leaves_nothing) {
  const Workplace here;
  here.write("jobs", fmt::format("render {0} -o disk/1.exr --size 96x96 --spp 1\nrender {0} -o disk/2.exr {1}\n",
                                 scene("cornell.gltf"), kSmall));
  // A disk of its own, too small for the first picture.
  const std::string disk = "mkdir disk && mount -t tmpfs -o size=64k none disk";
  if (here.shell("unshare -m sh -c '" + disk + "'; rmdir disk").code != 0)
    GTEST_SKIP() << "not allowed to mount a file system";
  std::filesystem::create_directory(here / "temporary");
  here.write("run.sh", disk + " && TMPDIR=$PWD/temporary " + Workplace::binary() +
                           " batch jobs; code=$?; ls -A disk > left; exit $code");
  const Outcome outcome = here.shell("unshare -m sh run.sh");
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  EXPECT_EQ(states(outcome), (States{{1, "failed"}, {2, "done"}})) << outcome.out;
  EXPECT_TRUE(contains(outcome.err, "cannot write \"disk/1.exr\"") && contains(outcome.err, "No space left"))
      << outcome.err;
  EXPECT_EQ(read_bytes(here / "left"), "2.exr\n");
  EXPECT_TRUE(std::filesystem::is_empty(here / "temporary")) << "of a thousand such jobs, the last would find it full";
  for (const json& entry : entries(here / "jobs.ledger"))
    if (entry.at("line") == 1 && entry.at("state") != "started") {
      EXPECT_EQ(entry.at("state"), "failed");
      EXPECT_EQ(entry.at("exit_code"), 3);
    }
}

TEST(BatchLimits, lines_that_are_no_renders_are_refused_by_what_they_are) {
  const Workplace here;
  std::filesystem::create_symlink("loop.exr", here / "loop.exr");
  here.write("jobs",
             fmt::format("eikon batch others\nrender --help\nrender\n''\nrender {0} -o {1}.exr\n"
                         "render {1}.gltf -o c.exr\nrender {0} -o loop.exr\nrender loop.exr/a.gltf\n",
                         scene("cornell.gltf"), std::string(5000, 'x')));
  const Outcome outcome = here.eikon("batch jobs");
  EXPECT_EQ(outcome.code, 1);
  for (int line = 1; line <= 8; ++line) {
    EXPECT_EQ(states(outcome)[line], "failed") << line;
    EXPECT_TRUE(contains(outcome.err, fmt::format("eikon: jobs:{}: ", line)));
  }
  EXPECT_TRUE(contains(outcome.err, "'batch' cannot be in a batch"));
}

TEST(BatchLimits, no_other_command_is_taken_for_a_scene) {
  const Workplace here;
  std::istringstream help(here.eikon("--help").out);
  std::vector<std::string> commands;
  for (std::string line; std::getline(help, line) && line != "Subcommands:";) continue;
  for (std::string line, command; std::getline(help, line) && std::istringstream(line) >> command;)
    if (command != "render") commands.push_back(command);
  EXPECT_GE(commands.size(), 10U);
  here.write("jobs", fmt::format("{}\n", fmt::join(commands, "\n")));
  const Outcome outcome = here.eikon("batch jobs");
  for (const std::string& command : commands)
    EXPECT_TRUE(contains(outcome.err, fmt::format("'{}' cannot be in a batch", command)));
}

TEST(BatchLimits, two_batches_do_not_share_a_ledger) {
  const Workplace here, there;
  here.write("jobs", fmt::format("render {} -o 1.exr --size 64x64 --spp 100000000\n", scene("cornell.gltf")));
  const pid_t first = here.start("batch jobs");
  wait_for_lines(here / "jobs.ledger", 1);
  const Outcome second = there.eikon("batch '" + (here / "jobs").string() + "'");
  EXPECT_TRUE(refused(second, 3));
  EXPECT_TRUE(contains(second.err, "another batch"));
  kill(first, SIGTERM);
  EXPECT_EQ(here.wait(first).code, 143);
}

}  // namespace
}  // namespace eikon::test
