// SPDX-License-Identifier: Apache-2.0
// `eikon merge`: parts of one image, however they were cut, give the bits of the whole one, in any
// order and grouping.
#include <sys/resource.h>
#include <sys/wait.h>

#include <algorithm>

#include "cli/command.h"
#include "film/exr/film_file.h"
#include "image/image.h"
#include "instruments/analytic_scenes.h"
#include "support/paths.h"

namespace eikon::test {
namespace {

class Merge : public ::testing::Test {
 protected:
  const Workplace here{};

  void part(const std::string& file, const std::string& flags, const std::string& name = "cornell.gltf") const {
    ASSERT_TRUE(succeeded(here.eikon("render " + scene(name) + " -o " + file + " --size 24x20 --quiet " + flags)))
        << flags;
  }
  [[nodiscard]] Outcome merge(const std::string& parts, const std::string& output) const {
    return here.eikon("merge " + parts + " -o " + output);
  }
  [[nodiscard]] std::string bytes(const std::string& file) const { return read_bytes(here / file); }
  /// Refused, with these words, and nothing is written.
  void expect_refused(const std::string& parts, const std::vector<std::string>& words) const {
    const Outcome outcome = merge(parts, "refused.exr");
    EXPECT_TRUE(refused(outcome, 3)) << parts;
    for (const std::string& word : words) EXPECT_TRUE(contains(outcome.err, word)) << word << ": " << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(here / "refused.exr"));
  }
};

const std::string kLayers = "albedo,variance,object_id,cryptomatte_object,cryptomatte_material";

TEST_F(Merge, three_uneven_parts_in_any_order_and_grouping_are_the_whole_image) {
  part("a.exr", "--samples 0:3 --aov " + kLayers);
  part("b.exr", "--samples 3:4 --aov " + kLayers);
  part("c.exr", "--samples 4:16 --aov " + kLayers);
  std::vector<std::string> names = {"a.exr", "b.exr", "c.exr"};
  std::string first;
  do {
    ASSERT_TRUE(succeeded(merge(names[0] + " " + names[1] + " " + names[2], "abc.exr")));
    if (first.empty()) first = bytes("abc.exr");
    EXPECT_EQ(bytes("abc.exr"), first);
    EXPECT_EQ(merge(names[0] + " " + names[1], "pair.exr").code, names[2] == "b.exr" ? 1 : 0);
    ASSERT_TRUE(succeeded(merge("pair.exr " + names[2], "abc.exr")));
    EXPECT_EQ(bytes("abc.exr"), first);
  } while (std::next_permutation(names.begin(), names.end()));

  part("whole.exr", "--spp 16 --aov " + kLayers);
  const Image whole = read_exr(here / "whole.exr"), merged = read_exr(here / "abc.exr");
  EXPECT_EQ(merged.channels, whole.channels);
  EXPECT_EQ(merged.planes, whole.planes);
  for (const char* key : {"samples", "sampleRange", "relmsePredicted", "relmsePredictedHigh", "seed", "scene",
                          "objectNames", "sceneHash", "filter", "features", "arithmetic", "camera", "environment"})
    EXPECT_EQ(merged.metadata.at(key), whole.metadata.at(key)) << key;
  part("sums.exr", "--samples 0:16 --aov " + kLayers);
  EXPECT_TRUE(same_bits(read_film(here / "abc.exr"), read_film(here / "sums.exr")));
}

TEST_F(Merge, windows_and_ranges_and_checkpoints_add_up_and_a_part_may_be_the_output) {
  part("left.exr", "--crop 0,0,9,20 --spp 8");
  part("right.exr", "--crop 9,0,24,20 --samples 0:5");
  part("plain.exr", "--crop 9,0,24,20 --samples 5:8 --checkpoint rest.exr");
  part("whole.exr", "--spp 8");
  ASSERT_TRUE(succeeded(merge("right.exr left.exr rest.exr", "left.exr")));
  EXPECT_EQ(read_exr(here / "left.exr").planes, read_exr(here / "whole.exr").planes);
  // And it can be gone on with.
  part("more.exr", "--spp 12 --checkpoint left.exr --resume");
  part("whole.exr", "--spp 12");
  EXPECT_EQ(read_exr(here / "more.exr").planes, read_exr(here / "whole.exr").planes);
}

TEST_F(Merge, gaps_are_said_with_the_flags_that_fill_them) {
  part("a.exr", "--samples 0:3");
  part("b.exr", "--samples 5:8 --crop 0,0,24,10");
  const Outcome outcome = merge("b.exr a.exr", "out.exr");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(contains(outcome.out, "with gaps"));
  EXPECT_EQ(here.shell(Workplace::binary() + " merge b.exr a.exr -o out.exr 2>/dev/full").code, 1);
  EXPECT_EQ(read_exr(here / "out.exr").metadata.at("samples"), std::to_string(24 * 20 * 3 + 24 * 10 * 3));
  std::string parts = "out.exr";
  int count = 0;
  for (std::size_t at = outcome.err.find("eikon:   --"); at != std::string::npos;
       at = outcome.err.find("eikon:   --", at + 1)) {
    const std::string flags = outcome.err.substr(at + 9, outcome.err.find('\n', at) - at - 9);
    const std::string file = "fill" + std::to_string(count++) + ".exr";
    part(file, flags);
    parts += " " + file;
  }
  EXPECT_GE(count, 2);
  EXPECT_TRUE(succeeded(merge(parts, "filled.exr")));
  part("whole.exr", "--spp 8");
  EXPECT_EQ(read_exr(here / "filled.exr").planes, read_exr(here / "whole.exr").planes);
  // Or all at once.
  part("resumed.exr", "--checkpoint out.exr --resume --samples 0:8");
  EXPECT_EQ(read_exr(here / "resumed.exr").planes, read_exr(here / "whole.exr").planes);
}

TEST_F(Merge, parts_that_are_lost_before_or_around_the_others_are_mentioned) {
  part("first.exr", "--samples 0:4");
  part("second.exr", "--samples 4:8");
  part("third.exr", "--samples 8:12");
  const Outcome whole = merge("first.exr second.exr", "out.exr");
  EXPECT_TRUE(succeeded(whole));
  EXPECT_EQ(whole.err, "");
  const Outcome late = merge("second.exr third.exr", "out.exr");
  EXPECT_EQ(late.code, 0) << "they may be meant so, and be merged with others later";
  EXPECT_EQ(late.err, "eikon: the parts begin with sample 4: samples 0 to 3 are in none of them\n");

  part("left.exr", "--crop 3,1,9,17 --spp 8");
  part("right.exr", "--crop 9,1,24,17 --spp 8");
  EXPECT_EQ(merge("left.exr right.exr", "out.exr").err,
            "eikon: the image has 24 x 20 pixels: rows 0, rows 17 to 19, columns 0 to 2 are in no part\n");
  part("corner.exr", "--crop 0,0,23,20 --spp 8");
  EXPECT_EQ(merge("corner.exr", "out.exr").err, "eikon: the image has 24 x 20 pixels: columns 23 are in no part\n");
}

TEST_F(Merge, a_render_takes_over_parts_and_renders_only_what_they_lack) {
  part("a.exr", "--samples 0:3 --aov " + kLayers);
  part("b,c.exr", "--samples 3:8 --aov " + kLayers);
  part("whole.exr", "--spp 8 --aov " + kLayers);
  const std::string parts = " --add a.exr --add b,c.exr --aov " + kLayers, nothing = " --stats stats.json";
  part("added.exr", "--spp 8 --png added.png" + nothing + parts);
  const Image whole = read_exr(here / "whole.exr"), added = read_exr(here / "added.exr");
  EXPECT_EQ(added.channels, whole.channels);
  EXPECT_EQ(added.planes, whole.planes);
  for (const char* key : {"samples", "relmsePredicted", "relmsePredictedHigh", "arithmetic"})
    EXPECT_EQ(added.metadata.at(key), whole.metadata.at(key)) << key;
  EXPECT_TRUE(std::filesystem::exists(here / "added.png"));
  EXPECT_TRUE(contains(bytes("stats.json"), "\"samples\": 0,")) << "it rendered what it had";

  part("whole.exr", "--spp 10 --aov " + kLayers);
  part("added.exr", "--spp 10" + nothing + parts);
  EXPECT_EQ(read_exr(here / "added.exr").planes, read_exr(here / "whole.exr").planes);
  EXPECT_TRUE(contains(bytes("stats.json"), "\"samples\": " + std::to_string(24 * 20 * 2) + ","));
  // Beside a checkpoint, which then holds everything.
  part("x.exr", "--samples 8:9 --checkpoint x.ckpt.exr --aov " + kLayers);
  part("added.exr", "--spp 10 --checkpoint x.ckpt.exr --resume" + parts);
  EXPECT_EQ(read_exr(here / "added.exr").planes, read_exr(here / "whole.exr").planes);
  EXPECT_EQ(read_exr(here / "x.ckpt.exr").metadata.at("samples"), std::to_string(24 * 20 * 10));
}

TEST_F(Merge, lines_of_a_batch_take_over_parts_of_lines_before_them) {
  const std::string line = "render " + scene("cornell.gltf") + " --size 24x20 ";
  const std::string makes = line + "--samples 0:3 -o a.exr\n", takes = line + "--spp 4 --add a.exr -o whole.exr\n";
  here.write("jobs.txt", makes + takes);
  EXPECT_TRUE(succeeded(here.eikon("batch jobs.txt --quiet")));
  EXPECT_EQ(read_exr(here / "whole.exr").metadata.at("samples"), std::to_string(24 * 20 * 4));
  here.write("turned.txt", takes + makes);
  const Outcome turned = here.eikon("batch turned.txt");
  EXPECT_TRUE(refused(turned, 2)) << turned.err;
  EXPECT_TRUE(contains(turned.err, "cannot write a.exr: line 1 reads it"));
  here.write("itself.txt", line + "--spp 4 --add a.exr -o a.exr\n");
  EXPECT_TRUE(contains(here.eikon("batch itself.txt").err, "cannot write a.exr: it is an input of that line"));
}

TEST_F(Merge, what_a_render_cannot_take_over_is_refused) {
  part("a.exr", "--samples 0:3");
  part("twice.exr", "--samples 2:4");
  part("other.exr", "--samples 4:8 --seed 3");
  part("plain.exr", "--spp 4");
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"--add twice.exr", "cannot add \"twice.exr\": it holds samples that another file has added"},
      {"--add other.exr", "cannot add \"other.exr\": "},
      {"--add plain.exr", "a plain picture without exact sums"},
      {"--add none.exr", "none.exr"}};
  for (const auto& [flags, word] : cases) {
    const Outcome outcome =
        here.eikon("render " + scene("cornell.gltf") + " -o out.exr --size 24x20 --quiet --spp 8 --add a.exr " + flags);
    EXPECT_TRUE(refused(outcome, 3)) << flags;
    EXPECT_TRUE(contains(outcome.err, word));
    EXPECT_FALSE(std::filesystem::exists(here / "out.exr"));
  }
  const std::string before = bytes("a.exr");
  for (const std::string output : {"-o a.exr", "-o out.exr --checkpoint a.exr"})
    EXPECT_TRUE(
        contains(here.eikon("render " + scene("cornell.gltf") + " --size 24x20 --spp 8 --add a.exr " + output).err,
                 "cannot write a.exr: it is an input;"));
  EXPECT_EQ(bytes("a.exr"), before);
  // More samples than are asked for stay in the picture, as those of a checkpoint do.
  const Outcome more = here.eikon("render " + scene("cornell.gltf") + " -o out.exr --size 24x20 --spp 2 --add a.exr");
  EXPECT_EQ(more.code, 1);
  EXPECT_TRUE(contains(more.err, "a.exr holds 480 samples beyond what --spp or --samples ask for"));
}

