// SPDX-License-Identifier: Apache-2.0
// The animations that count and when, what identifies a pose, and animations that are damaged.
#include <functional>
#include <limits>

#include "support/animation_builder.h"

namespace {

using eikon::AnimationChoice;
using eikon::Scene;
using scene_test::add_channel;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::load_at;
using scene_test::message_of;
using scene_test::target_of;
using scene_test::warns;

/// Two nodes with the triangle. 'slide' moves the first to x = 10 within 4 s, 'rise' the second to
/// y = 10 within 2 s, and 'jump' the first to z = 10 within 1 s.
Builder three_animations() {
  Builder builder;
  builder.json["nodes"].push_back({{"mesh", 0}});
  builder.json["scenes"][0]["nodes"].push_back(1);
  add_channel(builder, 0, target_of(0, "translation"), {.times = {0, 4}, .values = {0, 0, 0, 10, 0, 0}})["name"] =
      "slide";
  add_channel(builder, 1, target_of(1, "translation"), {.times = {0, 2}, .values = {0, 0, 0, 0, 10, 0}})["name"] =
      "rise";
  add_channel(builder, 2, target_of(0, "translation"), {.times = {0, 1}, .values = {0, 0, 0, 0, 0, 10}})["name"] =
      "jump";
  return builder;
}

glm::dvec3 place(const Scene& scene, std::size_t node) { return glm::dvec3(scene.nodes.at(node).world_from_object[3]); }

AnimationChoice called(const std::string& name, double seconds, bool loop = false) {
  return {.animation = name, .time_s = seconds, .loop = loop};
}

TEST(AnimationChoice, all_that_do_not_contradict_each_other_count) {
  const Builder builder = three_animations();
  for (const char* all : {"", "all"}) {
    const Scene scene = load_at(builder, called(all, 1));
    EXPECT_EQ(place(scene, 0), glm::dvec3(2.5, 0, 0));
    EXPECT_EQ(place(scene, 1), glm::dvec3(0, 5, 0));
    ASSERT_EQ(scene.warnings.size(), 1U);
    EXPECT_TRUE(
        warns(scene, "animation 'jump': left out, as animation 'slide' moves the same; choose one with --animation"));
    EXPECT_TRUE(scene.out_of_range.empty()) << "nothing is wrong with the file";
    ASSERT_EQ(scene.animations.size(), 3U);
    EXPECT_TRUE(scene.animations[0].in_force && scene.animations[1].in_force && !scene.animations[2].in_force);
    EXPECT_EQ(scene.animations[0].end_s, 4);
    EXPECT_EQ(scene.animations[1].channel_count, 1U);
  }
}

TEST(AnimationChoice, one_is_chosen_by_name_or_index) {
  const Builder builder = three_animations();
  for (const char* name : {"jump", "2"}) {
    const Scene scene = load_at(builder, called(name, 0.5));
    EXPECT_EQ(place(scene, 0), glm::dvec3(0, 0, 5)) << name;
    EXPECT_EQ(place(scene, 1), glm::dvec3(0)) << name;
    EXPECT_TRUE(scene.warnings.empty());
  }
  const std::string message = message_of([&] { load_at(builder, called("dance", 0)); });
  EXPECT_TRUE(contains(message, "no animation 'dance'; choose one of 'slide', 'rise', 'jump'")) << message;
  EXPECT_TRUE(contains(message_of([&] { load_at(builder, called("3", 0)); }), "no animation '3'"));
  EXPECT_TRUE(contains(message_of([&] { load_at(Builder(), called("walk", 0)); }), "leave --animation out"));
}

TEST(AnimationChoice, none_is_the_rest_pose) {
  Builder builder = three_animations();
  builder.node(0)["translation"] = {0, 0, 7};
  const Scene rest = load_at(builder, called("none", 3));
  EXPECT_EQ(place(rest, 0), glm::dvec3(0, 0, 7));
  EXPECT_TRUE(rest.warnings.empty());
  EXPECT_EQ(place(builder.load(), 0), glm::dvec3(0)) << "without a choice a file stands at the time 0";
}

TEST(AnimationChoice, loops_begin_again_each_on_its_own) {
  const Builder builder = three_animations();
  const Scene scene = load_at(builder, called("", 5, true));
  EXPECT_EQ(place(scene, 0), glm::dvec3(2.5, 0, 0));
  EXPECT_EQ(place(scene, 1), glm::dvec3(0, 5, 0));
  EXPECT_EQ(place(load_at(builder, called("", 4, true)), 0), glm::dvec3(0)) << "the end is the beginning";
  EXPECT_EQ(place(load_at(builder, called("", -1, true)), 0), glm::dvec3(7.5, 0, 0));
  EXPECT_EQ(place(load_at(builder, called("", 4, false)), 0), glm::dvec3(10, 0, 0));
}

TEST(AnimationChoice, poses_are_told_apart_by_the_hash_of_the_scene) {
  const Builder builder = three_animations();
  const auto hash = [&](const AnimationChoice& choice) { return load_at(builder, choice).hash; };
  EXPECT_EQ(hash(called("", 1)), hash(called("all", 1)));
  EXPECT_NE(hash(called("", 1)), hash(called("", 1.0000001)));
  EXPECT_NE(hash(called("", 1)), hash(called("slide", 1)));
  EXPECT_NE(hash(called("", 0)), hash(called("none", 0)));
  EXPECT_EQ(hash(called("none", 0)), hash(called("none", 5)));
  EXPECT_EQ(hash(called("", 9)), hash(called("", 99))) << "both are after the end, and the same pose";
  EXPECT_EQ(load_at(Builder(), 0).hash, load_at(Builder(), 3).hash);
  Builder unanimated = three_animations();
  const std::string moved = unanimated.load().hash;
  EXPECT_NE(moved, hash(called("none", 0)));
}

TEST(AnimationChoice, a_time_for_a_file_that_stands_still_is_said) {
  EXPECT_TRUE(warns(load_at(Builder(), 1), "it is the same at any time"));
  EXPECT_TRUE(load_at(Builder(), 0).warnings.empty());
}

TEST(AnimationChoice, a_damaged_animation_leaves_the_scene_as_it_is_unless_it_is_asked_for) {
  struct Row {
    std::function<void(Builder&)> damage;
    const char* says;
  };
  const auto times = [](std::vector<float> values) {
    return [values](Builder& b) {
      b.json["animations"][0]["samplers"][0]["input"] = b.add("SCALAR", kFloat, values, values.size());
    };
  };
  const auto values = [](std::vector<float> numbers) {
    return [numbers](Builder& b) {
      b.json["animations"][0]["samplers"][0]["output"] = b.add("VEC3", kFloat, numbers, numbers.size() / 3);
    };
  };
  const auto set = [](const char* pointer, const Json& value) {
    return [pointer, value](Builder& b) { b.json["animations"][0][Json::json_pointer(pointer)] = value; };
  };
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
  const std::vector<Row> rows{
      {times({1, 0}), "fall from 1 to 0 s at element 1"},
      {times({0, nan}), "element 1, are not finite"},
      {times({0, infinite}), "are not finite"},
      {times({}), "are none"},
      {times({0, 1, 2}), "are 2, its 3 keys need 3"},
      {times({0}), "are 2, its 1 keys need 1"},
      {values({0, 0, 0, 1, nan, 1}), "element 1, are not finite"},
      {values({0, 0, 0}), "are 1, its 2 keys need 2"},
      {set("/samplers/0/input", 1), "are not SCALAR of float"},
      {set("/samplers/0/output", 1), "are of a type that '/nodes/0/translation' does not have"},
      {set("/samplers/0/interpolation", "CUBICSPLINE"), "are 2, its 2 keys need 6"},
      {set("/samplers/0/interpolation", "BEZIER"), "'BEZIER' is none of STEP, LINEAR, CUBICSPLINE"},
      {set("/samplers/0/interpolation", 4), "interpolation"},
      {set("/samplers/0", Json::object()), "'input' or 'output' is missing"},
      {set("/samplers/0/output", 77), "animation 0"},
      {set("/channels/0/sampler", 5), "animation 0"},
      {set("/channels/0", {{"sampler", 0}}), "'target' is missing"},
      {set("/channels/0", {{"target", {{"node", 0}, {"path", "scale"}}}}), "'sampler' is missing"},
      {set("/channels/0/target/path", 3), "path"},
      {set("/channels/0/target", {{"node", 0}}), "'path' is missing"},
      {set("/channels/0/target/node", 9), "animation 0"},
      {set("/channels/0/target", {{"node", 0}, {"path", "pointer"}}), "KHR_animation_pointer is missing"},
      {set("/channels/0/target", {{"node", 0}, {"path", "weights"}}), "animation 0"},
      {set("/channels", 7), "animation 0"}};
  for (const Row& row : rows) {
    Builder builder;
    builder.json["animations"] = Json::array();
    add_channel(builder, 0, target_of(0, "translation"), {.times = {0, 1}, .values = {5, 0, 0, 9, 0, 0}});
    EXPECT_EQ(place(builder.load(), 0).x, 5);
    row.damage(builder);
    const Scene scene = builder.load();
    EXPECT_EQ(place(scene, 0).x, 0) << row.says;
    ASSERT_EQ(scene.out_of_range.size(), 1U) << row.says;
    EXPECT_TRUE(contains(scene.out_of_range[0], "left out: animation 0") && contains(scene.out_of_range[0], row.says))
        << row.says << ": " << scene.out_of_range[0];
    const std::string message = message_of([&] { load_at(builder, called("0", 0)); });
    EXPECT_TRUE(contains(message, row.says));
    EXPECT_EQ(place(load_at(builder, called("none", 0)), 0).x, 0);
  }
}

TEST(AnimationChoice, a_rotation_of_zero_is_damage_but_a_tangent_of_zero_is_not) {
  Builder builder;
  add_channel(builder, 0, target_of(0, "rotation"),
              {.times = {0, 1}, .values = {0, 0, 0, 1, 0, 0, 0, 0}, .type = "VEC4"});
  EXPECT_TRUE(contains(message_of([&] { load_at(builder, called("0", 0)); }), "(0, 0, 0, 0) in accessor"));
}

TEST(AnimationChoice, channels_that_eikon_does_not_read_leave_the_others_in_force) {
  Builder builder;
  add_channel(builder, 0, target_of(0, "translation"), {.times = {0, 1}, .values = {5, 0, 0, 9, 0, 0}});
  add_channel(builder, 0, target_of(0, "colour"), {.times = {0, 1}, .values = {5, 0, 0, 9, 0, 0}});
  add_channel(builder, 0, {{"path", "scale"}}, {.times = {0, 1}, .values = {5, 0, 0, 9, 0, 0}});
  add_channel(builder, 0, target_of(0, "translation"), {.times = {0, 1}, .values = {7, 0, 0, 7, 0, 0}});
  const Scene scene = load_at(builder, 1);
  EXPECT_EQ(place(scene, 0), glm::dvec3(9, 0, 0));
  EXPECT_TRUE(scene_test::leaves_out(scene, "animation of 'colour'", "animation 0"));
  EXPECT_EQ(scene.unsupported.size(), 1U) << "a channel without a node is for applications";
  ASSERT_EQ(scene.out_of_range.size(), 1U);
  EXPECT_TRUE(contains(scene.out_of_range[0], "animation 0, channel 3: left out, another channel moves the same"));
}

TEST(AnimationChoice, nothing_is_said_of_animations_that_are_not_asked_for) {
  Builder builder = three_animations();
  add_channel(builder, 1, target_of(0, "colour"), {.times = {0, 1}, .values = {5, 0, 0, 9, 0, 0}});
  builder.json["animations"][2]["samplers"][0]["input"] = 1;
  for (const char* name : {"slide", "none"}) {
    const Scene scene = load_at(builder, called(name, 1));
    EXPECT_TRUE(scene.unsupported.empty() && scene.warnings.empty()) << name;
    EXPECT_EQ(scene.animations.at(1).channel_count, 1U);
    EXPECT_EQ(scene.animations.at(2).channel_count, 0U) << "it is damaged";
  }
  const Scene all = load_at(builder, 1);
  EXPECT_EQ(all.unsupported.size(), 1U);
  EXPECT_EQ(all.out_of_range.size(), 1U);
}

TEST(AnimationChoice, equal_and_negative_times_are_said_and_keep_their_meaning) {
  Builder builder;
  add_channel(builder, 0, target_of(0, "translation"),
              {.times = {-1, 0, 0, 1}, .values = {0, 0, 0, 1, 0, 0, 5, 0, 0, 6, 0, 0}});
  const Scene scene = load_at(builder, 0);
  EXPECT_EQ(place(scene, 0).x, 5) << "the last of the keys at a time counts from there on";
  EXPECT_EQ(place(load_at(builder, -0.5), 0).x, 0.5);
  ASSERT_EQ(scene.out_of_range.size(), 1U);
  EXPECT_TRUE(contains(scene.out_of_range[0], "are negative or equal"));
}

TEST(AnimationChoice, a_node_with_a_matrix_stays_where_it_is) {
  Builder builder;
  builder.node()["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1};
  add_channel(builder, 0, target_of(0, "translation"), {.times = {0, 1}, .values = {5, 0, 0, 9, 0, 0}});
  const Scene scene = load_at(builder, 1);
  EXPECT_EQ(place(scene, 0).x, 3);
  EXPECT_TRUE(warns(scene, "its node has a matrix"));
}

TEST(AnimationChoice, a_million_keys_are_read) {
  constexpr std::size_t kKeys = 1'000'000;
  Builder builder;
  std::vector<float> times(kKeys), values(3 * kKeys);
  for (std::size_t i = 0; i < kKeys; ++i) {
    times[i] = static_cast<float>(i) / 1024;
    values[3 * i] = static_cast<float>(i);
  }
  add_channel(builder, 0, target_of(0, "translation"), {.times = times, .values = values});
  for (const char* path : {"scale", "rotation"})  // share the keys with others, each of which is looked at once
    add_channel(builder, 0, target_of(0, path), {.times = {0, 1}, .values = {1, 1, 1, 1, 1, 1}, .type = "VEC3"});
  builder.json["animations"][0]["channels"].erase(2);
  EXPECT_EQ(place(load_at(builder, 777777.5 / 1024), 0).x, 777777.5);
}

}  // namespace
