// SPDX-License-Identifier: Apache-2.0
// Layer `motion` against closed forms.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "cli/batch/batch_outcome.h"
#include "image/image.h"
#include "support/animation_builder.h"

namespace eikon::test {
namespace {

using scene_test::add_channel;
using scene_test::Builder;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::kUnsignedByte;
using scene_test::target_of;

constexpr int kWidth = 24, kHeight = 16;
constexpr double kFrame_s = 1.0 / 24;

/// A triangle that fills the picture, 2 m in front of a camera whose picture is as high as its
/// distance.
Builder wall() {
  Builder builder;
  builder.node() = {{"name", "wall"}, {"mesh", 0}, {"scale", {40, 40, 1}}, {"translation", {-10, -10, -2}}};
  builder.json["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 2 * std::atan(0.5)}, {"aspectRatio", 1.5}, {"znear", 0.1}}}}};
  builder.json["nodes"].push_back({{"name", "camera"}, {"camera", 0}});
  builder.json["scenes"][0]["nodes"].push_back(1);
  return builder;
}

Image rendered(const Workplace& here, const Builder& builder, const std::string& flags = {}, int spp = 16) {
  here.write("scene.gltf", builder.text());
  EXPECT_TRUE(succeeded(here.eikon(fmt::format("render scene.gltf -o a.exr --size {}x{} --spp {} --quiet --aov motion "
                                               "--env 1,1,1 {}",
                                               kWidth, kHeight, spp, flags))));
  return read_exr(here / "a.exr");
}

/// expected(x, y)  of a place on the film, from the middle of the picture, y up
template <class Expected>
void expect_motion(const Image& image, double tolerance, const Expected& expected) {
  const std::vector<float>*x_plane = image.plane("motion.X"), *y_plane = image.plane("motion.Y");
  ASSERT_TRUE(x_plane != nullptr && y_plane != nullptr);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const auto [dx, dy] = expected(x + 0.5 - kWidth / 2.0, kHeight / 2.0 - y - 0.5);
      const std::size_t at = std::size_t(y) * kWidth + std::size_t(x);
      EXPECT_NEAR(double((*x_plane)[at]), dx, tolerance) << x << " " << y;
      EXPECT_NEAR(double((*y_plane)[at]), dy, tolerance) << x << " " << y;
    }
}

TEST(MotionLayer, a_wall_that_slides_has_its_pixels_per_frame_to_the_right_and_up) {
  const Workplace here;
  Builder builder = wall();
  add_channel(builder, 0, target_of(0, "translation"), {.times = {0, 1}, .values = {-10, -10, -2, -7.6F, -8.8F, -2}});
  // 0.1 m and 0.05 m in a frame, and 8 pixels to a metre.
  const auto way = [](double, double) { return std::pair(0.8, 0.4); };
  for (const char* flags : {"--frame 3", "--frame 3 --shutter 0.5", "--frame 3 --shutter 1 --shutter-at centre",
                            "--frame 3 --layout bvh2 --threads 1"})
    expect_motion(rendered(here, builder, flags), 2e-4, way);
  expect_motion(rendered(here, builder, "--frame 3 --fps 48"), 2e-4, [](double, double) { return std::pair(0.4, 0.2); });
}

TEST(MotionLayer, a_wall_that_comes_nearer_grows_from_the_middle) {
  const Workplace here;
  Builder builder = wall();
  add_channel(builder, 0, target_of(0, "translation"), {.times = {0, 1}, .values = {-10, -10, -2, -10, -10, 0.4F}});
  const double grows = 2 / (2 - 2.4 * kFrame_s) - 1;
  expect_motion(rendered(here, builder, "--frame 0 --filter box:0.01"), 2e-2,
                [&](double x, double y) { return std::pair(x * grows, y * grows); });
}

TEST(MotionLayer, a_camera_that_turns_moves_walls_and_the_sky_alike) {
  const Workplace here;
  Builder builder = wall();
  builder.node()["translation"] = {0, -10, -2};  // the left half shows the sky
  const double turn = 0.05 / kFrame_s;           // rad in a second, to the left
  add_channel(builder, 0, target_of(1, "rotation"),
              {.times = {0, 1},
               .values = {0, 0, 0, 1, 0, float(std::sin(turn / 2)), 0, float(std::cos(turn / 2))},
               .type = "VEC4"});
  const double focal = kHeight;  // pixels
  expect_motion(rendered(here, builder, "--frame 0", 256), 2e-2, [&](double x, double y) {
    const double before = std::atan(x / focal), after = before + 0.05;
    return std::pair(focal * std::tan(after) - x, y * (std::cos(before) / std::cos(after) - 1));
  });
}

TEST(MotionLayer, a_parallel_camera_that_rises_sees_everything_sink) {
  const Workplace here;
  Builder builder = wall();
  builder.json["cameras"] = {
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 1.5}, {"ymag", 1}, {"znear", 0.1}, {"zfar", 9}}}}};
  add_channel(builder, 0, target_of(1, "translation"), {.times = {0, 1}, .values = {0, 0, 0, 0, 2.4F, 0}});
  expect_motion(rendered(here, builder, "--frame 0"), 2e-4, [](double, double) { return std::pair(0.0, -0.8); });
}