TEST_F(Merge, a_part_is_not_replaced_by_the_picture) {
  part("a.exr", "--samples 0:1");
  const std::string before = bytes("a.exr");
  EXPECT_TRUE(refused(here.eikon("merge a.exr -o out.exr --png ./a.exr"), 2));
  EXPECT_EQ(bytes("a.exr"), before);
}

TEST_F(Merge, arithmetic_that_other_devices_do_not_have_is_said) {
  // Kernels whose probe finds another sum; of the picture's they change nothing.
  std::filesystem::copy(std::string(EIKON_SOURCE_DIR) + "/kernels", here / "kernels",
                        std::filesystem::copy_options::recursive);
  std::string probe = bytes("kernels/probe/arithmetic.h");
  const std::string sum = "AS_U(a * b + c)";
  ASSERT_TRUE(contains(probe, sum));
  here.write("kernels/probe/arithmetic.h", probe.replace(probe.find(sum), sum.size(), "AS_U(a * b - c)"));
  const auto render = [&](const std::string& output, const std::string& flags, const std::string& before) {
    const Outcome outcome =
        here.eikon("render " + scene("cornell.gltf") + " -o " + output + " --size 24x20 --quiet " + flags, before);
    EXPECT_TRUE(succeeded(outcome));
    return outcome.err;
  };
  const std::string other = "EIKON_KERNEL_DIR=" + (here / "kernels").string();
  const std::string line = render("a.exr", "--samples 0:2", other);
  const std::string begin = "eikon: arithmetic other-",
                    end = ": other devices may give other bits; see `eikon selftest`\n";
  ASSERT_EQ(line.rfind(begin, 0), 0U) << line;
  EXPECT_EQ(line.find(end), begin.size() + 8) << line;
  EXPECT_EQ(render("b.exr", "--samples 2:4", ""), "");
  const Outcome both = merge("a.exr b.exr", "out.exr");
  EXPECT_TRUE(succeeded(both));
  EXPECT_EQ(both.err, "eikon: arithmetic exact, " + line.substr(std::string("eikon: arithmetic ").size()));
  EXPECT_EQ(merge("b.exr", "out.exr").err,
            "eikon: the parts begin with sample 2: samples 0 to 1 are in none of them\n");
}

