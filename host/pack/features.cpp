// SPDX-License-Identifier: Apache-2.0
#include "pack/features.h"

#include <algorithm>
#include <fmt/format.h>
#include <unordered_set>

#include "core/error.h"
#include "formula/kernel_code.h"
#include "pack/materials/hit_class.h"
#include "film/layers.h"
#include "pack/lights/light_census.h"
#include "scene/emission.h"

namespace eikon {
namespace {

struct Need {
  bool on;
  std::string who;
};

/// Materials and primitives that some node shows.
struct Shown {
  std::vector<const Material*> materials;
  std::vector<const Mesh*> meshes;

  explicit Shown(const Scene& scene) {
    for (const Node& node : scene.nodes) {
      const Mesh& mesh = scene.meshes[node.mesh];
      add(meshes, &mesh);
      for (const Primitive& primitive : mesh.primitives) add(materials, &scene.materials[primitive.material]);
    }
    for (const Shape& shape : scene.shapes) add(materials, &scene.materials[shape.material]);
  }

  template <class Predicate>
  [[nodiscard]] Need material(const std::string& otherwise, Predicate predicate) const {
    for (const Material* m : materials)
      if (predicate(*m)) return {true, fmt::format("material '{}'", m->name)};
    return {false, otherwise};
  }
  template <class Predicate>
  [[nodiscard]] Need primitive(const std::string& otherwise, Predicate predicate) const {
    for (const Mesh* m : meshes)
      if (std::any_of(m->primitives.begin(), m->primitives.end(), predicate))
        return {true, fmt::format("mesh '{}'", m->name)};
    return {false, otherwise};
  }

