// SPDX-License-Identifier: Apache-2.0
// Motion blur on the command line.
#include <fmt/format.h>

#include "cli/batch/batch_outcome.h"

namespace eikon::test {
namespace {

std::string wheel(const std::string& flags) {
  return fmt::format("render {} --size 24x16 --spp 4 --frame 6 {}", scene("spinning_wheel.gltf"), flags);
}

TEST(Shutter, a_shutter_of_0_gives_the_still_to_the_bit_and_an_open_one_another_picture) {
  const Workplace here;
  EXPECT_TRUE(succeeded(here.eikon(wheel("-o still.exr"))));
  const Outcome shut = here.eikon(wheel("-o shut.exr --shutter 0 --shutter-at centre --motion-steps 9"));
  EXPECT_TRUE(succeeded(shut));
  EXPECT_FALSE(contains(shut.err, "shutter"));
  EXPECT_TRUE(same_picture(here / "still.exr", here / "shut.exr"));
  const Outcome open = here.eikon(wheel("-o open.exr --shutter 2"));
  EXPECT_TRUE(succeeded(open));
  EXPECT_TRUE(contains(open.err, "the shutter is open from 0.25 to 0.333333 s, in "));
  EXPECT_FALSE(same_picture(here / "still.exr", here / "open.exr"));
}

TEST(Shutter, it_opens_is_half_way_or_closes_at_the_time_of_the_frame) {
  const Workplace here;
  const auto says = [&](const std::string& flags, const std::string& text) {
    const Outcome outcome = here.eikon(wheel("-o a.exr --motion-steps 3 --fps 12 --shutter 0.5 " + flags));
    EXPECT_TRUE(succeeded(outcome));
    EXPECT_TRUE(contains(outcome.err, text));
  };
  says("--shutter-at open", "the shutter is open from 0.5 to 0.541667 s, in 3 steps");
  says("--shutter-at centre", "the shutter is open from 0.479167 to 0.520833 s, in 3 steps");
  says("--shutter-at close", "the shutter is open from 0.458333 to 0.5 s, in 3 steps");
}

TEST(Shutter, parts_of_a_blurred_image_merge_to_its_bits) {
  const Workplace here;
  EXPECT_TRUE(succeeded(here.eikon(wheel("-o whole.exr --shutter 3"))));
  EXPECT_TRUE(succeeded(here.eikon(wheel("-o a.exr --shutter 3 --samples 0:1 --layout bvh4"))));
  EXPECT_TRUE(succeeded(here.eikon(wheel("-o b.exr --shutter 3 --samples 1:4 --threads 1"))));
  EXPECT_TRUE(succeeded(here.eikon("merge a.exr b.exr -o merged.exr")));
  EXPECT_TRUE(same_picture(here / "whole.exr", here / "merged.exr"));
  EXPECT_TRUE(succeeded(here.eikon(wheel("-o other.exr --shutter 2 --samples 1:4"))));
  EXPECT_EQ(here.eikon("merge a.exr other.exr -o none.exr").code, kInput) << "other shutters do not merge";
}

TEST(Shutter, a_still_file_is_rendered_as_it_is_and_that_is_said) {
  const Workplace here;
  const Outcome outcome =
      here.eikon(fmt::format("render {} --size 8x8 --spp 1 -o a.exr --shutter 1", scene("square_light.gltf")));
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.err, "--shutter 1: nothing moves while it is open"));
}

TEST(Shutter, what_it_cannot_do_is_refused_in_one_line) {
  const Workplace here;
  for (const char* flags :
       {"--shutter -1", "--shutter x", "--shutter 1e9", "--shutter nan", "--shutter 1 --shutter-at dawn",
        "--shutter 1 --motion-steps 0", "--shutter 1 --motion-steps 1000", "--shutter 1 --motion-steps few"}) {
    const Outcome outcome = here.eikon(wheel(std::string("-o a.exr --quiet ") + flags));
    EXPECT_EQ(outcome.code, kUsage) << flags;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(here / "a.exr")) << flags;
  }
}

}  // namespace
}  // namespace eikon::test