TEST_F(Merge, what_does_not_belong_together_is_refused_by_name) {
  part("a.exr", "--samples 0:4");
  part("again.exr", "--samples 3:6 --crop 20,0,24,4");
  expect_refused("a.exr again.exr", {"\"again.exr\"", "\"a.exr\"", "samples 3:4", "20,0 to 23,3"});
  expect_refused("a.exr a.exr", {"samples 0:4"});
  part("seed.exr", "--samples 4:6 --seed 3");
  expect_refused("a.exr seed.exr", {"\"seed.exr\"", "\"a.exr\"", "seed (--seed) is 3, not 0"});
  part("size.exr", "--samples 4:6");
  ASSERT_TRUE(
      succeeded(here.eikon("render " + scene("cornell.gltf") + " -o size.exr --size 24x21 --samples 4:6 --quiet")));
  expect_refused("a.exr size.exr", {"size (--size) is 24x21, not 24x20"});
  part("scene.exr", "--samples 4:6 --look-at 0,0,3:0,0,0 --fov 40", "sphere_in_sky.gltf");
  expect_refused("a.exr scene.exr", {"scene's hash is"});
  part("picture.exr", "--spp 4");
  expect_refused("a.exr picture.exr", {"\"picture.exr\"", "plain picture"});
  expect_refused("a.exr missing.exr", {"missing.exr", "no such file"});
  here.write("short.exr", bytes("a.exr").substr(0, bytes("a.exr").size() - 40));
  expect_refused("short.exr", {"\"short.exr\""});
  std::string flipped = bytes("a.exr");
  const std::size_t at = flipped.find("part 0 0 24 20 0 4");
  ASSERT_NE(at, std::string::npos);
  flipped[at + 17] = '3';  // samples 0 to 3, though the sums have 4
  here.write("flipped.exr", flipped);
  expect_refused("flipped.exr", {"flipped.exr", "checksum"});
}