/// A wall whose corners follow joints, which are nodes 2 and 3. It stands in front of the camera as
/// long as they are at rest.
/// weights  of the second joint at the three corners, which are at (-3, -3), (7, -3) and (-3, 7) of
///          the wall's plane
Builder skinned_wall(const std::array<float, 3>& weights) {
  Builder builder = wall();
  std::vector<float> shares, binds;
  for (const float weight : weights) shares.insert(shares.end(), {1 - weight, weight, 0, 0});
  for (int joint = 0; joint < 2; ++joint) {
    builder.json["nodes"].push_back({{"name", "joint"}, {"translation", {0, 0, -2}}});
    builder.json["scenes"][0]["nodes"].push_back(2 + joint);
    binds.insert(binds.end(), {10, 0, 0, 0, 0, 10, 0, 0, 0, 0, 1, 0, -3, -3, 0, 1});
  }
  builder.json["skins"] = {{{"joints", {2, 3}}, {"inverseBindMatrices", builder.add("MAT4", kFloat, binds, 2)}}};
  builder.node()["skin"] = 0;
  Json& attributes = builder.primitive()["attributes"];
  attributes["JOINTS_0"] =
      builder.add("VEC4", kUnsignedByte, std::vector<std::uint8_t>{0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, 3);
  attributes["WEIGHTS_0"] = builder.add("VEC4", kFloat, shares, 3);
  return builder;
}

/// What has these values at the corners of the skinned wall, where a pixel shows it.
double on_wall(const std::array<float, 3>& corners, double x, double y) {
  const double right = (x / 8 + 3) / 10, up = (y / 8 + 3) / 10;
  return corners[0] + (corners[1] - corners[0]) * right + (corners[2] - corners[0]) * up;
}

TEST(MotionLayer, corners_of_a_skin_go_as_far_as_their_weights_say) {
  const Workplace here;
  const std::array<float, 3> weights{0.125F, 1, 0.5F};
  Builder builder = skinned_wall(weights);
  add_channel(builder, 0, target_of(3, "translation"), {.times = {0, 1}, .values = {0, 0, -2, 2.4F, -1.2F, -2}});
  const auto way = [&](double x, double y) {
    const double weight = on_wall(weights, x, y);
    return std::pair(0.8 * weight, -0.4 * weight);
  };
  for (const char* flags : {"--frame 0", "--frame 0 --layout bvh2 --threads 1", "--frame 0 --shutter 0.05"})
    expect_motion(rendered(here, builder, flags, 64), 4e-3, way);
}

TEST(MotionLayer, a_skin_whose_joints_turn_moves_in_circles) {
  const Workplace here;
  Builder builder = skinned_wall({0.5F, 0, 1});
  const double angle = 0.05, half_s = angle / kFrame_s / 2;
  for (const std::size_t joint : {2, 3})
    add_channel(builder, 0, target_of(joint, "rotation"),
                {.times = {0, 1}, .values = {0, 0, 0, 1, 0, 0, float(std::sin(half_s)), float(std::cos(half_s))}, .type = "VEC4"});
  for (const char* frame : {"--frame 0", "--frame 7"})
    expect_motion(rendered(here, builder, frame, 64), 2e-2, [&](double x, double y) {
      return std::pair(x * std::cos(angle) - y * std::sin(angle) - x, x * std::sin(angle) + y * std::cos(angle) - y);
    });
}

TEST(MotionLayer, morph_targets_move_corners_by_what_their_weights_gain) {
  const Workplace here;
  Builder builder = skinned_wall({0, 0, 0});  // its second joint moves nothing
  // In metres of the wall, which the bind matrix makes ten times as large, but along z.
  const std::array<float, 3> right{0.24F, -0.12F, 0.48F};
  const float nearer = 1.2F;
  builder.primitive()["targets"] = {
      {{"POSITION",
        builder.add("VEC3", kFloat, std::vector<float>{right[0], 0, 0, right[1], 0, 0, right[2], 0, 0}, 3)}},
      {{"POSITION", builder.add("VEC3", kFloat, std::vector<float>{0, 0, nearer, 0, 0, nearer, 0, 0, nearer}, 3)}}};
  builder.json["meshes"][0]["weights"] = {0, 0};
  add_channel(builder, 0, target_of(0, "weights"), {.times = {0, 1}, .values = {0, 0, 1, 1}, .type = "SCALAR"});
  const double grows = 2 / (2 - double(nearer) * kFrame_s);
  expect_motion(rendered(here, builder, "--frame 0", 256), 1e-2, [&](double x, double y) {
    return std::pair((x + 8 * 10 * on_wall(right, x, y) * kFrame_s) * grows - x, y * grows - y);
  });
}

TEST(MotionLayer, is_0_to_the_bit_where_nothing_moves) {
  const Workplace here;
  Builder builder = wall();
  expect_motion(rendered(here, builder), 0, [](double, double) { return std::pair(0.0, 0.0); });
  add_channel(builder, 0, target_of(0, "translation"), {.times = {0, 1}, .values = {-10, -10, -2, -7.6F, -8.8F, -2}});
  expect_motion(rendered(here, builder, "--frame 30"), 0, [](double, double) { return std::pair(0.0, 0.0); });
}

TEST(MotionLayer, parts_merge_and_a_panorama_is_refused) {
  const Workplace here;
  const std::string wheel = fmt::format("render {} --size 24x16 --frame 6 --quiet --aov motion ", scene("spinning_wheel.gltf"));
  EXPECT_TRUE(succeeded(here.eikon(wheel + "--spp 4 -o whole.exr")));
  EXPECT_TRUE(succeeded(here.eikon(wheel + "--spp 4 --samples 0:1 -o a.exr")));
  EXPECT_TRUE(succeeded(here.eikon(wheel + "--spp 4 --samples 1:4 --layout bvh4 -o b.exr")));
  EXPECT_TRUE(succeeded(here.eikon("merge a.exr b.exr -o merged.exr")));
  EXPECT_TRUE(same_picture(here / "whole.exr", here / "merged.exr"));
  const Outcome panorama = here.eikon(wheel + "--spp 4 --panorama -o p.exr");
  EXPECT_EQ(panorama.code, 2);
  EXPECT_TRUE(contains(panorama.err, "--aov motion: "));
}

}  // namespace
}  // namespace eikon::test
