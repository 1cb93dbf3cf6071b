// SPDX-License-Identifier: Apache-2.0
// The flags that say how a picture is taken and shown, as a user gives them.
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "film/exr/film_file.h"
#include "image/image.h"

namespace eikon::test {
namespace {

using nlohmann::json;

TEST(Picture, a_tone_curve_changes_the_png_and_not_the_exr) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 16x12 --spp 4 --quiet --png plain.png"))));
  const Image plain = read_exr(here / "out.exr");
  std::vector<std::string> pictures = {read_bytes(here / "plain.png")};
  for (const char* map : {"reinhard", "aces", "agx", "pbr-neutral"}) {
    const std::string name = std::string(map) + ".png";
    ASSERT_TRUE(succeeded(here.eikon(cornell("--size 16x12 --spp 4 --quiet --tonemap ") + map + " --png " + name)));
    EXPECT_EQ(read_exr(here / "out.exr").planes, plain.planes) << map;
    pictures.push_back(read_bytes(here / name));
  }
  std::sort(pictures.begin(), pictures.end());
  EXPECT_EQ(std::unique(pictures.begin(), pictures.end()), pictures.end()) << "two curves gave one picture";
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 16x12 --spp 4 --quiet --tonemap none --png none.png"))));
  EXPECT_EQ(read_bytes(here / "none.png"), read_bytes(here / "plain.png"));
}

TEST(Picture, transparent_has_alpha_in_both_files_and_can_be_compared) {
  const Workplace here;
  const std::string ball = "render " + scene("sphere_in_sky.gltf") + " --size 9x9 --spp 4 --quiet -o ";
  ASSERT_TRUE(succeeded(here.eikon(ball + "cut.exr --png cut.png --transparent --half --crop 0,0,9,9")));
  ASSERT_TRUE(succeeded(here.eikon(ball + "whole.exr")));
  const Image cut = read_exr(here / "cut.exr");
  ASSERT_NE(cut.plane("A"), nullptr);
  EXPECT_EQ((*cut.plane("A"))[0], 0);
  EXPECT_EQ((*cut.plane("R"))[0], 0);
  EXPECT_EQ((*cut.plane("A"))[40], 1);
  EXPECT_GT((*cut.plane("R"))[40], 0.1F);
  EXPECT_TRUE(read_film(here / "cut.exr").channel_index("A").has_value());
  EXPECT_EQ(read_bytes(here / "cut.png").at(25), 6) << "the PNG's colour type is not RGBA";
  EXPECT_EQ(read_exr(here / "whole.exr").plane("A"), nullptr);
  EXPECT_TRUE(succeeded(here.eikon("compare cut.exr whole.exr")));
}

TEST(Picture, the_camera_sees_through_the_backs_of_walls_unless_told_not_to) {
  const Workplace here;
  const std::string behind = "--size 8x8 --spp 2 --quiet --look-at 0.278,0.273,1.4:0.278,0.273,0 --fov 20 ";
  ASSERT_TRUE(succeeded(here.eikon(cornell(behind + "--aov depth"))));
  const Image through = read_exr(here / "out.exr");
  EXPECT_EQ(read_metadata(here / "out.exr").strings.at("cull"), "camera");
  ASSERT_TRUE(succeeded(here.eikon(cornell(behind + "--aov depth --cull none"))));
  const Image wall = read_exr(here / "out.exr");
  EXPECT_EQ(read_metadata(here / "out.exr").strings.at("cull"), "none");
  // The middle of the back wall is 0.84 m away, and what is nearest behind it 0.93 m.
  const auto nearest = [](const Image& image) {
    float least = INFINITY;
    for (const float depth : *image.plane("depth.Z"))
      if (depth > 0) least = std::min(least, depth);  // 0: nothing was hit
    return least;
  };
  EXPECT_LT(nearest(wall), 0.9F);
  EXPECT_GT(nearest(through), 0.9F);
  EXPECT_TRUE(refused(here.eikon(cornell("--size 8x8 --cull back")), kUsage));
  EXPECT_TRUE(contains(here.eikon("info " + scene("cornell.gltf")).out, "culling          in   material 'white'"));
  EXPECT_TRUE(contains(here.eikon("info --cull none " + scene("cornell.gltf")).out, "culling          out  --cull"));
}

TEST(Picture, filters_are_in_the_file_and_wrong_ones_are_refused) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 8x8 --spp 2 --quiet --filter gaussian:2.5"))));
  EXPECT_EQ(read_metadata(here / "out.exr").strings.at("filter"), "gaussian:2.5");
  std::filesystem::remove(here / "out.exr");
  for (const char* flags : {"--filter lanczos", "--filter box:0", "--filter box:wide", "--tonemap filmic",
                            "--env-scale -1", "--env-scale nan", "--env-rotate inf", "--env 1,2,3 --env-scale 1e9x"})
    EXPECT_TRUE(refused(here.eikon(cornell("--size 8x8 ") + flags), kUsage)) << flags;
  EXPECT_TRUE(refused(here.eikon(cornell("--size 8x8 --env 1e25,1,1 --env-scale 1e9")), kUsage));
  EXPECT_TRUE(refused(here.eikon(cornell("--size 8x8 --env missing.hdr")), kInput));
  EXPECT_TRUE(here.files().empty());
}