TEST_F(Merge, has_one_part_at_a_time_in_memory) {
  const auto peak_bytes = [&](const std::string& parts) {
    return here.peak_bytes("merge " + parts + " -o out.exr --quiet");
  };
  std::string parts;
  for (int i = 0; i < 6; ++i) {
    const std::string file = "p" + std::to_string(i) + ".exr";
    ASSERT_TRUE(
        succeeded(here.eikon("render " + scene("cornell.gltf") + " -o " + file + " --size 384x384 --quiet --samples " +
                             std::to_string(i) + ":" + std::to_string(i + 1))));
    parts += " " + file;
  }
  constexpr std::int64_t film_bytes = 384 * 384 * (2 * 3 * 16 + 2 * 8);
  EXPECT_LT(peak_bytes(parts) - peak_bytes("p0.exr"), film_bytes / 2);
}

/// The commands of a section of the page on many machines: its indented lines.
std::string commands_of(const std::string& title) {
  std::ifstream manual(std::string(EIKON_SOURCE_DIR) + "/host/cli/MANY.md");
  std::string commands;
  bool inside = false;
  for (std::string line; std::getline(manual, line);) {
    if (line.rfind("## ", 0) == 0) inside = line == "## " + title;
    if (inside && line.rfind("    ", 0) == 0) commands += line.substr(4) + "\n";
  }
  return commands;
}

TEST_F(Merge, the_manual_s_commands_for_sharing_an_image_do_as_they_say) {
  const std::string commands = commands_of("Share one image between machines");
  ASSERT_TRUE(contains(commands, "eikon merge"));
  std::filesystem::create_directory(here / "out");
  std::filesystem::create_directory(here / "bin");
  std::filesystem::create_symlink(EIKON_BINARY, here / "bin/eikon");
  std::filesystem::create_directory_symlink(std::string(EIKON_SOURCE_DIR) + "/scenes", here / "scenes");
  here.write("commands.sh", "set -e\n" + commands);
  const Outcome outcome = here.shell("PATH=$PWD/bin:$PATH sh commands.sh");
  ASSERT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.out, "openjd_progress: 100.0") && contains(outcome.out, "as it says")) << outcome.out;
  const auto planes = [&](const std::string& file) { return read_exr(here / file).planes; };
  const auto whole = [&](const std::string& spp) {
    EXPECT_TRUE(
        succeeded(here.eikon("render " + scene("cornell.gltf") + " -o whole.exr --size 128x128 --quiet --spp " + spp)));
    return planes("whole.exr");
  };
  EXPECT_EQ(planes("out/shared.exr"), whole("48"));
  EXPECT_EQ(planes("out/stacked.exr"), whole("64"));
  EXPECT_EQ(planes("out/filled.exr"), whole("32"));
}

}  // namespace
}  // namespace eikon::test
