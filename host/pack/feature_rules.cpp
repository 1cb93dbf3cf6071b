// SPDX-License-Identifier: Apache-2.0
#include "pack/feature_rules.h"

#include <algorithm>
#include <fmt/format.h>
#include <unordered_set>

#include "film/layers.h"
#include "pack/geometry/solid_openings.h"
#include "pack/lights/light_kind.h"
#include "pack/lights/pack_light_paths.h"
#include "pack/materials/material_parameters.h"
#include "pack/materials/material_traits.h"

namespace eikon {
namespace {

// Rules about materials

template <class Predicate>
Need if_some_material(const SceneFacts& facts, const char* otherwise, Predicate predicate) {
  for (const Material* m : facts.materials)
    if (predicate(*m)) return {true, fmt::format("material '{}'", m->name)};
  return {false, otherwise};
}

template <class Predicate>
Need if_some_primitive(const SceneFacts& facts, const char* otherwise, Predicate predicate) {
  for (const Mesh* mesh : facts.meshes)
    if (std::ranges::any_of(mesh->primitives, predicate)) return {true, fmt::format("mesh '{}'", mesh->name)};
  return {false, otherwise};
}

template <Feature feature>
Need texture_rule(const SceneFacts& facts) {
  return if_some_material(facts, "no such texture", [](const Material& m) {
    bool has = false;
    const auto check = [&](auto parameter, std::size_t) {
      if constexpr (std::is_same_v<decltype(parameter), MaterialTexture>)
        has = has || (parameter.feature == feature && m.*parameter.of);
    };
    ParametersOf<MaterialRecord>::visit(check);
    ParametersOf<MaterialExtension>::visit(check);
    ParametersOf<MaterialDetail>::visit(check);
    return has;
  });
}

bool is_raycast(const SceneFacts& facts) { return facts.settings.integrator == Integrator::raycast; }

/// raycast.h gives every surface Blinn's highlights, so that its programs have the code of one
/// lobe.
template <Lobe lobe>
Need lobe_rule(const SceneFacts& facts) {
  if (is_raycast(facts)) return {lobe == Lobe::phong, "--integrator"};
  return if_some_material(facts, "no material", [](const Material& m) { return lobe_of(m) == lobe; });
}

bool is_coated(const Material& m) { return m.clearcoat > 0; }
bool has_sheen(const Material& m) { return m.sheen_color != glm::vec3(0); }
bool has_microfacets(const Material& m) { return has_trait(m, EK_TRAIT_MICROFACETS); }
bool is_anisotropic(const Material& m) { return m.anisotropy > 0 && has_microfacets(m); }
bool is_translucent(const Material& m) { return m.diffuse_transmission > 0 && has_trait(m, EK_TRAIT_TRANSMITS); }
bool disperses(const Material& m) { return m.dispersion > 0 && is_solid(m) && m.ior > 1; }
bool has_solid_specular(const Material& m) {
  return is_solid(m) &&
         (m.specular != 1 || m.specular_color != glm::vec3(1) || m.specular_texture || m.specular_color_texture);
}
bool has_thin_film(const Material& m) { return m.iridescence > 0 && has_microfacets(m); }

/// Returns true if the materials differ in some parameter of the record.
template <class Record>
bool differ(const Material& a, const Material& b) {
  bool found = false;
  ParametersOf<Record>::visit([&](auto parameter, std::size_t) {
    if constexpr (std::is_same_v<decltype(parameter), MaterialTexture>)
      found = found || (a.*parameter.of).has_value() != (b.*parameter.of).has_value();
    else
      found = found || a.*parameter != b.*parameter;
  });
  return found;
}

Need material_extension(const SceneFacts& facts) {
  return if_some_material(facts, "no specular, transmission, volume or table", [](const Material& m) {
    if (has_trait(m, EK_TRAIT_TRANSMITS) || lobe_of(m) == Lobe::measured) return true;
    Material usual;
    usual.transmission = m.transmission;  // of metal, where it does not count
    usual.transmission_texture = m.transmission_texture;
    if (has_trait(m, EK_TRAIT_LAMBERT)) {  // nor do these
      usual.specular = m.specular;
      usual.specular_color = m.specular_color;
    }
    return differ<MaterialExtension>(m, usual);
  });
}

Need material_detail(const SceneFacts& facts) {
  if (is_raycast(facts)) return {true, "--integrator"};
  return if_some_material(
      facts, "no clearcoat, sheen, diffuse transmission, anisotropy, dispersion, iridescence, conductor or highlight",
      [](const Material& m) {
        return is_coated(m) || has_sheen(m) || is_translucent(m) || is_anisotropic(m) || disperses(m) ||
               has_thin_film(m) || (!m.unlit && m.lobe && m.lobe != Lobe::measured);
      });
}

Need energy_compensation(const SceneFacts& facts) {
  if (!facts.settings.energy_compensation) return {false, "--energy-compensation"};
  return if_some_material(facts, "no rough metal or glass", [](const Material& m) {
    return (m.roughness > 0 || m.metallic_roughness_texture) && has_microfacets(m) &&
           (has_trait(m, EK_TRAIT_METAL | EK_TRAIT_TRANSMITS) || m.metallic > 0);
  });
}

Need open_solid(const SceneFacts& facts) {
  const std::optional<std::uint32_t> found = SolidOpenings(facts.scene).first_material(facts.scene);
  if (!found) return {false, "no solid has an opening"};
  return {true, fmt::format("material '{}'", facts.scene.materials[*found].name)};
}

Need culling(const SceneFacts& facts) {
  if (facts.settings.culling == Culling::none) return {false, "--cull"};
  return if_some_material(facts, "every surface is double-sided or transmits light", is_single_sided);
}

// Rules about geometry

template <ShapeKind kind>
Need shape_rule(const SceneFacts& facts) {
  const auto found = std::ranges::find(facts.scene.shapes, kind, &Shape::kind);
  if (found == facts.scene.shapes.end()) return {false, "no such shape"};
  return {true, fmt::format("node '{}'", found->name)};
}

template <std::uint32_t of_class>
Need shading_class_rule(const SceneFacts& facts) {
  const Scene& scene = facts.scene;
  Need need = if_some_primitive(facts, "no such surface", [&](const Primitive& primitive) {
    return shading_class(scene.materials[primitive.material], &primitive) == of_class;
  });
  for (const Shape& each : scene.shapes)
    if (!need.on && shading_class(scene.materials[each.material], nullptr) == of_class)
      need = {true, fmt::format("node '{}'", each.name)};
  return need;
}

/// Layers that --aov asks for need the sums that they are made of.
bool is_asked_for(const SceneFacts& facts, FilmSum sum) { return needs_sum(facts.settings.aovs, sum); }

Need uv(const SceneFacts& facts) {
  Need need = if_some_material(facts, "no texture", [](const Material& m) { return !textures_of(m).empty(); });
  if (!need.on && is_asked_for(facts, FilmSum::texcoord)) need = {true, "--aov"};
  return need;
}

// Rules about light and about the settings

template <LightKind kind>
Need light_rule(const SceneFacts& facts) {
  return light_kind(kind).need(facts.scene, facts.settings);
}

/// raycast.h samples each light at every vertex, if they are few enough.
bool samples_each_light(const SceneFacts& facts) {
  return is_raycast(facts) && facts.is_lit && facts.lights.count() <= kMaxLightSamples;
}

Need light_tree(const SceneFacts& facts) {
  if (samples_each_light(facts)) return {false, "each light is sampled"};
  return {facts.lights.wants_tree(), fmt::format("{} lights that have a place", facts.lights.places())};
}

/// Light paths go from lights that have a place or a direction to surfaces that reflect or refract
/// exactly or nearly.
Need light_paths(const SceneFacts& facts) {
  const Settings& settings = facts.settings;
  if (settings.light_path_count == 0) return {false, "--light-paths"};
  if (settings.integrator != Integrator::path) return {false, "--integrator"};
  if (settings.light_sampling != LightSampling::mis) return {false, "--light-sampling"};
  if (moves(facts.scene, settings)) return {false, "--shutter"};
  // Triangles have room for the number of their light.
  if (facts.lights.places() >= (1U << (32 - EK_TRIANGLE_LIGHT_SHIFT))) return {false, "there are too many lights"};
  Need need = if_some_material(facts, "nothing reflects or refracts nearly exactly", is_light_target);
  const bool has_local = facts.lights.places() > 0 || !facts.scene.lights.empty();
  if (need.on && !has_local && !(settings.environment.map && has_small_lights(*settings.environment.map)))
    return {false, "there is no light that paths start from"};
  return need;
}

/// Photons come from light paths.
Need merging(const SceneFacts& facts) {
  if (!facts.settings.merges_caustics) return {false, "--caustics"};
  return light_paths(facts);
}

/// needed: by the way of light sampling, if there is light
Need light_sampling_rule(const SceneFacts& facts, bool needed) {
  return {needed && facts.is_lit, facts.is_lit ? "--light-sampling" : "there is no light"};
}

Need camera_rule(const SceneFacts& facts, bool needed) {
  return {needed, fmt::format("camera '{}'", facts.settings.camera.name)};
}

template <FilmSum sum>
Need sum_rule(const SceneFacts& facts) {
  if (sum == FilmSum::coverage) return {facts.settings.transparent, "--transparent"};
  if (sum == FilmSum::bounce_bins && !facts.settings.depth_series.empty()) return {true, "--depth-series"};
  return {is_asked_for(facts, sum), "--aov"};
}

constexpr bool kUnlessRaycast = true;  // for features that raycast.h leaves out of every material

/// The rule by which one feature is decided. It has one of four forms:
///   need       a function gives the decision and its reason
///   material   some material needs it, or else `text` says why none does
///   primitive  some primitive of a mesh needs it, or else `text` says why none does
///   asked      the scene and the settings decide; `text` names the flag, or the reason
struct Rule {
  constexpr Rule(Feature of, Need (*by)(const SceneFacts&), bool not_raycast = false)
      : feature(of), unless_raycast(not_raycast), need(by) {}
  constexpr Rule(Feature of, const char* otherwise, bool (*by)(const Material&), bool not_raycast = false)
      : feature(of), unless_raycast(not_raycast), text(otherwise), material(by) {}
  constexpr Rule(Feature of, const char* otherwise, bool (*by)(const Primitive&))
      : feature(of), text(otherwise), primitive(by) {}
  constexpr Rule(Feature of, const char* flag, bool (*by)(const SceneFacts&)) : feature(of), text(flag), asked(by) {}