TEST(Picture, an_environment_s_scale_multiplies_what_is_given_and_what_the_file_has) {
  const Workplace here;
  const std::string away = "render " + scene("sphere_in_sky.gltf") +
                           " -o out.exr --size 5x5 --spp 2 --quiet --look-at 0,0,5:0,0,9 --env-scale 3 ";
  ASSERT_TRUE(succeeded(here.eikon(away + "--env 1,2,4")));
  EXPECT_EQ((*read_exr(here / "out.exr").plane("B"))[12], 12);
  EXPECT_EQ(read_metadata(here / "out.exr").strings.at("environment"), "3,6,12");
  ASSERT_TRUE(succeeded(here.eikon(away)));
  EXPECT_EQ((*read_exr(here / "out.exr").plane("B"))[12], 3);
}

TEST(Picture, an_orthographic_camera_has_no_field_of_view_and_says_where_its_film_lies) {
  const Workplace here;
  json gltf = read_json(scene("sphere_in_sky.gltf"));
  gltf["cameras"] = {{{"name", "plan"},
                      {"type", "orthographic"},
                      {"orthographic", {{"xmag", 4}, {"ymag", 2}, {"znear", 0.1}, {"zfar", 100}}}}};
  here.write("plan.gltf", gltf.dump());
  EXPECT_TRUE(refused(here.eikon("render plan.gltf -o out.exr --size 8x4 --fov 30"), kUsage));
  ASSERT_TRUE(succeeded(here.eikon("render plan.gltf -o out.exr --size 8x4 --spp 2 --quiet")));
  const Metadata metadata = read_metadata(here / "out.exr");
  EXPECT_TRUE(contains(metadata.strings.at("features"), "orthographic"));
  // A point 4 m to the right and 2 m up of the axis, at any depth, is the upper right corner.
  const std::vector<double>& to_camera = metadata.matrices.at("worldToCamera");
  const std::vector<double>& to_ndc = metadata.matrices.at("worldToNDC");
  for (std::size_t row = 0; row < 16; row += 4) {
    const double middle = row == 12 ? 0.5 : 0;
    EXPECT_NEAR(to_ndc[row], middle + to_camera[row] / 8, 1e-6);
    EXPECT_NEAR(to_ndc[row + 1], middle - to_camera[row + 1] / 4, 1e-6);
    EXPECT_EQ(to_ndc[row + 3], row == 12 ? 1 : 0);
  }
  ASSERT_TRUE(
      succeeded(here.eikon("render plan.gltf -o out.exr --size 8x4 --spp 2 --quiet --look-at 0,0,9:0,0,0 --fov 9")));
}

