// SPDX-License-Identifier: Apache-2.0
// --light-paths, as a user meets it: parts, resumed renders, and what is refused.
#include <fmt/format.h>

#include "cli/batch/batch_outcome.h"
#include "cli/render/checkpoint_files.h"
#include "support/signed_pilot.h"

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
  EXPECT_TRUE(contains(other.err, "its light paths (--light-paths) is 75 of each sample, not 600 of each sample"));
}

TEST(LightPathsOption, usual_ones_are_a_quarter_where_they_alone_find_some_of_the_light_else_a_sixteenth) {
  const Workplace here;
  const auto same = [&](const char* name, const char* ratio) {
    const std::string image = "render " + scene(name) + " --size 40x30 --spp 2 --guiding off --quiet ";
    EXPECT_TRUE(succeeded(here.eikon(image + "-o usual.exr --light-paths usual")));
    EXPECT_TRUE(succeeded(here.eikon(image + "-o ratio.exr --light-paths " + ratio)));
    return same_planes(here, "usual.exr", "ratio.exr");
  };
  EXPECT_TRUE(same("cornell_spheres.gltf", "0.0625"));
  EXPECT_TRUE(same("glazed_room.gltf", "0.25"));
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

const std::string kTried = "render " + scene("cornell_spheres.gltf") + " --size 160x120 --guiding off --quiet ";

TEST(LightPathsOption, a_trial_decides_alike_for_all_parts_of_an_image) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(kTried + "--spp 3 -o whole.exr --stats whole.json")));
  ASSERT_TRUE(succeeded(here.eikon(kTried + "--samples 0:1 -o a.exr --pilot p")));
  ASSERT_TRUE(succeeded(here.eikon(kTried + "--samples 1:3 --crop 0,0,160,50 -o b.exr --pilot p")));
  ASSERT_TRUE(succeeded(here.eikon(kTried + "--samples 1:3 --crop 0,50,160,120 -o c.exr")));
  ASSERT_TRUE(succeeded(here.eikon("merge a.exr b.exr c.exr -o merged.exr")));
  EXPECT_TRUE(same_planes(here, "merged.exr", "whole.exr"));
  const nlohmann::json pilot = read_json(here / "whole.json").at("pilot");
  EXPECT_EQ(pilot.at("light_path_count"), 1200);
  EXPECT_GT(pilot.at("light_path_gain"), 3);
  EXPECT_EQ(pilot.at("paths"), 0);
}

TEST(LightPathsOption, a_small_picture_has_a_trial_where_nothing_else_finds_some_of_the_light) {
  const Workplace here;
  const std::string room = "render " + scene("glazed_room.gltf") + " --size 96x64 --spp 64 --quiet ";
  ASSERT_TRUE(succeeded(here.eikon(room + "--seed 1 --light-paths 4 -o reference.exr")));
  ASSERT_TRUE(succeeded(here.eikon(room + "--seed 21 -o a.exr --stats a.json")));
  const Outcome compared = here.eikon("compare a.exr reference.exr --json");
  ASSERT_TRUE(succeeded(compared));
  // With one light path for sixteen paths from the camera it is 93: one of them comes by the vase
  // and brings 8,680 to a pixel of 0.25.
  EXPECT_LT(nlohmann::json::parse(compared.out).at("relmse"), 0.3);
  const nlohmann::json with_trial = read_json(here / "a.json").at("pilot");
  ASSERT_FALSE(with_trial.is_null());
  EXPECT_GE(with_trial.at("light_path_count"), 96 * 64 / 4);
  // Rays meet the lamp of the other scene, so its small pictures have no trial.
  ASSERT_TRUE(succeeded(here.eikon(kSpheres + "--spp 1 -o b.exr --stats b.json")));
  EXPECT_TRUE(read_json(here / "b.json").at("pilot").is_null());
}

/// Changes how many light paths a file of --pilot says that there are to be.
void decide_otherwise(const Workplace& here, const std::string& pilot) {
  std::string bytes = read_bytes(here / pilot);
  const std::string line = "light paths of each sample: ";
  const std::size_t at = bytes.find(line + "1200");
  ASSERT_NE(at, std::string::npos);
  here.write(pilot, signed_again(bytes.replace(at, line.size() + 4, line + "4800")));
}

TEST(LightPathsOption, sums_for_which_trials_decided_differently_are_not_added) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(kTried + "--samples 0:1 -o a.exr --pilot p --checkpoint c.exr")));
  decide_otherwise(here, "p");
  ASSERT_TRUE(succeeded(here.eikon(kTried + "--samples 1:2 -o b.exr --pilot p")));
  const Outcome merged = here.eikon("merge a.exr b.exr -o m.exr");
  EXPECT_TRUE(refused(merged, kInput));
  EXPECT_TRUE(contains(merged.err, "it has 4800 light paths of each sample, not 1200"));
  const Outcome resumed = here.eikon(kTried + "--spp 2 -o d.exr --pilot p --checkpoint c.exr --resume");
  EXPECT_TRUE(refused(resumed, kInput));
  EXPECT_TRUE(contains(resumed.err, "the sums to go on from have 1200 light paths of each sample"));
}

TEST(LightPathsOption, takes_a_number_that_begins_with_its_point) {
  const Workplace here;
  EXPECT_TRUE(succeeded(here.eikon(kSpheres + "--spp 1 -o x.exr --light-paths .25")));
}

