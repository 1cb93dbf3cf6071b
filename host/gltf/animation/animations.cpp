// SPDX-License-Identifier: Apache-2.0
#include "gltf/animation/animations.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "core/error.h"
#include "gltf/animation/properties.h"
#include "gltf/document/document_check.h"
#include "gltf/extensions.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr std::size_t kMaxNames = 20;  // in a message

/// A property of the document, and its value over time.
struct Channel {
  std::string pointer;
  const Property& property;
  Curve curve;
};

struct Animation {
  std::size_t index = 0;
  std::vector<Channel> channels{};
  double begin_s = 0, end_s = 0;
};

JsonView view_of_animation(const Json& document, std::size_t index) {
  return {.value = element(items(document, "animations"), index),
          .kind = "animation",
          .index = static_cast<std::int64_t>(index)};
}

Interpolation interpolation_of(const JsonView& sampler) {
  const std::string* const name = as_string(sampler, "interpolation");
  if (name == nullptr || *name == "LINEAR") return Interpolation::linear;
  if (*name == "STEP") return Interpolation::step;
  if (*name == "CUBICSPLINE") return Interpolation::cubic;
  sampler.fail(fmt::format("'interpolation' {} is none of STEP, LINEAR, CUBICSPLINE", in_quotes(*name)));
}

/// The types that [glTF 2.0, section 3.11; KHR_animation_pointer, "Output accessor component
/// types"] allow.
bool is_legal(const Accessor& values, const Property& property) {
  const std::uint32_t components = property.width == 0 ? 1 : property.width;
  if (values.is_matrix || values.component_count != components) return false;
  if (property.kind == ValueKind::boolean) return values.component == ComponentType::u8 && !values.normalized;
  const bool packs = values.normalized && values.component != ComponentType::u32;
  const bool is_place = property.pattern == "/nodes/*/translation" || property.pattern == "/nodes/*/scale";
  return values.component == ComponentType::f32 || (packs && !is_place);
}

/// True if a pointer is to a part of a node's transform that a matrix takes the place of.
bool has_matrix(const Json& document, std::string_view pointer) {
  const std::vector<std::string> names = split(pointer.substr(1), '/');
  const bool of_transform = names.size() == 3 && names[0] == "nodes" && names[2] != "weights";
  return of_transform &&
         member(element(items(document, "nodes"), *number_in<std::size_t>(names[1])), "matrix") != nullptr;
}

/// Reads animations, and looks at the keys of each accessor once, however many of them share it.
class AnimationReader {
 public:
  explicit AnimationReader(const AnimationSource& source) : source_(source) {}

  /// throws InputError with the place
  Animation read(std::size_t index) {
    source_.wrong.check("animation", index);
    const JsonView view = view_of_animation(source_.document, index);
    Animation animation{.index = index};
    const Json* const channels = as_array(view, "channels");
    std::set<std::string> moved;
    for (std::size_t i = 0; channels != nullptr && i < size_of(*channels); ++i) {
      const JsonView channel{
          .value = element(*channels, i), .kind = "channel", .index = static_cast<std::int64_t>(i), .parent = &view};
      const std::string pointer = pointer_of(channel, view.label());
      if (pointer.empty()) continue;
      if (!moved.insert(pointer).second) {
        source_.notes.mended(channel.label() + ": left out, another channel moves the same");
        continue;
      }
      animation.channels.push_back(read_channel(channel, pointer));
    }
    for (const Channel& channel : animation.channels) {
      const bool is_first = &channel == &animation.channels.front();
      animation.begin_s = is_first ? channel.curve.begin_s() : std::min(animation.begin_s, channel.curve.begin_s());
      animation.end_s = is_first ? channel.curve.end_s() : std::max(animation.end_s, channel.curve.end_s());
    }
    return animation;
  }

 private:
  /// Finds the property that a channel moves; empty for one that eikon does not read.
  std::string pointer_of(const JsonView& channel, const std::string& user) {
    const Json* const json = as_object(channel, "target");
    if (json == nullptr) channel.fail("'target' is missing");
    const JsonView target{.value = *json, .kind = "target", .parent = &channel};
    const std::string* const path = as_string(target, "path");
    if (path == nullptr) target.fail("'path' is missing");
    std::string pointer;
    if (*path == "pointer") {
      const Json* const extension = extension_of(*json, kPointerExtension);
      if (extension == nullptr || !is_object(*extension)) target.fail(fmt::format("{} is missing", kPointerExtension));
      const std::string* const text =
          as_string({.value = *extension, .kind = kPointerExtension, .parent = &target}, "pointer");
      if (text == nullptr) target.fail("'pointer' is missing");
      pointer = *text;
    } else {
      const Json* const node = member(*json, "node");
      if (node == nullptr) return {};  // without a node it is for applications [glTF 2.0, section 3.11]
      pointer = fmt::format("/nodes/{}/{}", to_index(*node), *path);
    }
    if (find_property(pointer) == nullptr) {
      source_.notes.unsupported("animation of " + in_quotes(*path == "pointer" ? pointer : *path), user);
      return {};
    }
    try {
      check_pointer(source_.document, pointer);
    } catch (const InputError& error) {
      target.fail(error.what());
    }
    if (!has_matrix(source_.document, pointer)) return pointer;
    source_.notes.mended(channel.label() + ": left out, its node has a matrix, which glTF lets no animation move");
    return {};
  }

