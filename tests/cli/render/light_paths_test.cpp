// SPDX-License-Identifier: Apache-2.0
// --light-paths, as a user meets it: parts, resumed renders, and what is refused.
#include <fmt/format.h>

#include "cli/batch/batch_outcome.h"
#include "cli/render/checkpoint_files.h"

namespace eikon::test {
namespace {

const std::string kSpheres = "render " + scene("cornell_spheres.gltf") + " --size 40x30 --guiding off --quiet ";

bool same_planes(const Workplace& here, const std::string& a, const std::string& b) {
  return read_exr(here / a).planes == read_exr(here / b).planes;
}

TEST(LightPathsOption, parts_by_samples_and_windows_merge_to_the_whole_image) {
  const Workplace here;
  const std::string layers = "--aov direct,indirect,variance ";
  ASSERT_TRUE(succeeded(here.eikon(kSpheres + layers + "--spp 6 -o whole.exr")));
  ASSERT_TRUE(succeeded(here.eikon(kSpheres + layers + "--samples 0:1 -o a.exr")));
  ASSERT_TRUE(succeeded(here.eikon(kSpheres + layers + "--samples 1:6 -o b.exr")));
  ASSERT_TRUE(succeeded(here.eikon("merge a.exr b.exr -o samples.exr")));
  EXPECT_TRUE(same_planes(here, "samples.exr", "whole.exr"));
  ASSERT_TRUE(succeeded(here.eikon(kSpheres + layers + "--spp 6 --crop 0,0,40,11 -o top.exr")));
  ASSERT_TRUE(succeeded(here.eikon(kSpheres + layers + "--spp 6 --crop 0,11,40,30 -o bottom.exr")));
  ASSERT_TRUE(succeeded(here.eikon("merge top.exr bottom.exr -o windows.exr")));
  EXPECT_TRUE(same_planes(here, "windows.exr", "whole.exr"));
  ASSERT_TRUE(succeeded(here.eikon(kSpheres + layers + "--spp 6 --light-paths off -o off.exr")));
  EXPECT_FALSE(same_planes(here, "off.exr", "whole.exr"));
}

TEST(LightPathsOption, a_render_goes_on_with_the_bits_of_one_that_was_never_stopped) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(kSpheres + "--spp 9 -o whole.exr")));
  ASSERT_TRUE(succeeded(here.eikon(kSpheres + "--spp 4 -o first.exr --checkpoint c.exr")));
  ASSERT_TRUE(succeeded(here.eikon(kSpheres + "--spp 9 -o more.exr --checkpoint c.exr --resume")));
  EXPECT_TRUE(same_planes(here, "more.exr", "whole.exr"));
  const Outcome other = here.eikon(kSpheres + "--spp 9 -o x.exr --checkpoint c.exr --resume --light-paths 0.5");
  EXPECT_TRUE(refused(other, kInput));
  EXPECT_TRUE(contains(other.err, "its light paths (--light-paths) is 75 of each sample, not 600 of each sample"))
      << other.err;
}

TEST(LightPathsOption, a_device_that_fails_in_between_changes_no_bit) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(kSpheres + "--spp 32 -o whole.exr")));
  const Outcome outcome = here.eikon(kSpheres + "--spp 32 -o faulty.exr", "EIKON_FAULT=device:0:after=1:times=1");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(same_planes(here, "faulty.exr", "whole.exr"));
}

TEST(LightPathsOption, replayed_samples_add_up_to_the_pixel) {
  const Workplace here;
  const std::string image = kSpheres + "--light-paths 1 ";
  ASSERT_TRUE(succeeded(here.eikon(image + "--spp 3 -o out.exr")));
  double sum = 0;
  std::size_t light_paths = 0;
  for (int sample = 0; sample < 3; ++sample) {
    const Outcome outcome = here.eikon(image + fmt::format("--pixel 23,26 --sample {}", sample));
    ASSERT_TRUE(succeeded(outcome));
    const std::size_t at = outcome.out.rfind("  radiance (");
    ASSERT_NE(at, std::string::npos) << outcome.out;
    sum += std::stod(outcome.out.substr(at + 12));
    for (std::size_t found = 0; (found = outcome.out.find("  light path: ", found)) != std::string::npos; ++found)
      ++light_paths;
  }
  EXPECT_GT(light_paths, 0U);
  const double pixel = read_exr(here / "out.exr").plane("R")->at(26 * 40 + 23);
  EXPECT_NEAR(sum / 3, pixel, 1e-3 * pixel);  // EXR has half floats
}

TEST(LightPathsOption, is_refused_where_it_means_nothing) {
  const Workplace here;
  for (const char* value : {"2", "-1", "nan", "many", "\"\""}) {
    const Outcome outcome = here.eikon(kSpheres + "-o x.exr --light-paths=" + value);
    EXPECT_TRUE(refused(outcome, kUsage)) << value;
    EXPECT_TRUE(contains(outcome.err, "--light-paths")) << outcome.err;
  }
}

TEST(LightPathsOption, says_which_glass_still_hides_a_bulb) {
  const Workplace here;
  const std::string room = "render " + scene("sun_room.gltf") + " --size 16x12 --spp 1 -o a.exr ";
  EXPECT_FALSE(contains(here.eikon(room).err, "does not pass"));
  EXPECT_TRUE(contains(here.eikon(room + "--light-paths off").err, "does not pass through transmissive surfaces"));
}

}  // namespace
}  // namespace eikon::test
