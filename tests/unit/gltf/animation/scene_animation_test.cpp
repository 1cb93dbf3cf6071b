// SPDX-License-Identifier: Apache-2.0
// Animations of nodes: values between keys against double precision, and what time means.
#include <cmath>
#include <numbers>
#include <random>

#include "gltf/animation/sampler.h"
#include "scene/transform.h"
#include "support/animation_builder.h"
#include "support/paths.h"

namespace {

using eikon::Scene;
using scene_test::add_channel;
using scene_test::Builder;
using scene_test::Json;
using scene_test::kByte;
using scene_test::kFloat;
using scene_test::kShort;
using scene_test::load_at;
using scene_test::target_of;

constexpr double kDegree = std::numbers::pi / 180;

glm::dmat4 pose_of(const Scene& scene) { return scene.nodes.at(0).world_from_object; }

glm::dvec3 translation_at(const Builder& builder, double seconds) {
  return glm::dvec3(pose_of(load_at(builder, seconds))[3]);
}

/// The angle about +Z by which the first node is turned, in degrees from -180 to 180.
double angle_at(const Builder& builder, double seconds) {
  const glm::dmat4 pose = pose_of(load_at(builder, seconds));
  EXPECT_LT(std::abs(glm::length(glm::dvec3(pose[0])) - 1), 1e-12) << seconds;
  return std::atan2(pose[0].y, pose[0].x) / kDegree;
}

std::vector<float> turn(double degrees, float sign = 1) {
  return {0, 0, sign * static_cast<float>(std::sin(degrees * kDegree / 2)),
          sign * static_cast<float>(std::cos(degrees * kDegree / 2))};
}

std::vector<float> joined(const std::vector<std::vector<float>>& parts) {
  std::vector<float> all;
  for (const std::vector<float>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

TEST(SceneAnimation, linear_keys_are_interpolated_and_the_ends_held) {
  Builder builder;
  const std::vector<float> times{0.5F, 0.7F, 2}, values{1, 2, 3, 4, 0.1F, -7, 8, 8, 8};
  add_channel(builder, 0, target_of(0, "translation"), {.times = times, .values = values});
  for (const double seconds : {-5.0, 0.0, 0.5, 0.6, 0.69999, 0.7F + 0.0, 1.0, 1.999, 2.0, 100.0}) {
    std::size_t key = 0;
    double share = 0;
    const double first = times[0], second = times[1], third = times[2];
    if (seconds >= second) key = 1;
    if (key == 0) share = std::clamp((seconds - first) / (second - first), 0.0, 1.0);
    if (key == 1) share = std::clamp((seconds - second) / (third - second), 0.0, 1.0);
    for (std::size_t i = 0; i < 3; ++i) {
      const double from = values[3 * key + i], to = values[3 * key + 3 + i];
      EXPECT_NEAR(translation_at(builder, seconds)[static_cast<int>(i)], (1 - share) * from + share * to, 1e-14)
          << seconds << ", axis " << i;
    }
  }
}

TEST(SceneAnimation, steps_hold_the_key_before) {
  Builder builder;
  add_channel(builder, 0, target_of(0, "translation"),
              {.times = {0, 1, 2}, .values = {1, 0, 0, 2, 0, 0, 3, 0, 0}, .interpolation = "STEP"});
  const std::pair<double, double> rows[] = {{-1, 1}, {0, 1}, {0.999, 1}, {1, 2}, {1.999, 2}, {2, 3}, {9, 3}};
  for (const auto& [seconds, x] : rows) EXPECT_EQ(translation_at(builder, seconds).x, x) << seconds;
}

TEST(SceneAnimation, cubic_splines_follow_their_tangents_per_second) {
  Builder builder;
  // Two keys, 2 s apart: tangent in, value, tangent out of each.
  add_channel(builder, 0, target_of(0, "translation"),
              {.times = {1, 3},
               .values = {9, 9, 9, 1, 2, 3, 0.5F, 0, -1, 2, 0, 0.25F, 5, 2, 7, 9, 9, 9},
               .interpolation = "CUBICSPLINE"});
  const double v0[] = {1, 2, 3}, b0[] = {0.5, 0, -1}, a1[] = {2, 0, 0.25}, v1[] = {5, 2, 7};
  for (const double seconds : {0.0, 1.0, 1.3, 2.0, 2.9, 3.0, 4.0}) {
    const double t = std::clamp((seconds - 1) / 2, 0.0, 1.0);
    for (int i = 0; i < 3; ++i) {
      // The cubic c3 t^3 + c2 t^2 + c1 t + v0 with these values and slopes at its ends.
      const double c1 = 2 * b0[i], c3 = 2 * (v0[i] - v1[i]) + 2 * b0[i] + 2 * a1[i], c2 = v1[i] - v0[i] - c1 - c3;
      EXPECT_NEAR(translation_at(builder, seconds)[i], ((c3 * t + c2) * t + c1) * t + v0[i], 1e-13) << seconds;
    }
  }
  EXPECT_EQ(translation_at(builder, 2.2).y, 2.0) << "equal values without slopes are exact";
}

TEST(SceneAnimation, rotations_turn_at_constant_speed_by_the_shorter_way) {
  struct Row {
    double from, to;
    float sign;  // of the second quaternion, which is the same rotation for both
    double middle, third;
  };
  for (const Row& row : {Row{0, 90, 1, 45, 30}, Row{0, 90, -1, 45, 30}, Row{20, 350, 1, 5, 10}, Row{20, 350, -1, 5, 10},
                         Row{0, 179.9, 1, 89.95, 59.966667}, Row{0, 180.1, 1, -89.95, -59.966667},
                         Row{0, 180.1, -1, -89.95, -59.966667}, Row{-100, 79.999, 1, -10.0005, -40.000333},
                         Row{10, 10, -1, 10, 10}, Row{10, 10.0001, 1, 10.00005, 10.0000333}}) {
    Builder builder;
    add_channel(builder, 0, target_of(0, "rotation"),
                {.times = {0, 3}, .values = joined({turn(row.from), turn(row.to, row.sign)}), .type = "VEC4"});
    EXPECT_NEAR(angle_at(builder, 1.5), row.middle, 2e-5) << row.from << " to " << row.to << ", sign " << row.sign;
    EXPECT_NEAR(angle_at(builder, 1), row.third, 2e-5) << row.from << " to " << row.to << ", sign " << row.sign;
  }
}

TEST(SceneAnimation, slerp_is_that_of_sines_to_all_but_the_last_digits) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<double> a(4), b(4);
    double aa = 0, bb = 0, dot = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      a[k] = normal(random);
      b[k] = i % 3 == 0 ? a[k] + 1e-3 * normal(random) : normal(random);
      aa += a[k] * a[k];
      bb += b[k] * b[k];
    }
    for (std::size_t k = 0; k < 4; ++k) dot += (a[k] /= std::sqrt(aa)) * (b[k] /= std::sqrt(bb));
    const long double sign = dot < 0 ? -1 : 1,
                      angle = std::acos(std::min(1.0L, std::abs(static_cast<long double>(dot))));
    const double t = uniform(random);
    const std::vector<double> found = eikon::slerp(a, b, t);
    for (std::size_t k = 0; k < 4; ++k) {
      const long double want = (std::sin((1 - t) * angle) * a[k] + sign * std::sin(t * angle) * b[k]) / std::sin(angle);
      worst = std::max(worst, static_cast<double>(std::abs(want - found[k])));
    }
  }
  EXPECT_LT(worst, 1e-13);
  const std::vector<double> from{0, 0, 0, 1}, to{0, 0, 1, 0};
  EXPECT_EQ(eikon::slerp(from, to, 0), from);
  EXPECT_EQ(eikon::slerp(from, to, 1), to);
  EXPECT_EQ(eikon::slerp(from, from, 0.3), from);
}

