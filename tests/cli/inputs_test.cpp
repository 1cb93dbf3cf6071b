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
  std::filesystem::create_symlink("a.exr", here / "link.exr");
  std::filesystem::create_hard_link(here / "ref.exr", here / "hard.exr");
  std::map<std::string, std::string> before;
  for (const std::string& file : here.files()) before[file] = read_bytes(here / file);
  for (const char* command :
       {"compare a.exr ref.exr --png a.exr", "compare a.exr ref.exr --png link.exr",
        "compare a.exr ref.exr --json=hard.exr", "compare a.exr ref.exr --png ref.exr",
        "measure textured.gltf --material 0 -o textured.gltf", "measure textured.gltf --material 0 -o tiles_color.png",
        "meter textured.gltf --at 0,0,0 --facing 0,0,1 --json=tiles_normal.png",
        "bench rays textured.gltf --json tiles_color.png", "bench rays cornell.gltf --env sky.hdr --json sky.hdr",
        "bench scene textured.gltf --json tiles_color.png", "bench scene cornell.gltf --env sky.hdr --json sky.hdr",
        "bench scene cornell.gltf --ref ref.exr --json hard.exr", "report stats.json -o stats.json",
        "report stats.json --profile trace.json -o trace.json", "report stats.json --image a.exr -o link.exr",
        "merge a.exr ref.exr -o whole.exr --png hard.exr"}) {
    const Outcome outcome = here.eikon(command);
    EXPECT_TRUE(refused(outcome, kUsage)) << command;
    EXPECT_TRUE(contains(outcome.err, "it is an input; choose another name")) << command << ": " << outcome.err;
  }
  std::map<std::string, std::string> after;
  for (const std::string& file : here.files()) after[file] = read_bytes(here / file);
  EXPECT_EQ(after, before);
}

}  // namespace
}  // namespace eikon::test
