// SPDX-License-Identifier: Apache-2.0
// Adds animations to the files of gltf_builder.h.
#pragma once
#include "support/gltf_builder.h"

namespace scene_test {

/// Keys of a sampler, whose times and values are floats. Values of other types are given as an
/// accessor to add_channel.
struct Keys {
  std::vector<float> times;
  std::vector<float> values;
  const char* type = "VEC3";
  const char* interpolation = "LINEAR";
};

inline std::size_t numbers_in(const std::string& type) {
  return type == "SCALAR" ? 1 : static_cast<std::size_t>(type.back() - '0');
}

/// Adds a channel to animation `animation`, which is made if it is the next; target: {"node": ..,
/// "path": ..}.
inline Json& add_channel(Builder& builder, std::size_t animation, const Json& target, std::size_t input,
                         std::size_t output, const char* interpolation = "LINEAR") {
  Json& animations = builder.json["animations"];
  if (animations.size() == animation) animations.push_back({{"channels", Json::array()}, {"samplers", Json::array()}});
  Json& entry = animations[animation];
  entry["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
  entry["channels"].push_back({{"sampler", entry["samplers"].size() - 1}, {"target", target}});
  return entry;
}

inline Json& add_channel(Builder& builder, std::size_t animation, const Json& target, const Keys& keys) {
  const std::size_t input = builder.add("SCALAR", kFloat, keys.times, keys.times.size()),
                    output = builder.add(keys.type, kFloat, keys.values, keys.values.size() / numbers_in(keys.type));
  return add_channel(builder, animation, target, input, output, keys.interpolation);
}

inline Json target_of(std::size_t node, const char* path) { return {{"node", node}, {"path", path}}; }

inline Json pointer_to(const char* pointer) {
  return {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}};
}

inline eikon::Scene load_at(const Builder& builder, const eikon::AnimationChoice& choice) {
  const TemporaryFolder folder;
  return eikon::load_scene(folder.write("scene.gltf", builder.text()), {.variant = {}, .animation = choice});
}

inline eikon::Scene load_at(const Builder& builder, double seconds) {
  return load_at(builder, {.animation = {}, .time_s = seconds, .loop = false});
}

}  // namespace scene_test
