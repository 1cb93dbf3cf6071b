// SPDX-License-Identifier: Apache-2.0
// Layers, partial sums, the denoised picture and the light meter, as a user asks for them.
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "film/exr/film_file.h"
#include "image/image.h"
#include "instruments/analytic_scenes.h"

namespace eikon::test {
namespace {

using nlohmann::json;

double mean_of(const Image& image, const std::string& channel) {
  const std::vector<float>* plane = image.plane(channel);
  if (plane == nullptr) throw std::runtime_error("no channel " + channel);
  double sum = 0;
  for (const float value : *plane) sum += double(value);
  return sum / double(plane->size());
}

TEST(Layers, light_groups_of_a_scene_are_channels_that_add_up) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon("render " + scene("lamps.gltf") +
                                   " -o a.exr --size 24x16 --spp 16 --quiet --aov light_groups,direct")));
  const Image image = read_exr(here / "a.exr");
  double sum = 0;
  for (const char* group : {"warm", "green", "cold"}) {
    const double red = mean_of(image, std::string("light.") + group + ".R");
    EXPECT_GT(red, 0) << group;
    sum += red;
  }
  EXPECT_EQ(mean_of(image, "light.rest.R"), 0);
  EXPECT_NEAR(sum, mean_of(image, "R"), 1e-5 * sum);
  EXPECT_GT(mean_of(image, "light.warm.R"), mean_of(image, "light.warm.B"));
  EXPECT_LT(mean_of(image, "light.cold.R"), mean_of(image, "light.cold.B"));
  EXPECT_GT(mean_of(image, "direct.R"), 0);
}

TEST(Layers, survive_checkpoints_and_merging) {
  const Workplace here;
  const std::string render = "render " + scene("lamps.gltf") +
                             " --size 24x16 --quiet --aov light_groups,indirect,position --depth-series 0,3 -o ";
  ASSERT_TRUE(succeeded(here.eikon(render + "whole.exr --spp 8 --crop 0,0,24,16")));
  ASSERT_TRUE(succeeded(here.eikon(render + "a.exr --spp 8 --samples 0:3")));
  ASSERT_TRUE(succeeded(here.eikon(render + "b.exr --spp 8 --samples 3:8")));
  ASSERT_TRUE(succeeded(here.eikon("merge a.exr b.exr -o c.exr")));
  EXPECT_TRUE(same_bits(read_film(here / "whole.exr"), read_film(here / "c.exr")));
  const Image whole = read_exr(here / "whole.exr"), merged = read_exr(here / "c.exr");
  for (const char* channel : {"light.warm.G", "indirect.B", "position.X"})
    EXPECT_EQ(*whole.plane(channel), *merged.plane(channel)) << channel;
}

TEST(DepthSeries, writes_a_picture_for_each_and_refuses_to_overwrite) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 24x16 --spp 8 --quiet --png out.png --depth-series 8,0,1,2,1"))));
  double before = -1;
  for (const char* depth : {"0", "1", "2", "8"}) {
    const std::string name = std::string("out.depth") + depth;
    const Image image = read_exr(here / (name + ".exr"));
    EXPECT_EQ(image.channels.size(), 3U);
    const Metadata metadata = read_metadata(here / (name + ".exr"));
    EXPECT_EQ(metadata.numbers.at("scatteredAtMost"), std::stod(depth));
    EXPECT_TRUE(metadata.numbers.contains("relmsePredicted")) << "the error of " << name << " is not stated";
    EXPECT_TRUE(std::filesystem::exists(here / (name + ".png")));
    EXPECT_GT(mean_of(image, "G"), before) << depth;
    before = mean_of(image, "G");
  }
  EXPECT_GT(mean_of(read_exr(here / "out.exr"), "G"), before);
  // A picture that is not wanted for itself is not written over either.
  std::filesystem::create_directory(here / "taken.depth1.exr");
  const Outcome outcome = here.eikon("render " + scene("cornell.gltf") + " -o taken.exr --size 8x8 --depth-series 1");
  EXPECT_TRUE(refused(outcome, kInput));
  EXPECT_TRUE(contains(outcome.err, "taken.depth1.exr"));
  EXPECT_FALSE(std::filesystem::exists(here / "taken.exr"));
}

