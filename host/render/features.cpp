// SPDX-License-Identifier: Apache-2.0
#include "render/features.h"

#include <algorithm>
#include <fmt/format.h>

#include "core/error.h"

namespace eikon {
namespace {

struct Need {
  bool on;
  std::string who;
};

template <class Range, class Predicate>
Need any_of(const Range& range, const std::string& kind, const std::string& otherwise, Predicate predicate) {
  const auto found = std::find_if(range.begin(), range.end(), predicate);
  if (found == range.end()) return {false, otherwise};
  return {true, fmt::format("{} '{}'", kind, found->name)};
}

}  // namespace

Features::Features(const Scene& scene, const Settings& settings) {
  std::map<std::string, Need> needs;
  needs["diffuse"] = {true, "every material"};
  const Material* const emitter = first_emitter(scene);
  needs["area"] = {emitter != nullptr,
                   emitter != nullptr ? fmt::format("material '{}'", emitter->name) : "nothing emits"};
  const glm::vec3 sky = settings.environment.radiance;
  const bool has_sky = sky.x > 0 || sky.y > 0 || sky.z > 0;
  needs["environment"] = {has_sky, has_sky ? "the environment" : "the environment is black"};
  needs["vertex_normal"] = any_of(scene.meshes, "mesh", "no mesh has normals", [](const Mesh& mesh) {
    return std::any_of(mesh.primitives.begin(), mesh.primitives.end(),
                       [](const Primitive& p) { return !p.normals_object.empty(); });
  });
  const LightSampling sampling = settings.light_sampling;
  const bool lit = needs["area"].on || has_sky;
  const bool samples_lights = sampling == LightSampling::mis || sampling == LightSampling::light;
  needs["next_event"] = {samples_lights && lit, lit ? "--light-sampling" : "there is no light"};
  needs["bsdf_emission"] = {sampling != LightSampling::light && lit, lit ? "--light-sampling" : "there is no light"};
  needs["uniform_scatter"] = {sampling == LightSampling::hemisphere, "--light-sampling"};
  for (const char* layer : {"albedo", "normal", "depth", "id"})
    needs[layer] = {std::find(settings.aovs.begin(), settings.aovs.end(), layer) != settings.aovs.end(), "--aov"};

  const auto add = [&](const char* kind, const char* name, int channels) {
    const auto need = needs.find(name);
    if (need == needs.end()) throw InternalError(fmt::format("nobody decides feature '{}'", name));
    ledger_.push_back({kind, name, channels, need->second.on, need->second.who});
  };
#define EK_LOBE(name, bit) add("lobe", #name, 0);
#define EK_LIGHT(name, bit) add("light", #name, 0);
#define EK_OPTION(name) add("option", #name, 0);
#define EK_AOV(name, channels) add("layer", #name, channels);
#include "shared/features.def"
}

bool Features::has(const std::string& name) const {
  const auto found = std::find_if(ledger_.begin(), ledger_.end(), [&](const Feature& f) { return f.name == name; });
  if (found == ledger_.end()) throw InternalError(fmt::format("no feature '{}'", name));
  return found->on;
}

std::map<std::string, std::string> Features::defines() const {
  std::map<std::string, std::string> defines;
  for (const Feature& feature : ledger_) defines["EK_HAS_" + feature.name] = feature.on ? "1" : "0";
  return defines;
}

std::vector<std::string> Features::film_channels() const {
  static const std::map<std::string, std::vector<std::string>> names = {
      {"albedo", {"albedo.R", "albedo.G", "albedo.B"}},
      {"normal", {"normal.X", "normal.Y", "normal.Z"}},
      {"depth", {"depth.sum", "depth.hits"}},
      {"id", {"id"}},
  };
  std::vector<std::string> channels = {"R", "G", "B"};
  for (const Feature& feature : ledger_) {
    if (feature.kind != "layer" || !feature.on) continue;
    const auto& layer = names.at(feature.name);
    if (int(layer.size()) != feature.channels) throw InternalError("channels of layer '" + feature.name + "' disagree");
    channels.insert(channels.end(), layer.begin(), layer.end());
  }
  return channels;
}

std::string Features::summary() const {
  std::string text;
  for (const Feature& feature : ledger_)
    if (feature.on) text += (text.empty() ? "" : " ") + feature.name;
  return text;
}

PathStateLayout path_state_layout(const Features& features, bool chunked) {
  // The `needed` expressions of path_state.def, evaluated as the kernels' preprocessor does.
  const bool EK_CHUNKED = chunked;
  const bool EK_HAS_next_event = features.has("next_event"), EK_HAS_environment = features.has("environment"),
             EK_HAS_bsdf_emission = features.has("bsdf_emission");
  PathStateLayout layout;
  const auto add = [&](const char* name, bool needed) {
    if (needed) layout.field[name] = layout.words++;
  };
#define EK_FIELD(name, needed) add(#name, needed);
#define EK_SHADOW(name, needed) add(#name, needed);
#include "shared/path_state.def"
  return layout;
}

}  // namespace eikon
