// SPDX-License-Identifier: Apache-2.0
// An output named "-" is standard output, which then holds that output alone.
#include <nlohmann/json.hpp>

#include "cli/command.h"

namespace eikon::test {
namespace {

using nlohmann::json;

TEST(StandardOutput, has_the_json_of_each_command_alone) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(cornell())));
  const std::string box = scene("cornell.gltf") + " --devices 0 ";
  const std::pair<std::string, const char*> commands[] = {
      {"bench rays " + box + "--layout bvh8 --rays 256 --rounds 1 --size 16x16 --json -", "Mrays/s"},
      {"bench scene " + box + "--spp 2 --size 16x12 --json -", "Msamples/s"},
      {"render " + box + "-o other.exr --spp 2 --size 16x12 --stats -", "predicted relMSE"},
      {"render " + box + "-o other.exr --spp 2 --size 16x12 --profile -", "predicted relMSE"},
      {"meter " + box + "--at 0.278,0.001,0.28 --facing 0,1,0 --spp 1 --json -", ""},
      {"compare out.exr out.exr --json -", ""}};
  for (const auto& [command, note] : commands) {
    const Outcome outcome = here.eikon(command);
    EXPECT_TRUE(succeeded(outcome)) << command;
    EXPECT_TRUE(json::accept(outcome.out)) << command << ": " << outcome.out;
    EXPECT_TRUE(contains(outcome.err, note)) << command << ": " << outcome.err;
  }
  EXPECT_EQ(here.files(), (std::vector<std::string>{"other.exr", "out.exr"}));
}

TEST(StandardOutput, json_of_a_flag_goes_to_a_file_that_is_named) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(cornell())));
  EXPECT_TRUE(succeeded(here.eikon("compare out.exr out.exr --json=same.json")));
  EXPECT_TRUE(json::accept(read_bytes(here / "same.json")));
}

TEST(StandardOutput, has_the_picture_of_a_render_and_of_a_merge) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 16x12 --samples 0:4 --quiet"))));
  const std::string to_pipe = "render " + scene("cornell.gltf") + " -o - --size 16x12 --samples 0:4";
  for (const std::string& command : {to_pipe, std::string("merge out.exr -o -")}) {
    const Outcome outcome = here.eikon(command);
    ASSERT_TRUE(succeeded(outcome)) << command;
    EXPECT_TRUE(contains(outcome.err, "predicted relMSE"));
    here.write("piped.exr", outcome.out);
    EXPECT_TRUE(succeeded(here.eikon("compare piped.exr out.exr --fail-above 0"))) << command;
  }
  EXPECT_EQ(here.eikon("render " + scene("cornell.gltf") + " -o other.exr --png - --size 4x4 --spp 1").out.substr(0, 8),
            "\x89PNG\r\n\x1a\n");
}

TEST(StandardOutput, takes_one_output_and_no_checkpoint_or_series) {
  const Workplace here;
  const std::string render = "render " + scene("cornell.gltf") + " --size 4x4 --spp 1 ";
  EXPECT_TRUE(refused(here.eikon(render + "-o - --png -"), kUsage));
  EXPECT_TRUE(refused(here.eikon(render + "-o a.exr --checkpoint -"), kUsage));
  EXPECT_TRUE(refused(here.eikon(render + "-o - --depth-series 1"), kUsage));
  here.write("jobs.txt", render + "-o -\n");
  const Outcome batch = here.eikon("batch jobs.txt");
  EXPECT_EQ(batch.code, 1);
  EXPECT_TRUE(contains(batch.err, "jobs.txt:1: a job of a batch cannot write to standard output"));
}

// A file takes the place of the one that it replaces, which here others append to.
TEST(StandardOutput, by_its_path_is_refused_and_keeps_what_was_written_to_it) {
  const Workplace here;
  here.write("lines.txt", "earlier\n");
  std::filesystem::create_symlink("/dev/stdout", here / "link.json");
  for (const char* path : {"/dev/stdout", "/dev/fd/1", "/proc/self/fd/1", "link.json"}) {
    const Outcome outcome =
        here.shell(Workplace::binary() + " " + cornell("--size 4x4 --spp 1 --quiet --stats ") + path + " >> lines.txt");
    EXPECT_TRUE(refused(outcome, kInput)) << path;
    EXPECT_TRUE(contains(outcome.err, "it is an open stream"));
    EXPECT_EQ(read_bytes(here / "lines.txt"), "earlier\n") << path;
  }
}

TEST(StandardOutput, that_is_full_is_an_error) {
  const Workplace here;
  const Outcome outcome = here.shell(Workplace::binary() + " " + cornell("--size 4x4 --spp 1 --stats - > /dev/full"));
  EXPECT_TRUE(refused(outcome, kInput));
}

TEST(StandardOutput, that_nobody_reads_any_more_is_said_to_be_a_broken_pipe) {
  const Workplace here;
  for (const std::string& command : {std::string("man render"), "info " + scene("cornell.gltf")}) {
    const Outcome outcome = here.shell("trap '' PIPE; mkfifo pipe; { exec 3<>pipe 4>pipe 3<&-; " + Workplace::binary() +
                                       " " + command + " >&4; }; code=$?; rm pipe; exit $code");
    EXPECT_TRUE(refused(outcome, kInput)) << command;
    EXPECT_TRUE(contains(outcome.err, "nobody reads it any more (broken pipe)"));
  }
}

// Whatever else is closed, too, no file gets the number of a stream, and with it what is printed.
TEST(StandardOutput, that_is_closed_is_an_error_of_each_command_that_writes_to_it) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(cornell("--samples 0:4"))));
  const std::string before = read_bytes(here / "out.exr"),
                    render = "render " + scene("cornell.gltf") + " --size 4x4 --spp 1 ";
  for (const std::string& command :
       {render + "-o -", render + "-o other.exr --png -", render + "-o other.exr --stats -",
        std::string("merge out.exr -o -"), std::string("compare out.exr out.exr --json -")})
    for (const char* closed : {" >&-", " <&- >&-", " >&- 2>&-"}) {
      const Outcome outcome = here.shell(Workplace::binary() + " " + command + closed);
      const bool is_told = std::string(closed).find("2>") == std::string::npos;
      EXPECT_TRUE(is_told ? refused(outcome, kInput) : outcome.code == kInput) << command << closed;
      EXPECT_EQ(contains(outcome.err, "cannot write to standard output: it is closed"), is_told) << outcome.err;
      EXPECT_EQ(here.files(), std::vector<std::string>{"out.exr"}) << command << closed;
      EXPECT_EQ(read_bytes(here / "out.exr"), before);
    }
  EXPECT_EQ(here.shell(Workplace::binary() + " " + render + "-o other.exr --png - <&- 2>&-").out.substr(0, 8),
            "\x89PNG\r\n\x1a\n");
}

}  // namespace
}  // namespace eikon::test