TEST(Denoise, leaves_the_noisy_picture_and_comes_closer_to_the_truth) {
  const char* const library = std::getenv("EIKON_OIDN");
  const Workplace here;
  const std::string render = cornell("--size 64x64 --quiet ");
  if (library == nullptr || !std::filesystem::exists(library))
    GTEST_SKIP() << "EIKON_OIDN does not name Open Image Denoise's library";
  ASSERT_TRUE(succeeded(here.eikon(render + "--spp 8 --png noisy.png")));
  const Image noisy = read_exr(here / "out.exr");
  ASSERT_TRUE(succeeded(here.eikon(render + "--spp 8 --png denoised.png --denoise")));
  const Image both = read_exr(here / "out.exr");
  EXPECT_EQ(both.channels, (std::vector<std::string>{"B", "G", "R", "denoised.B", "denoised.G", "denoised.R"}));
  for (const char* channel : {"R", "G", "B"}) EXPECT_EQ(*both.plane(channel), *noisy.plane(channel));
  EXPECT_NE(read_bytes(here / "noisy.png"), read_bytes(here / "denoised.png"));
  ASSERT_TRUE(succeeded(here.eikon(render + "--spp 2048 --seed 9")));
  const Image truth = read_exr(here / "out.exr");
  Image guess = noisy;
  for (std::size_t c = 0; c < 3; ++c) guess.planes[c] = *both.plane("denoised." + guess.channels[c]);
  EXPECT_LT(compare_images(guess, truth).relmse, 0.3 * compare_images(noisy, truth).relmse);
}

TEST(Denoise, without_the_library_is_one_line_before_anything_is_rendered) {
  const Workplace here;
  const Outcome missing = here.eikon(cornell("--size 8x8 --denoise"), "EIKON_OIDN=/nowhere/libOpenImageDenoise.so.2");
  EXPECT_TRUE(refused(missing, kInput));
  EXPECT_TRUE(contains(missing.err, "Open Image Denoise"));
  const Outcome other = here.eikon(cornell("--size 8x8 --denoise"), "EIKON_OIDN=libm.so.6");
  EXPECT_TRUE(refused(other, kInput));
  EXPECT_TRUE(contains(other.err, "is not Open Image Denoise 2"));
  EXPECT_TRUE(here.files().empty());
}

TEST(Meter, says_what_it_measured_and_how_surely) {
  const Workplace here;
  const Outcome outcome =
      here.eikon("meter " + scene("cornell.gltf") + " --at 0.278,0,0.28 --facing 0,1,0 --spp 16 --json");
  ASSERT_TRUE(succeeded(outcome));
  const json reading = json::parse(outcome.out);
  EXPECT_EQ(reading.at("quantity"), "irradiance");
  EXPECT_EQ(reading.at("unit"), "W/m^2");
  EXPECT_EQ(reading.at("paths"), 16 * 256);
  EXPECT_EQ(reading.at("rejected"), 0);
  EXPECT_NEAR(reading.at("side"), 0.5 * 0.28 / 4096, 1e-7);  // of the middle of the receiver, which follows its place
  EXPECT_EQ(outcome.err, "");
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_GT(reading.at("value")[c], 0.1);
    EXPECT_GT(reading.at("standard_error")[c], 0);
    EXPECT_LT(reading.at("standard_error")[c], 0.05 * reading.at("value")[c].get<double>());
  }
  // Up into the lamp.
  const Outcome lamp = here.eikon("meter " + scene("cornell.gltf") + " --at 0.278,0.3,0.28 --from 0,1,0 --spp 1");
  ASSERT_TRUE(succeeded(lamp));
  EXPECT_TRUE(contains(lamp.out, "radiance at"));
  EXPECT_TRUE(contains(lamp.out, "W/(sr m^2)"));
}