  Channel read_channel(const JsonView& channel, const std::string& pointer) {
    const Property& property = *find_property(pointer);
    const Json* const index = member(channel.value, "sampler");
    if (index == nullptr) channel.fail("'sampler' is missing");
    const Json& samplers = *member(channel.parent->value, "samplers");
    const JsonView sampler{.value = element(samplers, to_index(*index)),
                           .kind = "sampler",
                           .index = static_cast<std::int64_t>(to_index(*index)),
                           .parent = channel.parent};
    const Json *input = member(sampler.value, "input"), *output = member(sampler.value, "output");
    if (input == nullptr || output == nullptr) sampler.fail("'input' or 'output' is missing");
    const Accessor &times = source_.accessors[to_index(*input)], &values = source_.accessors[to_index(*output)];
    if (!is_legal(values, property))
      sampler.fail(fmt::format("values in {} are of a type that {} does not have", values.label, in_quotes(pointer)));
    std::size_t width = property.width;
    if (width == 0) {
      const std::optional<std::size_t> targets = weight_count(source_.document, pointer);
      if (!targets) channel.fail("moves morph targets where there are none");
      width = *targets;
    }
    const Curve curve{.times = times,
                      .values = values,
                      .interpolation = interpolation_of(sampler),
                      .kind = property.kind,
                      .width = width};
    check(sampler, curve, to_index(*input), to_index(*output));
    return {.pointer = pointer, .property = property, .curve = curve};
  }

  void check(const JsonView& sampler, const Curve& curve, std::size_t input, std::size_t output) {
    try {
      once(times_checked_, input, [&] {
        if (check_times(curve.times))
          source_.notes.mended(fmt::format("{}: times in {} are negative or equal; taken as they are", sampler.label(),
                                           curve.times.label));
      });
      check_value_count(curve);
      once(values_checked_, {output, curve.kind, curve.interpolation == Interpolation::cubic},
           [&] { check_values(curve); });
    } catch (const InputError& error) {
      sampler.fail(error.what());
    }
  }

  /// Calls `check` for a key the first time, and throws what it has thrown then each time.
  template <class Key, class Check>
  static void once(std::map<Key, std::string>& results, const Key& key, const Check& check) {
    const auto [result, is_new] = results.try_emplace(key);
    try {
      if (is_new) check();
    } catch (const InputError& error) {
      result->second = error.what();
    }
    if (!result->second.empty()) throw InputError(result->second);
  }

  const AnimationSource& source_;
  std::map<std::size_t, std::string> times_checked_;  // what is wrong with them, or nothing
  std::map<std::tuple<std::size_t, ValueKind, bool>, std::string> values_checked_;
};

/// The animation that is asked for by name or index. throws InputError
std::size_t animation_called(const std::string& wanted, const std::vector<AnimationSummary>& known) {
  const auto named = std::ranges::find(known, wanted, &AnimationSummary::name);
  if (named != known.end()) return static_cast<std::size_t>(named - known.begin());
  const auto index = number_in<std::size_t>(wanted);
  if (index && *index < known.size()) return *index;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(known.size(), kMaxNames); ++i)
    names.push_back(known[i].name.empty() ? fmt::format("{}", i) : in_quotes(known[i].name));
  if (names.size() < known.size()) names.emplace_back("...");
  throw InputError(fmt::format("it has no animation {}; {}", in_quotes(wanted),
                               names.empty() ? "it has none at all: leave --animation out"
                                             : fmt::format("choose one of {}", fmt::join(names, ", "))));
}

/// Time on an animation's own clock.
double time_within(const Animation& animation, double scene_time_s, bool loop) {
  if (!loop || !(animation.end_s > 0)) return std::clamp(scene_time_s, animation.begin_s, animation.end_s);
  const double time_s = std::fmod(scene_time_s, animation.end_s);
  return std::max(time_s < 0 ? time_s + animation.end_s : time_s, animation.begin_s);
}