TEST(SceneAnimation, exact_half_turns_go_one_way_at_constant_speed) {
  Builder builder;
  add_channel(builder, 0, target_of(0, "rotation"),
              {.times = {0, 1}, .values = {0, 0, 0, 1, 0, 0, 1, 0}, .type = "VEC4"});
  for (const double t : {0.0, 0.125, 0.5, 0.75, 1.0}) EXPECT_NEAR(std::abs(angle_at(builder, t)), 180 * t, 1e-12) << t;
}

TEST(SceneAnimation, rotations_of_any_length_and_by_splines_come_out_of_length_1) {
  Builder builder;
  std::vector<float> values;
  for (const std::vector<float>& part :
       {std::vector<float>{0, 0, 0, 0}, turn(0), {0, 0, 1, 0}, {0, 0, 0.5F, 0}, turn(90, 3), {0, 0, 0, 0}})
    values.insert(values.end(), part.begin(), part.end());
  add_channel(builder, 0, target_of(0, "rotation"),
              {.times = {0, 1}, .values = values, .type = "VEC4", .interpolation = "CUBICSPLINE"});
  // At t = 1/2 values count half each, tangents an eighth with opposite signs.
  const double s = 3 * std::sin(45 * kDegree), c = 3 * std::cos(45 * kDegree);
  const double z = 0.5 * s + 0.125 * (1 - 0.5), w = 0.5 * (1 + c);
  EXPECT_NEAR(angle_at(builder, 0.5), 2 * std::atan2(z, w) / kDegree, 1e-5);
  EXPECT_NEAR(angle_at(builder, 1), 90, 1e-5);
}