  [[nodiscard]] Need operator()(const SceneFacts& facts) const {
    if (unless_raycast && is_raycast(facts)) return {false, "--integrator"};
    if (material != nullptr) return if_some_material(facts, text, material);
    if (primitive != nullptr) return if_some_primitive(facts, text, primitive);
    return asked != nullptr ? Need{asked(facts), text} : need(facts);
  }

  Feature feature;
  bool unless_raycast = false;
  const char* text = "";
  Need (*need)(const SceneFacts&) = nullptr;
  bool (*material)(const Material&) = nullptr;
  bool (*primitive)(const Primitive&) = nullptr;
  bool (*asked)(const SceneFacts&) = nullptr;
};

constexpr Rule kRules[] = {
#define EK_LOBE(name, bit, traits) {Feature::name, lobe_rule<Lobe::name>},
#define EK_LIGHT(name, bit) {Feature::name, light_rule<LightKind::name>},
#define EK_SHAPE_KIND(name, bit) {Feature::name, shape_rule<ShapeKind::name>},
#include "shared/features.def"
    {Feature::shape,
     [](const SceneFacts& f) -> Need {
       if (f.scene.shapes.empty()) return {false, "no shape"};
       return {true, fmt::format("node '{}'", f.scene.shapes.front().name)};
     }},
    {Feature::instance, "every mesh is stored for each of its instances", [](const SceneFacts&) { return false; }},
    {Feature::flat_lambert_hits, shading_class_rule<SHADING_FLAT_LAMBERT>},
    {Feature::opaque_hits, shading_class_rule<SHADING_OPAQUE>},
    {Feature::transmissive_hits, shading_class_rule<SHADING_TRANSMISSIVE>},
    {Feature::vertex_normal, "no mesh has normals", [](const Primitive& p) { return !p.normals_object.empty(); }},
    {Feature::uv, uv},
    {Feature::uv1, "no texture is placed by TEXCOORD_1",
     [](const Material& m) {
       return std::ranges::any_of(textures_of(m), [](const TextureUse& use) { return use.texture->uv_set == 1; });
     }},
    {Feature::vertex_color, "no mesh has colours", [](const Primitive& p) { return !p.colors.empty(); }},
    {Feature::base_color_texture, texture_rule<Feature::base_color_texture>},
    {Feature::metallic_roughness_texture, texture_rule<Feature::metallic_roughness_texture>},
    {Feature::normal_texture, texture_rule<Feature::normal_texture>},
    {Feature::emissive_texture, texture_rule<Feature::emissive_texture>},
    {Feature::transmission_texture, texture_rule<Feature::transmission_texture>},
    {Feature::specular_texture, texture_rule<Feature::specular_texture>},
    {Feature::solid_specular, "no solid has KHR_materials_specular", has_solid_specular, kUnlessRaycast},
    {Feature::material_extension, material_extension},
    {Feature::material_detail, material_detail},
    {Feature::diffuse_transmission, "nothing scatters light that passes it", is_translucent, kUnlessRaycast},
    {Feature::diffuse_transmission_texture, texture_rule<Feature::diffuse_transmission_texture>, kUnlessRaycast},
    {Feature::anisotropy, "no anisotropy", is_anisotropic, kUnlessRaycast},
    {Feature::anisotropy_texture, texture_rule<Feature::anisotropy_texture>},
    {Feature::dispersion, "no solid's index disperses", disperses, kUnlessRaycast},
    {Feature::tangent, "no normal map or anisotropy",
     [](const Material& m) { return m.normal_texture || m.clearcoat_normal_texture || is_anisotropic(m); }},
    {Feature::clearcoat, "no clearcoat", is_coated},
    {Feature::clearcoat_texture, texture_rule<Feature::clearcoat_texture>},
    {Feature::clearcoat_normal, "every coat follows its material",
     [](const Material& m) { return is_coated(m) && (m.normal_texture || m.clearcoat_normal_texture); }},
    {Feature::sheen, "no sheen", has_sheen, kUnlessRaycast},
    {Feature::sheen_texture, texture_rule<Feature::sheen_texture>},
    {Feature::absorption, "no volume absorbs",
     [](const Material& m) {
       return is_solid(m) && m.attenuation_distance > 0 && m.attenuation_color != glm::vec3(1);
     }},
    // One solid with a priority is enough, because its own parts may overlap.
    {Feature::nested_media, "no solid says mediumPriority",
     [](const Material& m) { return is_solid(m) && m.medium_priority.has_value(); }},
    {Feature::iridescence, "no thin film", has_thin_film},
    {Feature::iridescence_texture, texture_rule<Feature::iridescence_texture>},
    {Feature::energy_compensation, energy_compensation},
    {Feature::opacity, "every material is opaque", [](const Material& m) { return m.alpha_mode != AlphaMode::opaque; }},
    {Feature::open_solid, open_solid, kUnlessRaycast},
    {Feature::culling, culling},
    {Feature::unlit, "no material is unlit", [](const Material& m) { return m.unlit; }},
    {Feature::one_light,
     [](const SceneFacts& f) {
       return Need{f.lights.is_one(), fmt::format("{} lights", f.lights.count())};
     }},
    {Feature::quad_light,
     [](const SceneFacts& f) {
       return Need{f.lights.pairs > 0, fmt::format("{} pairs of emissive triangles", f.lights.pairs)};
     }},
    {Feature::light_tree, light_tree},
    {Feature::next_event,
     [](const SceneFacts& f) { return light_sampling_rule(f, samples_lights(f.settings.light_sampling)); }},
    {Feature::bsdf_emission,
     [](const SceneFacts& f) { return light_sampling_rule(f, f.settings.light_sampling != LightSampling::light); }},
    {Feature::uniform_scatter, "--light-sampling",
     [](const SceneFacts& f) { return f.settings.light_sampling == LightSampling::hemisphere; }},
    {Feature::raycast, "--integrator", is_raycast},
    {Feature::each_light,
     [](const SceneFacts& f) {
       return Need{samples_each_light(f), is_raycast(f) ? fmt::format("{} lights", f.lights.count()) : "--integrator"};
     }},
    {Feature::whitted, "--integrator",
     [](const SceneFacts& f) { return f.settings.integrator == Integrator::whitted; }},
    {Feature::guiding, "--guiding; the pilot of a render decides",
     [](const SceneFacts& f) { return f.settings.guide != nullptr; }},
    {Feature::path_log, "the program of a pilot has it", [](const SceneFacts&) { return false; }},
    {Feature::light_paths, light_paths},
    {Feature::merging, merging},
    {Feature::fixed_roulette, "--roulette", [](const SceneFacts& f) { return f.settings.roulette_survival > 0; }},
    {Feature::pixel_filter, "--filter", [](const SceneFacts& f) { return !f.settings.filter.is_pixel_box(); }},
    {Feature::orthographic,
     [](const SceneFacts& f) { return camera_rule(f, f.settings.camera.projection == Projection::orthographic); }},
    {Feature::panorama,
     [](const SceneFacts& f) { return camera_rule(f, f.settings.camera.projection == Projection::panorama); }},
    {Feature::lens, [](const SceneFacts& f) { return camera_rule(f, lens_radius_m(f.settings.camera) > 0); }},
    {Feature::camera_motion, [](const SceneFacts& f) { return camera_rule(f, !f.settings.camera_poses.empty()); }},
    {Feature::moving_surface, "--shutter", [](const SceneFacts& f) { return f.scene.moves_surfaces; }},
    {Feature::moving_light, "--shutter", [](const SceneFacts& f) { return f.scene.moves_lights; }},
    {Feature::matte_object, "--aov", [](const SceneFacts& f) { return is_asked_for(f, FilmSum::matte_object); }},
    {Feature::matte_material, "--aov", [](const SceneFacts& f) { return is_asked_for(f, FilmSum::matte_material); }},
#define EK_AOV(name, channels) {Feature::name, sum_rule<FilmSum::name>},
#include "shared/features.def"
};

constexpr bool every_feature_has_its_rule() {
  std::size_t next = 0;
  bool in_order = true;
#define EK_FEATURE(name) in_order = in_order && next < std::size(kRules) && kRules[next++].feature == Feature::name;
#include "shared/features.def"
  return in_order && next == std::size(kRules);
}
static_assert(every_feature_has_its_rule(), "kRules has one row for each feature, in the order of features.def");

}  // namespace

SceneFacts::SceneFacts(const Scene& of_scene, const Settings& with_settings)
    : scene(of_scene), settings(with_settings), lights(count_lights(of_scene, with_settings)) {
  std::unordered_set<const void*> known;
  const auto add = [&](auto& list, auto* item) {
    if (known.insert(item).second) list.push_back(item);
  };
  for (const Node& node : scene.nodes) {
    const Mesh& mesh = scene.meshes[node.mesh];
    add(meshes, &mesh);
    for (const Primitive& primitive : mesh.primitives) add(materials, &scene.materials[primitive.material]);
  }
  for (const Shape& shape : scene.shapes) add(materials, &scene.materials[shape.material]);
#define EK_LIGHT(name, bit) is_lit = is_lit || light_kind(LightKind::name).need(scene, settings).on;
#include "shared/features.def"
}

Need need_of(Feature feature, const SceneFacts& facts) { return kRules[std::size_t(feature)](facts); }

}  // namespace eikon