/// Leaves out animations that move what one before them moves.
std::vector<Animation> without_contradictions(std::vector<Animation> all, const AnimationSource& source) {
  std::vector<Animation> kept;
  std::map<std::string, std::size_t> movers;  // pointer -> animation
  std::string first, reason;
  std::size_t count = 0;
  for (Animation& animation : all) {
    const auto taken = std::ranges::find_if(animation.channels,
                                            [&](const Channel& channel) { return movers.contains(channel.pointer); });
    if (taken == animation.channels.end()) {
      for (const Channel& channel : animation.channels) movers.emplace(channel.pointer, animation.index);
      kept.push_back(std::move(animation));
      continue;
    }
    if (count++ != 0) continue;
    first = view_of_animation(source.document, animation.index).label();
    reason = fmt::format("left out, as {} moves the same; choose one with --animation",
                         view_of_animation(source.document, movers.at(taken->pointer)).label());
  }
  if (count > 1) first += fmt::format(" and {} more", count - 1);
  if (count != 0) source.notes.warn(fmt::format("{}: {}", first, reason));
  return kept;
}

/// True for whatever belongs to materials or lights, and for the visibility of nodes.
bool may_change_light(const Channel& channel) {
  return channel.pointer.starts_with("/materials/") || channel.pointer.starts_with("/extensions/") ||
         channel.property.kind == ValueKind::boolean;
}

/// Reads an animation and describes it. Returns one without channels, and adds it to `wrong`, if it
/// is damaged.
Animation read_or_leave_out(AnimationReader& reader, std::size_t index, const AnimationSource& source, Scene& scene) {
  try {
    Animation animation = reader.read(index);
    AnimationSummary& summary = scene.animations[index];
    summary.begin_s = animation.begin_s;
    summary.end_s = animation.end_s;
    summary.channel_count = animation.channels.size();
    summary.changes_light = std::ranges::any_of(animation.channels, may_change_light);
    return animation;
  } catch (const InputError& error) {
    if (!source.wrong.has("animation", index))
      source.wrong.add(view_of_animation(source.document, index), error.what());
    return {.index = index};
  }
}

/// Reads all animations. Returns those that are sound and asked for: `wanted`, or without it all.
/// Nothing is said of the others.
std::vector<Animation> read_all(const AnimationSource& source, bool none, std::optional<std::size_t> wanted,
                                Scene& scene) {
  Notes silent;
  WrongParts silent_wrong = source.wrong;
  const AnimationSource quiet{source.document, source.accessors, silent_wrong, silent};
  AnimationReader reader(source), quiet_reader(quiet);
  std::vector<Animation> animations;
  for (std::size_t i = 0; i < scene.animations.size(); ++i) {
    const bool counts = !none && (!wanted || *wanted == i);
    Animation animation = read_or_leave_out(counts ? reader : quiet_reader, i, counts ? source : quiet, scene);
    if (counts && !animation.channels.empty()) animations.push_back(std::move(animation));
  }
  return animations;
}

/// True for what moves things, or turns, scales or bends them.
bool is_motion(const Channel& channel) {
  const bool of_place = channel.pointer.starts_with("/nodes/") || channel.pointer.starts_with("/meshes/") ||
                        channel.pointer.starts_with("/cameras/");
  return of_place && channel.property.kind != ValueKind::boolean;
}

/// Writes the pose. Returns a text that identifies it.
std::string pose(const Animation& animation, const AnimationSource& source, const AnimationChoice& choice) {
  const double time_s = time_within(animation, choice.time_s, choice.loop);
  const double held_s = time_within(animation, choice.held_s.value_or(choice.time_s), choice.loop);
  for (const Channel& channel : animation.channels)
    if (!write_property(source.document, channel.pointer, channel.property,
                        channel.curve.at(is_motion(channel) ? time_s : held_s)))
      source.notes.mended(fmt::format("{}: {} brought into its range",
                                      view_of_animation(source.document, animation.index).label(),
                                      in_quotes(channel.pointer)));
  std::string text = fmt::format("animation {} at {:a} s\n", animation.index, time_s);
  if (const Shutter& shutter = choice.shutter; shutter.is_open())
    text += fmt::format("open from {:a} to {:a} s, {} steps\n", shutter.open_s, shutter.close_s, shutter.steps);
  return text;
}

}  // namespace

std::string animate(const AnimationSource& source, const AnimationChoice& choice, Scene& scene) {
  const Json& list = items(source.document, "animations");
  for (std::size_t i = 0; i < size_of(list); ++i) {
    const Json* const name = member(element(list, i), "name");
    scene.animations.push_back({.name = name == nullptr ? std::string() : to_string(*name)});
  }
  const bool any = choice.animation.empty() || choice.animation == "all", none = choice.animation == "none";
  std::optional<std::size_t> wanted;
  if (!any && !none) {
    wanted = animation_called(choice.animation, scene.animations);
    (void)AnimationReader(source).read(*wanted);  // throws if it is damaged
  }
  const std::vector<Animation> animations = without_contradictions(read_all(source, none, wanted, scene), source);
  if (animations.empty() && any && choice.time_s != 0)
    source.notes.warn("it has no animation that moves anything: it is the same at any time");
  std::string text;
  for (const Animation& animation : animations) {
    scene.animations[animation.index].in_force = true;
    text += pose(animation, source, choice);
  }
  return text;
}

}  // namespace eikon
