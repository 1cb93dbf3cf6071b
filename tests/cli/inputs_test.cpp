// SPDX-License-Identifier: Apache-2.0
// Commands that read files never write over them, whatever name the output has.
#include <fmt/format.h>

#include <map>

#include "cli/command.h"

namespace eikon::test {
namespace {

TEST(Inputs, no_command_replaces_what_it_reads) {
  const Workplace here;
  for (const char* file : {"cornell.gltf", "textured.gltf", "tiles_color.png", "tiles_metallic_roughness.png",
                           "tiles_normal.png", "sky.hdr"})
    std::filesystem::copy_file(scene(file), here / file);
  for (const char* file : {"a.exr", "ref.exr", "stats.json", "trace.json"}) here.write(file, "any bytes");
  std::filesystem::create_symlink("a.exr", here / "link");
  std::filesystem::create_hard_link(here / "ref.exr", here / "hard");
  std::map<std::string, std::string> before;
  for (const std::string& file : here.files()) before[file] = read_bytes(here / file);
  for (const char* command :
       {"compare a.exr hard --png hard", "compare a.exr ref.exr --png link", "compare a.exr ref.exr --json=hard",
        "compare a.exr ref.exr --json=ref.exr", "measure textured.gltf --material 0 -o textured.gltf",
        "measure textured.gltf --material 0 -o tiles_color.png",
        "meter textured.gltf --at 0,0,0 --facing 0,0,1 --json=tiles_normal.png",
        "bench rays textured.gltf --json tiles_color.png", "bench rays cornell.gltf --env sky.hdr --json sky.hdr",
        "bench scene textured.gltf --json tiles_color.png", "bench scene cornell.gltf --env sky.hdr --json sky.hdr",
        "bench scene cornell.gltf --ref ref.exr --json hard", "report stats.json -o stats.json",
        "report stats.json --profile trace.json -o trace.json", "report stats.json --image a.exr -o link",
        "merge a.exr ref.exr -o whole.exr --png hard"}) {
    const Outcome outcome = here.eikon(command);
    EXPECT_TRUE(refused(outcome, kUsage)) << command;
    EXPECT_TRUE(contains(outcome.err, "it is an input; choose another name")) << command << ": " << outcome.err;
  }
  std::map<std::string, std::string> after;
  for (const std::string& file : here.files()) after[file] = read_bytes(here / file);
  EXPECT_EQ(after, before);
}

TEST(Inputs, a_batch_does_not_replace_what_it_reads_or_keeps) {
  const Workplace here;
  std::filesystem::copy_file(scene("cornell.gltf"), here / "s.gltf");
  here.write("jobs", "render s.gltf -o 1.exr --size 16x16 --spp 1\n");
  std::filesystem::create_symlink("jobs.ledger", here / "link.html");
  for (const char* report : {"jobs.ledger", "link.html", "s.gltf"}) {
    const Outcome outcome = here.eikon(fmt::format("batch jobs --report {}", report));
    EXPECT_TRUE(refused(outcome, kUsage)) << report;
    EXPECT_TRUE(contains(outcome.err, report));
  }
  EXPECT_FALSE(std::filesystem::exists(here / "1.exr"));
  EXPECT_TRUE(succeeded(here.eikon("batch jobs --report jobs.html")));
}

TEST(Inputs, two_outputs_are_not_one_file_behind_a_link_to_what_is_not_there_yet) {
  const Workplace here;
  std::filesystem::create_symlink("t.png", here / "l.png");
  const std::string render = fmt::format("render {} --size 16x16 --spp 1 -o a.exr ", scene("cornell.gltf"));
  const Outcome outcome = here.eikon(render + "--png l.png --stats t.png");
  EXPECT_TRUE(refused(outcome, kUsage));
  EXPECT_TRUE(contains(outcome.err, "two outputs have that name"));
  EXPECT_TRUE(succeeded(here.eikon(render + "--png l.png")));
  EXPECT_TRUE(std::filesystem::is_symlink(here / "l.png"));
  EXPECT_TRUE(std::filesystem::is_regular_file(here / "t.png"));
  std::filesystem::create_symlink("absent/t.png", here / "far.png");
  EXPECT_TRUE(refused(here.eikon(render + "--png far.png"), 3));
}

TEST(Inputs, a_flag_without_its_value_does_not_take_the_next_one) {
  const Workplace here;
  const Outcome outcome =
      here.eikon(fmt::format("render {} --size 16x16 --spp 1 -o a.exr --png= --quiet", scene("cornell.gltf")));
  EXPECT_TRUE(refused(outcome, kUsage));
  EXPECT_TRUE(contains(outcome.err, "--png= has no value"));
  EXPECT_TRUE(here.files().empty());
}

TEST(Inputs, more_samples_than_can_be_counted_are_refused) {
  const Workplace here;
  const std::string render = fmt::format("render {} -o a.exr ", scene("cornell.gltf"));
  for (const char* flags : {"--size 256x256 --spp 281474976710656 --target-error 10%",
                            "--size 1024x1024 --spp 17592186044416", "--size 1024x1024 --samples 5:17592186044416"}) {
    const Outcome outcome = here.eikon(render + flags);
    EXPECT_TRUE(refused(outcome, kUsage)) << flags;
    EXPECT_TRUE(contains(outcome.err, "more than 2^60 in all"));
  }
  EXPECT_TRUE(succeeded(here.eikon(render + "--size 32x32 --samples 281474976710654:281474976710656")));
  EXPECT_TRUE(succeeded(here.eikon("merge a.exr -o b.exr")));
}

TEST(Inputs, more_threads_than_processors_are_no_news) {
  const Workplace here;
  const Outcome outcome =
      here.eikon(fmt::format("render {} --size 16x16 --spp 1 -o a.exr --threads 200 --quiet", scene("cornell.gltf")));
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_FALSE(contains(outcome.err, "TBB"));
}

TEST(Inputs, a_picture_is_not_named_as_one_of_another_format) {
  const Workplace here;
  const std::string render = "render " + scene("cornell.gltf") + " --size 8x8 --spp 1 --quiet ";
  for (const std::string& command :
       {render + "-o a.png", render + "-o a.JPG", render + "-o a.exr --png a.exr",
        std::string("merge a.exr b.exr -o c.png"), std::string("compare a.exr b.exr --png d.hdr")})
    EXPECT_TRUE(refused(here.eikon(command), kUsage)) << command;
  EXPECT_TRUE(contains(
      here.eikon(render + "-o a.png").err,
      "--output a.png: it writes a file of the format .exr, so call it a.exr; --png FILE writes an 8-bit picture"));
  EXPECT_TRUE(here.files().empty());
  // Other endings are the user's own.
  EXPECT_EQ(here.eikon(render + "-o image --png picture.0001").code, 0);
}

}  // namespace
}  // namespace eikon::test