 private:
  template <class T>
  void add(std::vector<const T*>& list, const T* item) {
    if (known_.insert(item).second) list.push_back(item);
  }
  std::unordered_set<const void*> known_;
};

/// What reflects as raycast.h has it takes the code of one lobe, and what that reads of materials.
void use_raycast(std::map<std::string, Need>& needs) {
  const Need unused{false, "--integrator"};
#define EK_LOBE(name, bit) needs[#name] = unused;
#include "shared/features.def"
  for (const char* name : {"dispersion", "diffuse_transmission", "diffuse_transmission_texture", "sheen", "anisotropy"})
    needs[name] = unused;
  needs["phong"] = needs["material_detail"] = {true, "--integrator"};
}

}  // namespace

std::string lobe_of(const Material& material) {
  if (material.unlit) return "diffuse";
  if (material.conductor) return "conductor";
  if (material.phong) return "phong";
  if (material.measured) return "measured";
  const bool may_be_dielectric = material.metallic < 1 || material.metallic_roughness_texture;
  if ((material.transmission > 0 || material.diffuse_transmission > 0) && may_be_dielectric) return "transmission";
  if (material.metallic > 0 || material.specular > 0 || material.iridescence > 0) return "metallic_roughness";
  return "diffuse";
}

bool is_solid(const Material& material) { return material.solid && lobe_of(material) == "transmission"; }

Features::Features(const Scene& scene, const Settings& settings) {
  std::map<std::string, Need> needs;
  const Shown shown(scene);
  const auto lobe = [&](const char* name) {
    needs[name] = shown.material("no material", [&](const Material& m) { return lobe_of(m) == name; });
  };
#define EK_LOBE(name, bit) lobe(#name);
#include "shared/features.def"
  const auto shape = [&](ShapeKind kind) {
    const auto found = std::ranges::find(scene.shapes, kind, &Shape::kind);
    return found == scene.shapes.end() ? Need{false, "no such shape"}
                                       : Need{true, fmt::format("node '{}'", found->name)};
  };
#define EK_SHAPE_KIND(name, bit) needs[#name] = shape(ShapeKind::name);
#include "shared/features.def"
  if (needs["implicit"].on) {
    formula_code_ = formula::kernel_code(scene.formulas);
    formula_count_ = scene.formulas.size();
  }
  needs["shape"] = scene.shapes.empty() ? Need{false, "no shape"} : shape(scene.shapes.front().kind);
  const Material* const emitter = first_emitter(scene);
  needs["area"] = {emitter != nullptr,
                   emitter != nullptr ? fmt::format("material '{}'", emitter->name) : "nothing emits"};
  const auto lamp = std::ranges::find_if(
      scene.shapes, [&](const Shape& each) { return is_sampled_light(each, scene.materials[each.material]); });
  needs["shape_light"] =
      lamp == scene.shapes.end() ? Need{false, "no shape emits"} : Need{true, fmt::format("node '{}'", lamp->name)};
  const glm::vec3 sky = settings.environment.radiance;
  const EnvironmentMap* const map = settings.environment.map.get();
  const bool has_sky = map == nullptr && (sky.x > 0 || sky.y > 0 || sky.z > 0);
  needs["environment"] = {has_sky, has_sky          ? "the environment"
                                   : map != nullptr ? "the environment is a map"
                                                    : "the environment is black"};
  needs["environment_map"] = {map != nullptr, map != nullptr ? map->name : "no map"};
  const auto punctual = [&](const char* name, PunctualLight::Kind kind) {
    const auto found = std::find_if(scene.lights.begin(), scene.lights.end(),
                                    [&](const PunctualLight& light) { return light.kind == kind; });
    needs[name] =
        found == scene.lights.end() ? Need{false, "no such light"} : Need{true, fmt::format("light '{}'", found->name)};
  };
  punctual("point", PunctualLight::Kind::point);
  punctual("spot", PunctualLight::Kind::spot);
  punctual("directional", PunctualLight::Kind::directional);
  const auto hits = [&](const char* name, std::uint32_t of_class) {
    needs[name] = shown.primitive("no such surface", [&](const Primitive& primitive) {
      return hit_class(scene.materials[primitive.material], &primitive) == of_class;
    });
    for (const Shape& each : scene.shapes)
      if (!needs[name].on && hit_class(scene.materials[each.material], nullptr) == of_class)
        needs[name] = {true, fmt::format("node '{}'", each.name)};
  };
  hits("plain_hits", SHADING_LAMBERT);
  hits("opaque_hits", SHADING_OPAQUE);
  hits("clear_hits", SHADING_TRANSMISSIVE);
  needs["instance"] = {false, "every mesh is stored for each of its places"};
  needs["vertex_normal"] =
      shown.primitive("no mesh has normals", [](const Primitive& p) { return !p.normals_object.empty(); });
  needs["vertex_color"] = shown.primitive("no mesh has colours", [](const Primitive& p) { return !p.colors.empty(); });
  needs["uv"] = shown.material("no texture", [](const Material& m) { return !textures_of(m).empty(); });
  needs["uv1"] = shown.material("no texture is placed by TEXCOORD_1", [](const Material& m) {
    return std::ranges::any_of(textures_of(m), [](const TextureUse& use) { return use.texture->uv_set == 1; });
  });
  const auto texture = [&](const char* name, auto member) {
    needs[name] = shown.material("no such texture", [&](const Material& m) { return (m.*member).has_value(); });
  };
  texture("base_color_texture", &Material::base_color_texture);
  texture("metallic_roughness_texture", &Material::metallic_roughness_texture);
  // Coats' normal maps need what those of materials need.
  needs["normal_texture"] = shown.material(
      "no such texture", [](const Material& m) { return m.normal_texture || m.clearcoat_normal_texture; });
  texture("emissive_texture", &Material::emissive_texture);
  texture("transmission_texture", &Material::transmission_texture);
  needs["specular_texture"] = shown.material(
      "no such texture", [](const Material& m) { return m.specular_texture || m.specular_color_texture; });
  needs["material_extension"] = shown.material("no specular, transmission, volume or table", [](const Material& m) {
    return lobe_of(m) == "transmission" || lobe_of(m) == "measured" ||
           (lobe_of(m) != "diffuse" &&
            (m.specular != 1 || m.specular_color != glm::vec3(1) || m.specular_texture || m.specular_color_texture));
  });
  const auto is_coated = [](const Material& m) { return m.clearcoat > 0; };
  const auto is_anisotropic = [](const Material& m) {
    return m.anisotropy > 0 && lobe_of(m) != "diffuse" && lobe_of(m) != "phong" && lobe_of(m) != "measured";
  };
  const auto is_translucent = [](const Material& m) {
    return m.diffuse_transmission > 0 && lobe_of(m) == "transmission";
  };
  const auto disperses = [](const Material& m) {
    return m.dispersion > 0 && m.solid && m.ior > 1 && lobe_of(m) == "transmission";
  };
  const auto is_filmy = [](const Material& m) {
    const std::string kind = lobe_of(m);
    return m.iridescence > 0 && (kind == "metallic_roughness" || kind == "transmission" || kind == "conductor");
  };
  const auto has_sheen = [](const Material& m) { return m.sheen_color != glm::vec3(0); };
  needs["material_detail"] = shown.material(
      "no clearcoat, sheen, diffuse transmission, anisotropy, dispersion, iridescence, conductor or highlight",
      [&](const Material& m) {
        return is_coated(m) || has_sheen(m) || is_translucent(m) || is_anisotropic(m) || disperses(m) || is_filmy(m) ||
               lobe_of(m) == "conductor" || lobe_of(m) == "phong";
      });
  needs["iridescence"] = shown.material("no thin film", is_filmy);
  needs["iridescence_texture"] = shown.material(
      "no such texture", [](const Material& m) { return m.iridescence_texture || m.film_thickness_texture; });
  needs["diffuse_transmission"] = shown.material("nothing scatters light that passes it", is_translucent);
  needs["diffuse_transmission_texture"] = shown.material("no such texture", [](const Material& m) {
    return m.diffuse_transmission_texture || m.diffuse_transmission_color_texture;
  });
  needs["dispersion"] = shown.material("no solid's index disperses", disperses);
  needs["anisotropy"] = shown.material("no anisotropy", is_anisotropic);
  texture("anisotropy_texture", &Material::anisotropy_texture);
  needs["tangent"] = shown.material("no normal map or anisotropy", [&](const Material& m) {
    return m.normal_texture || m.clearcoat_normal_texture || is_anisotropic(m);
  });
  needs["clearcoat"] = shown.material("no clearcoat", is_coated);
  needs["clearcoat_texture"] = shown.material(
      "no such texture", [](const Material& m) { return m.clearcoat_texture || m.clearcoat_roughness_texture; });
  needs["clearcoat_normal"] = shown.material("every coat follows its material", [&](const Material& m) {
    return is_coated(m) && (m.normal_texture || m.clearcoat_normal_texture);
  });
  needs["sheen"] = shown.material("no sheen", has_sheen);
  needs["sheen_texture"] = shown.material(
      "no such texture", [](const Material& m) { return m.sheen_color_texture || m.sheen_roughness_texture; });
  needs["absorption"] = shown.material("no volume absorbs", [](const Material& m) {
    return is_solid(m) && m.attenuation_distance > 0 && m.attenuation_color != glm::vec3(1);
  });
  // One solid can need it too: its own parts may overlap.
  needs["nested_media"] = shown.material(
      "no solid says mediumPriority", [](const Material& m) { return is_solid(m) && m.medium_priority.has_value(); });
  needs["energy_compensation"] = {false, "--energy-compensation"};
  if (settings.energy_compensation)
    needs["energy_compensation"] = shown.material("no rough metal or glass", [](const Material& m) {
      const std::string kind = lobe_of(m);
      return (m.roughness > 0 || m.metallic_roughness_texture) &&
             (kind == "conductor" || kind == "transmission" || (kind == "metallic_roughness" && m.metallic > 0));
    });
  needs["opacity"] =
      shown.material("every material is opaque", [](const Material& m) { return m.alpha_mode != AlphaMode::opaque; });
  needs["unlit"] = shown.material("no material is unlit", [](const Material& m) { return m.unlit; });
  const LightSampling sampling = settings.light_sampling;
  bool lit = false;
#define EK_LIGHT(name, bit) lit = lit || needs[#name].on;
#include "shared/features.def"

  const LightCensus census = count_lights(scene, settings);
  needs["light_tree"] = {census.wants_tree(), fmt::format("{} lights that have a place", census.places())};
  needs["quad_light"] = {census.pairs > 0, fmt::format("{} pairs of emissive triangles", census.pairs)};
  needs["one_light"] = {census.is_one(), fmt::format("{} lights", census.places() + census.distant)};

  const bool samples_lights = sampling == LightSampling::mis || sampling == LightSampling::light;
  needs["next_event"] = {samples_lights && lit, lit ? "--light-sampling" : "there is no light"};
  needs["bsdf_emission"] = {sampling != LightSampling::light && lit, lit ? "--light-sampling" : "there is no light"};
  needs["uniform_scatter"] = {sampling == LightSampling::hemisphere, "--light-sampling"};
  needs["raycast"] = {settings.raycast, "--integrator"};
  const std::uint64_t light_count = census.places() + census.distant;
  const bool each_light = settings.raycast && lit && light_count <= kMostLightSamples;
  needs["each_light"] = {each_light, settings.raycast ? fmt::format("{} lights", light_count) : "--integrator"};
  if (each_light) needs["light_tree"] = {false, "each light is sampled"};
  if (settings.raycast) use_raycast(needs);
  light_samples_ = each_light ? std::uint32_t(light_count) : needs["next_event"].on ? settings.light_samples : 1;
  needs["whitted"] = {settings.whitted, "--integrator"};
  needs["fixed_roulette"] = {settings.roulette > 0, "--roulette"};
  needs["pixel_filter"] = {!settings.filter.is_pixel_box(), "--filter"};
  const std::string camera = fmt::format("camera '{}'", settings.camera.name);
  needs["orthographic"] = {settings.camera.projection == Projection::orthographic, camera};
  needs["panorama"] = {settings.camera.projection == Projection::panorama, camera};
  needs["lens"] = {lens_radius_m(settings.camera) > 0, camera};
  needs["coverage"] = {settings.transparent, "--transparent"};
  scatter_bounds_ = scatter_bounds(settings.aovs, settings.depth_series);
  for (const LayerInfo& layer : layers()) {
    const bool asked = std::ranges::find(settings.aovs, layer.name) != settings.aovs.end();
    for (const std::string_view name : layer.features) {
      Need& need = needs.try_emplace(std::string(name), Need{false, "--aov"}).first->second;
      need.on = need.on || asked;
    }
  }
  if (!settings.depth_series.empty()) needs["scattered"] = {true, "--depth-series"};
  mattes_ = std::make_shared<const Mattes>(make_mattes(scene, settings.aovs));
  if (needs["texture_place"].on && !needs["uv"].on) needs["uv"] = {true, "--aov"};

  const auto add = [&](const char* kind, const char* name, int channels) {
    const auto need = needs.find(name);
    if (need == needs.end()) throw InternalError(fmt::format("nobody decides feature '{}'", name));
    ledger_.push_back({kind, name, channels, need->second.on, need->second.who});
  };
#define EK_LOBE(name, bit) add("lobe", #name, 0);
#define EK_LIGHT(name, bit) add("light", #name, 0);
#define EK_SHAPE_KIND(name, bit) add("shape", #name, 0);
#define EK_OPTION(name) add("option", #name, 0);
  light_groups_ = scene.light_groups;
  environment_light_group_ = scene.environment_light_group;
  const int EK_SCATTER_BINS = int(scatter_bounds_.size()) + 1, EK_LIGHT_GROUPS = int(light_groups_.size());
#define EK_AOV(name, channels) add("layer", #name, channels);
#include "shared/features.def"
}

bool Features::has(const std::string& name) const {
  const auto found = std::find_if(ledger_.begin(), ledger_.end(), [&](const Feature& f) { return f.name == name; });
  if (found == ledger_.end()) throw InternalError(fmt::format("no feature '{}'", name));
  return found->on;
}

void Features::set_two_level(bool on, const std::string& why) {
  const auto found = std::ranges::find(ledger_, std::string("instance"), &Feature::name);
  found->on = on;
  found->who = why;
}

std::map<std::string, std::string> Features::defines() const {
  std::map<std::string, std::string> defines;
  for (const Feature& feature : ledger_) defines["EK_HAS_" + feature.name] = feature.on ? "1" : "0";
  if (has("scattered")) {
    std::uint32_t bounds = 0;
    for (const std::uint32_t bound : scatter_bounds_) bounds |= 1U << bound;
    defines["EK_SCATTER_BOUNDS"] = fmt::format("{}u", bounds);
    defines["EK_SCATTER_BINS"] = std::to_string(scatter_bounds_.size() + 1);
  }
  if (has("light_group")) {
    defines["EK_LIGHT_GROUPS"] = std::to_string(light_groups_.size());
    defines["EK_ENVIRONMENT_GROUP"] = fmt::format("{}u", environment_light_group_);
  }
  defines["EK_LIGHT_SAMPLES"] = std::to_string(light_samples_);
  if (formula_count_ > 0) defines["EK_FORMULA_COUNT"] = std::to_string(formula_count_);
  return defines;
}

std::vector<std::string> Features::film_channels() const {
  const std::map<std::string, std::vector<std::string>> names = {
      {"albedo", {"albedo.R", "albedo.G", "albedo.B"}},
      {"normal", {"normal.X", "normal.Y", "normal.Z"}},
      {"geometric_normal", {"geometric_normal.X", "geometric_normal.Y", "geometric_normal.Z"}},
      {"depth", {"depth.Z"}},
      {"position", {"position.X", "position.Y", "position.Z"}},
      {"texture_place", {"uv.U", "uv.V"}},
      {"hits", {"hits"}},
      {"id", {"id"}},
      {"material_id", {"material_id"}},
      {"coverage", {"A"}},
      {"scattered", scatter_channels(scatter_bounds_)},
      {"light_group", light_group_channels(light_groups_)},
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
             EK_HAS_bsdf_emission = features.has("bsdf_emission"), EK_HAS_absorption = features.has("absorption"),
             EK_HAS_opacity = features.has("opacity"), EK_HAS_light_tree = features.has("light_tree"),
             EK_HAS_area = features.has("area"), EK_HAS_instance = features.has("instance"),
             EK_HAS_nested_media = features.has("nested_media"), EK_HAS_light_group = features.has("light_group"),
             EK_HAS_scattered = features.has("scattered");
  PathStateLayout layout;
  const auto add = [&](const char* name, std::uint32_t words) {
    if (words > 0) layout.field[name] = layout.words;
    layout.words += words;
  };
#define EK_FIELD(type, name, needed) add(#name, std::uint32_t(EK_WORDS_##type * (needed)));
#define EK_SHADOW(type, name, needed) add("shadow_" #name, std::uint32_t(EK_WORDS_##type * (needed)) * features.light_samples());
#include "shared/path_state.def"
  return layout;
}

}  // namespace eikon