TEST(Meter, says_which_paths_it_left_out_and_refuses_them_with_strict) {
  const Workplace here;
  json gltf = read_json(scene("cornell.gltf"));
  for (json& material : gltf.at("materials"))
    if (material.contains("extensions") && material["extensions"].contains("KHR_materials_emissive_strength"))
      material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 1e25;
  here.write("glaring.gltf", gltf.dump());
  const std::string measured =
      "meter glaring.gltf --at 0.278,0.001,0.28 --facing 0,1,0 --spp 4 --light-sampling cosine --json";
  const Outcome outcome = here.eikon(measured);
  ASSERT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.err, "the reading is without them")) << outcome.err;
  const json reading = json::parse(outcome.out);
  EXPECT_GT(reading.at("rejected"), 0);
  EXPECT_EQ(reading.at("rejected").get<int>() + reading.at("paths").get<int>(), 4 * 256);
  const Outcome strict = here.eikon(measured + " --strict");
  EXPECT_TRUE(refused(strict, kInput));
  EXPECT_TRUE(contains(strict.err, "(--strict)"));
}

TEST(Meter, refuses_to_read_where_no_path_is_left) {
  const Workplace here;
  const std::string bright =
      "meter " + scene("sphere_in_sky.gltf") + " --env 1e20,1e20,1e20 --at 0,5,0 --facing 0,1,0 --spp 2";
  for (const char* flag : {"", " --json"}) {
    const Outcome outcome = here.eikon(bright + flag);
    EXPECT_TRUE(refused(outcome, kInput)) << flag;
    EXPECT_TRUE(contains(outcome.err, "512 samples were rejected (0 not finite, 512 beyond the film's range)"));
    EXPECT_TRUE(contains(outcome.err, "nothing is left to be read"));
    EXPECT_EQ(outcome.out, "");
  }
}

TEST(Meter, warns_beside_its_json_too) {
  const Workplace here;
  const std::string at = " --at 0.5,1,0.5 --facing 0,1,0 --spp 1 --env none --json";
  json gltf = read_json(scene("cornell_spheres.gltf"));
  gltf["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  gltf["extensionsUsed"].push_back("KHR_lights_punctual");
  gltf["scenes"][0]["nodes"].push_back(gltf["nodes"].size());
  gltf["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  here.write("bulb.gltf", gltf.dump());
  const Outcome outcome = here.eikon("meter bulb.gltf" + at);
  ASSERT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.err, "a meter traces no light paths")) << outcome.err;
  EXPECT_TRUE(json::parse(outcome.out).contains("value"));
}

TEST(Meter, refuses_what_it_cannot_mean) {
  const Workplace here;
  const std::string at = "meter " + scene("cornell.gltf") + " --at 0,1,0 ";
  for (const char* flags : {"", "--facing 0,1,0 --from 0,1,0", "--facing 0,0,0", "--from 1,2", "--facing up",
                            "--facing 1e300,1e300,0 --spp 0", "--facing 0,1,0 --spp 0"})
    EXPECT_TRUE(refused(here.eikon(at + flags), kUsage)) << flags;
  EXPECT_TRUE(refused(here.eikon("meter " + scene("cornell.gltf") + " --facing 0,1,0"), kUsage));
  EXPECT_TRUE(refused(here.eikon("meter " + scene("cornell.gltf") + " --at 1e30,0,0 --facing 0,1,0"), kInput));
  EXPECT_TRUE(refused(here.eikon("meter missing.gltf --at 0,0,0 --facing 0,1,0"), kInput));
  EXPECT_TRUE(here.files().empty());
}

}  // namespace
}  // namespace eikon::test
