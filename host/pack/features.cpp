// SPDX-License-Identifier: Apache-2.0
#include "pack/features.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "film/layers.h"
#include "formula/kernel_code.h"
#include "pack/feature_rules.h"
#include "pack/lights/pack_light_paths.h"

namespace eikon {

Features::Features(const Scene& scene, const Settings& settings)
    : scatter_bounds_(scatter_bounds(settings.aovs, settings.depth_series)),
      light_groups_(scene.light_groups),
      environment_light_group_(scene.environment_light_group),
      mattes_(std::make_shared<const Mattes>(make_mattes(scene, settings.aovs))),
      has_glossy_targets_(std::ranges::any_of(scene.materials, is_glossy_light_target)) {
  const SceneFacts facts(scene, settings);
  const auto add = [&](const char* kind, const char* name, int channels) {
    Need need = need_of(Feature(entries_.size()), facts);
    entries_.push_back({kind, name, channels, need.on, std::move(need.reason)});
  };
  // Numbers of channels in features.def are expressions of these two.
  const int EK_BOUNCE_BINS = int(scatter_bounds_.size()) + 1, EK_LIGHT_GROUPS = int(light_groups_.size());
#define EK_LOBE(name, bit, traits) add("lobe", #name, 0);
#define EK_LIGHT(name, bit) add("light", #name, 0);
#define EK_SHAPE_KIND(name, bit) add("shape", #name, 0);
#define EK_OPTION(name) add("option", #name, 0);
#define EK_AOV(name, channels) add("layer", #name, channels);
#include "shared/features.def"
  if (has(Feature::implicit)) {
    formula_code_ = formula::kernel_code(scene.formulas);
    formula_count_ = scene.formulas.size();
  }
  if (has(Feature::each_light))
    light_samples_ = std::uint32_t(facts.lights.count());
  else if (has(Feature::next_event))
    light_samples_ = settings.light_samples;
}

void Features::set_two_level(bool on, const std::string& reason) {
  FeatureEntry& entry = entries_[std::size_t(Feature::instance)];
  entry.on = on;
  entry.reason = reason;
}

void Features::set_guiding(bool guiding, bool path_log) {
  FeatureEntry& entry = entries_[std::size_t(Feature::guiding)];
  entry.on = guiding;
  entry.reason = guiding ? "the pilot found that it pays" : "the pilot left it out";
  entries_[std::size_t(Feature::path_log)].on = path_log;
}

void Features::leave_out_light_paths() {
  FeatureEntry& entry = entries_[std::size_t(Feature::light_paths)];
  entry.on = false;
  entry.reason = "a trial found that they do not pay";
}

std::map<std::string, std::string> Features::defines() const {
  std::map<std::string, std::string> defines;
  for (const FeatureEntry& feature : entries_) defines["EK_HAS_" + feature.name] = feature.on ? "1" : "0";
  if (has(Feature::bounce_bins)) {
    std::uint32_t bounds = 0;
    for (const std::uint32_t bound : scatter_bounds_) bounds |= 1U << bound;
    defines["EK_BOUNCE_BOUNDS"] = fmt::format("{}u", bounds);
    defines["EK_BOUNCE_BINS"] = std::to_string(scatter_bounds_.size() + 1);
  }
  if (has(Feature::light_group)) {
    defines["EK_LIGHT_GROUPS"] = std::to_string(light_groups_.size());
    defines["EK_ENVIRONMENT_GROUP"] = fmt::format("{}u", environment_light_group_);
  }
  if (has(Feature::light_paths)) defines["EK_GLOSSY_TARGETS"] = has_glossy_targets_ ? "1" : "0";
  defines["EK_LIGHT_SAMPLES"] = std::to_string(light_samples_);
  if (formula_count_ > 0) defines["EK_FORMULA_COUNT"] = std::to_string(formula_count_);
  return defines;
}

std::vector<std::string> Features::film_channels() const {
  std::vector<std::string> channels = {"R", "G", "B"};
  const auto add = [&](Feature feature, FilmSum sum) {
    if (!has(feature)) return;
    const std::vector<std::string> names = film_channels_of(sum, scatter_bounds_, light_groups_);
    const FeatureEntry& entry = entries_[std::size_t(feature)];
    if (int(names.size()) != entry.channels) throw InternalError("channels of layer '" + entry.name + "' disagree");
    channels.insert(channels.end(), names.begin(), names.end());
  };
#define EK_AOV(name, channels) add(Feature::name, FilmSum::name);
#include "shared/features.def"
  return channels;
}

std::string Features::summary() const {
  std::string text;
  for (const FeatureEntry& feature : entries_)
    if (feature.on) text += (text.empty() ? "" : " ") + feature.name;
  return text;
}

PathStateLayout path_state_layout(const Features& features, bool chunked) {
  // The conditions of path_state.def are C expressions of these names, which are macros in kernels.
  const bool EK_CHUNKED = chunked;
#define EK_FEATURE(name) [[maybe_unused]] const bool EK_HAS_##name = features.has(Feature::name);
#include "shared/features.def"
  PathStateLayout layout;
  const auto add = [&](const char* name, std::uint32_t words) {
    if (words > 0) layout.field[name] = layout.words;
    layout.words += words;
  };
#define EK_FIELD(type, name, needed) add(#name, std::uint32_t(EK_WORDS_##type * (needed)));
#define EK_SHADOW(type, name, needed) \
  add("shadow_" #name, std::uint32_t(EK_WORDS_##type * (needed)) * features.light_samples());
#include "shared/path_state.def"
  return layout;
}

}  // namespace eikon