TEST(SceneAnimation, integers_are_normalised) {
  Builder builder;
  const std::size_t times = builder.add("SCALAR", kFloat, std::vector<float>{0, 1}, 2);
  const std::size_t shorts =
      builder.add("VEC4", kShort, std::vector<std::int16_t>{0, 0, 0, 32767, 0, 0, 32767, 32767}, 2);
  builder.json["accessors"][shorts]["normalized"] = true;
  add_channel(builder, 0, target_of(0, "rotation"), times, shorts);
  EXPECT_NEAR(angle_at(builder, 1), 90, 1e-12);
  EXPECT_NEAR(angle_at(builder, 0.5), 45, 1e-12);
  const std::size_t bytes = builder.add("VEC4", kByte, std::vector<std::int8_t>{-128, 0, 0, 0, 0, 0, -127, 127}, 2);
  builder.json["accessors"][bytes]["normalized"] = true;
  builder.json["animations"][0]["samplers"][0]["output"] = bytes;
  EXPECT_NEAR(angle_at(builder, 1), -90, 1e-12);
}

TEST(SceneAnimation, scales_of_zero_and_below_are_kept) {
  Builder builder;
  add_channel(builder, 0, target_of(0, "scale"), {.times = {0, 2}, .values = {1, 1, 1, -1, 1, 1}});
  const Scene half = load_at(builder, 1), end = load_at(builder, 2), begin = load_at(builder, 0);
  EXPECT_EQ(glm::dvec3(pose_of(half)[0]), glm::dvec3(0));
  EXPECT_EQ(pose_of(load_at(builder, 0.5))[0].x, 0.5);
  EXPECT_TRUE(end.nodes.at(0).mirrored);
  EXPECT_FALSE(begin.nodes.at(0).mirrored || half.nodes.at(0).mirrored);
}