// ImfStandardAttributes.h: in the camera's space what is ahead has positive z; (0, 0) and (1, 1)
// are the upper left and the lower right corner of the picture.
TEST(Picture, its_matrices_are_those_of_openexr) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon("render " + scene("sphere_in_sky.gltf") +
                                   " -o out.exr --size 8x4 --spp 2 --quiet --look-at 1,2,5:1,2,4 --fov 90")));
  const Metadata metadata = read_metadata(here / "out.exr");
  const auto transformed = [&](const char* name, const std::array<double, 4>& point) {
    const std::vector<double>& matrix = metadata.matrices.at(name);
    std::array<double, 4> result{};
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = 0; k < 4; ++k) result[k] += point[i] * matrix[4 * i + k];
    return result;
  };
  // Three metres ahead of the camera: the picture is six metres high there and twelve wide.
  const std::array<double, 4> seen = transformed("worldToCamera", {1.5, 2.25, 2, 1});
  EXPECT_NEAR(seen[0], 0.5, 1e-6);
  EXPECT_NEAR(seen[1], 0.25, 1e-6);
  EXPECT_NEAR(seen[2], 3, 1e-6);
  const std::array<double, 4> corner = transformed("worldToNDC", {1 - 6, 2 + 3, 2, 1});
  EXPECT_NEAR(corner[0] / corner[3], 0, 1e-6);
  EXPECT_NEAR(corner[1] / corner[3], 0, 1e-6);
  const std::array<double, 4> other = transformed("worldToNDC", {1 + 6, 2 - 3, 2, 1});
  EXPECT_NEAR(other[0] / other[3], 1, 1e-6);
  EXPECT_NEAR(other[1] / other[3], 1, 1e-6);
}

TEST(Picture, a_panorama_is_twice_as_wide_as_high_and_has_no_film_to_place) {
  const Workplace here;
  const std::string around = "render " + scene("sphere_in_sky.gltf") + " -o out.exr --spp 1 --quiet --panorama";
  ASSERT_TRUE(succeeded(here.eikon(around + " --crop 0,0,9,9")));
  const Metadata metadata = read_metadata(here / "out.exr");
  EXPECT_EQ(metadata.strings.at("size"), "1440x720");
  EXPECT_EQ(metadata.matrices.count("worldToNDC"), 0U);
  EXPECT_EQ(metadata.matrices.count("worldToCamera"), 1U);
}

TEST(Picture, a_lens_by_flags_blurs_and_can_be_taken_off) {
  const Workplace here;
  const std::string ball = "render " + scene("sphere_in_sky.gltf") + " --size 32x32 --spp 16 --quiet";
  ASSERT_TRUE(succeeded(here.eikon(ball + " -o sharp.exr")));
  ASSERT_TRUE(succeeded(here.eikon(ball + " -o off.exr --f-number off")));
  ASSERT_TRUE(succeeded(here.eikon(ball + " -o blurred.exr --f-number 0.01 --focus-distance 0.5")));
  EXPECT_TRUE(succeeded(here.eikon("compare off.exr sharp.exr --fail-above 0")));
  EXPECT_EQ(here.eikon("compare blurred.exr sharp.exr --fail-above 0.01").code, 1);
}

// White at EV 15 is 1.2 * 2^15 cd/m2.
TEST(Picture, the_exposure_of_a_camera_takes_luminance_for_what_it_is) {
  const Workplace here;
  const std::string sky = "render " + scene("sphere_in_sky.gltf") +
                          " -o out.exr --png out.png --size 2x2 --spp 1 --quiet --look-at 0,0,5:0,0,9 --env ";
  const auto picture_of = [&](const std::string& rest) {
    EXPECT_TRUE(succeeded(here.eikon(sky + rest)));
    return read_bytes(here / "out.png");
  };
  EXPECT_EQ(picture_of("39321.6,19660.8,0 --ev100 15"), picture_of("1,0.5,0"));
  EXPECT_NE(picture_of("39321.6,19660.8,0 --ev100 14"), picture_of("1,0.5,0"));
}

}  // namespace
}  // namespace eikon::test