TEST(LightPathsOption, is_refused_where_it_means_nothing) {
  const Workplace here;
  for (const char* value : {"5", "-1", "nan", "many", "\"\""}) {
    const Outcome outcome = here.eikon(kSpheres + "-o x.exr --light-paths=" + value);
    EXPECT_TRUE(refused(outcome, kUsage)) << value;
    EXPECT_TRUE(contains(outcome.err, "--light-paths"));
  }
}

const std::string kMerged = kSpheres + "--caustics merge ";

TEST(CausticsOption, parts_merge_and_renders_go_on_with_the_bits_of_the_whole) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(kMerged + "--spp 48 -o whole.exr")));
  ASSERT_TRUE(succeeded(here.eikon(kSpheres + "--spp 48 -o unbiased.exr")));
  EXPECT_FALSE(same_planes(here, "unbiased.exr", "whole.exr"));
  ASSERT_TRUE(succeeded(here.eikon(kMerged + "--samples 0:5 -o a.exr")));
  ASSERT_TRUE(succeeded(here.eikon(kMerged + "--samples 5:48 --crop 0,0,40,11 -o b.exr")));
  ASSERT_TRUE(succeeded(here.eikon(kMerged + "--samples 5:48 --crop 0,11,40,30 --threads 1 -o c.exr")));
  ASSERT_TRUE(succeeded(here.eikon("merge a.exr b.exr c.exr -o merged.exr")));
  EXPECT_TRUE(same_planes(here, "merged.exr", "whole.exr"));
  ASSERT_TRUE(succeeded(here.eikon(kMerged + "--spp 9 -o first.exr --checkpoint c.exr")));
  ASSERT_TRUE(succeeded(here.eikon(kMerged + "--spp 48 -o more.exr --checkpoint c.exr --resume")));
  EXPECT_TRUE(same_planes(here, "more.exr", "whole.exr"));
  const Outcome other = here.eikon(kSpheres + "--spp 48 -o x.exr --checkpoint c.exr --resume");
  EXPECT_TRUE(refused(other, kInput));
  EXPECT_TRUE(contains(other.err, "its caustics (--caustics) is merge, not unbiased"));
}

TEST(CausticsOption, says_in_every_place_that_the_image_is_biased) {
  const Workplace here;
  const Outcome outcome =
      here.eikon("render " + scene("cornell_spheres.gltf") +
                 " --size 40x30 --guiding off --caustics merge --samples 0:2 -o a.exr --stats a.json");
  ASSERT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.err, "the image has a bias"));
  EXPECT_TRUE(contains(outcome.out, "the bias of --caustics merge is not in it"));
  EXPECT_EQ(read_json(here / "a.json").at("settings").at("caustics"), "merge: biased, less with each sample");
  ASSERT_TRUE(succeeded(here.eikon(kMerged + "--samples 2:3 -o b.exr")));
  ASSERT_TRUE(succeeded(here.eikon("merge a.exr b.exr -o m.exr")));
  for (const char* image : {"a.exr", "m.exr"})
    EXPECT_TRUE(contains(read_bytes(here / image), "merge: biased, less with each sample")) << image;
}

TEST(CausticsOption, replayed_samples_add_up_to_the_pixel) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(kMerged + "--spp 3 -o out.exr")));
  double sum = 0;
  for (int sample = 0; sample < 3; ++sample) {
    const Outcome outcome = here.eikon(kMerged + fmt::format("--pixel 26,23 --sample {}", sample));
    ASSERT_TRUE(succeeded(outcome));
    sum += std::stod(outcome.out.substr(outcome.out.rfind("  radiance (") + 12));
  }
  const double pixel = read_exr(here / "out.exr").plane("R")->at(23 * 40 + 26);
  EXPECT_NEAR(sum / 3, pixel, 1e-3 * pixel);  // EXR has half floats
}

TEST(CausticsOption, is_refused_where_it_means_nothing) {
  const Workplace here;
  for (const char* flags : {"--strict", "--integrator whitted", "--integrator raycast", "--integrator direct",
                            "--light-sampling bsdf", "--light-paths off"}) {
    const Outcome outcome = here.eikon(kMerged + "-o x.exr " + flags);
    EXPECT_TRUE(refused(outcome, kUsage)) << flags;
    EXPECT_TRUE(contains(outcome.err, "--caustics merge: "));
  }
  EXPECT_TRUE(refused(here.eikon(kSpheres + "-o x.exr --caustics some"), kUsage));
  const Outcome nothing =
      here.eikon("render " + scene("cornell.gltf") + " --size 8x8 --spp 1 -o a.exr --caustics merge");
  ASSERT_TRUE(succeeded(nothing));
  EXPECT_TRUE(contains(nothing.err, "nothing is merged"));
}

TEST(LightPathsOption, is_refused_where_there_are_no_light_paths) {
  const Workplace here;
  for (const char* flags :
       {"--integrator whitted", "--integrator raycast", "--integrator direct", "--light-sampling bsdf"}) {
    const Outcome outcome = here.eikon(kSpheres + "-o x.exr --light-paths 0.25 " + flags);
    EXPECT_TRUE(refused(outcome, kUsage)) << flags;
    EXPECT_TRUE(contains(outcome.err, "--light-paths: "));
    EXPECT_TRUE(succeeded(here.eikon(kSpheres + "-o x.exr --spp 1 " + flags))) << "not asked for";
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