TEST(SceneAnimation, weights_morph_by_vectors_of_scalars) {
  for (const char* interpolation : {"LINEAR", "CUBICSPLINE"}) {
    Builder builder;
    const std::size_t up = builder.add("VEC3", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, 3),
                      aside = builder.add("VEC3", kFloat, std::vector<float>{1, 0, 0, 1, 0, 0, 1, 0, 0}, 3);
    builder.primitive()["targets"] = {{{"POSITION", up}}, {{"POSITION", aside}}};
    const bool cubic = std::string(interpolation) == "CUBICSPLINE";
    const std::vector<float> values =
        cubic ? std::vector<float>{0, 0, 1, 0, 0, 0, 0, 0, 0, 4, 0, 0} : std::vector<float>{1, 0, 0, 4};
    add_channel(builder, 0, target_of(0, "weights"),
                {.times = {0, 1}, .values = values, .type = "SCALAR", .interpolation = interpolation});
    const auto corner = [&](double t) { return load_at(builder, t).meshes.at(0).primitives.at(0).positions_object[0]; };
    EXPECT_EQ(corner(0), glm::vec3(0, 0, 1)) << interpolation;
    EXPECT_EQ(corner(1), glm::vec3(4, 0, 0)) << interpolation;
    EXPECT_EQ(corner(0.5), glm::vec3(2, 0, 0.5F)) << interpolation;
  }
}

TEST(SceneAnimation, a_pose_is_the_file_that_says_it) {
  Builder moving, still;
  add_channel(moving, 0, target_of(0, "translation"), {.times = {0, 1}, .values = {0, 0, 0, 1, 2, 4}});
  add_channel(moving, 0, target_of(0, "scale"), {.times = {0, 1}, .values = {1, 1, 1, 3, 1, 1}});
  still.node()["translation"] = {0.25, 0.5, 1.0};
  still.node()["scale"] = {1.5, 1.0, 1.0};
  EXPECT_EQ(pose_of(load_at(moving, 0.25)), pose_of(still.load()));
}

TEST(SceneAnimation, cameras_and_lights_move_with_their_nodes) {
  Builder builder;
  builder.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.01}}}}};
  builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}}};
  builder.json["nodes"].push_back({{"children", {2}}});
  builder.json["nodes"].push_back({{"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  builder.json["scenes"][0]["nodes"].push_back(1);
  const float half = std::sqrt(0.5F);
  add_channel(builder, 0, target_of(1, "translation"), {.times = {0, 1}, .values = {0, 0, 0, 8, 0, 0}});
  add_channel(builder, 0, target_of(2, "rotation"),
              {.times = {0, 1}, .values = {0, 0, 0, 1, 0, half, 0, half}, .type = "VEC4"});
  const Scene scene = load_at(builder, 1);
  const glm::dmat4 camera = scene.cameras.at(0).world_from_camera;
  EXPECT_LT(glm::length(glm::dvec3(camera[3]) - glm::dvec3(8, 0, 0)), 1e-12);
  EXPECT_LT(glm::length(glm::dvec3(camera[2]) - glm::dvec3(1, 0, 0)), 1e-12) << "it looks along -X";
  EXPECT_LT(glm::length(scene.lights.at(0).position - glm::dvec3(8, 0, 0)), 1e-12);
  EXPECT_LT(glm::length(scene.lights.at(0).direction - glm::dvec3(-1, 0, 0)), 1e-12);
}

TEST(SceneAnimation, the_shipped_camera_path_is_a_circle_around_what_it_looks_at) {
  const std::string path = std::string(EIKON_SOURCE_DIR) + "/scenes/camera_path.gltf";
  for (double time_s = 0; time_s <= 4; time_s += 0.15) {
    const Scene scene = eikon::load_scene(path, {.variant = {}, .animation = {.animation = {}, .time_s = time_s, .loop = false}});
    const eikon::Camera& camera = scene.cameras.at(0);
    const double angle = 2 * 3.14159265358979323846 * time_s / 4;
    const glm::dvec3 place(camera.world_from_camera[3]), ahead = -glm::dvec3(camera.world_from_camera[2]);
    const glm::dvec3 exact(4 * std::sin(angle), 1.6, 4 * std::cos(angle));
    EXPECT_LT(glm::length(place - exact), 5e-3) << time_s << ": between keys, cubic polynomials are nearly circles";
    EXPECT_LT(glm::length(ahead - glm::normalize(glm::dvec3(0, 0.6, 0) - exact)), 1e-5) << time_s;
    EXPECT_NEAR(camera.yfov_rad, 0.6 - 0.25 * (1 - std::abs(time_s - 2) / 2), 1e-6) << time_s;
  }
}

}  // namespace
