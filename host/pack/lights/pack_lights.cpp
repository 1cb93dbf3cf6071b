// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <numbers>

#include "core/error.h"
#include "pack/lights/emissive_texture.h"
#include "pack/lights/light_counts.h"
#include "pack/lights/light_table.h"
#include "pack/lights/light_tree.h"
#include "pack/lights/pack_light_paths.h"
#include "pack/materials/camera_medium.h"
#include "pack/lights/pack_environment.h"
#include "pack/pack_parts.h"
#include "scene/emission.h"
#include "scene/shape_area.h"

namespace eikon {
namespace {

constexpr double kPi = std::numbers::pi;

/// The value of Light.kind.
constexpr std::uint32_t kind_word(LightKind kind) { return std::uint32_t(kind); }

// Light sampling derives a light's normal in floats. A needle for which that fails is not sampled.
// Its light_pdf_m2 stays 0, so that emission found by scattered rays counts in full.
bool can_be_sampled(const Triangle& t, const glm::dvec3& normal) {
  const auto [p0, p1, p2] = corners_of(t);
  const glm::dvec3 rounded(glm::cross(p1 - p0, p2 - p0));
  return glm::length(glm::normalize(rounded) - glm::normalize(normal)) < 0x1p-14;  // false for NaN
}

/// A packed light, as the table and the summary need it.
struct Strength {
  double power = 0;         // selection is proportional to it
  bool distant = false;     // infinitely far away
  double area_m2 = 0;       // of a surface
  std::size_t summary = 0;  // entry of light_summary
  LightMoments moments{};   // without the power; of lights that have a place
};

/// The moments of a triangle that emits evenly to its front. normal: of any length
LightMoments moments_of(const Triangle& t, const glm::dvec3& normal) {
  const auto [p0, p1, p2] = corners_of(t);
  const glm::dvec3 a(p0), b(p1), c(p2);
  LightMoments m;
  m.centroid = (a + b + c) / 3.0;
  m.variance = (glm::dot(b - a, b - a) + glm::dot(c - b, c - b) + glm::dot(a - c, a - c)) / 36.0;
  m.mean_direction = glm::normalize(normal);
  return m;
}

constexpr double kSlackOfPairs = 0x1p-20;  // of parallelogram_of for world space, which rounds more than the file

/// The moments of a shape from its box, as if it were closed, and its surface as far from the
/// centroid as a sphere's.
LightMoments moments_of_shape(const Triangle& box) {
  const glm::dvec3 lo(box.p0_x, box.p0_y, box.p0_z), hi(box.p1_x, box.p1_y, box.p1_z);
  LightMoments m;
  m.centroid = 0.5 * (lo + hi);
  m.variance = glm::dot(hi - lo, hi - lo) / 12;
  return m;
}

class LightPacker {
 public:
  LightPacker(const Scene& scene, const Features& features, const Settings& settings, PackedScene& packed)
      : scene_(scene),
        environment_(settings.environment),
        packed_(packed),
        textures_(packed),
        has_tree_(features.has(Feature::light_tree)),
        has_quads_(features.has(Feature::quad_light)),
        has_one_(features.has(Feature::one_light)),
        each_(features.has(Feature::each_light)),
        has_light_paths_(features.has(Feature::light_paths)),
        has_media_(features.has(Feature::absorption) || features.has(Feature::nested_media)) {
    // A scene without extent has no sphere around it, and any area will do.
    if (!packed.bounds.empty()) radius_m_ = 0.5 * glm::length(packed.bounds.hi - packed.bounds.lo);
    section_m2_ = radius_m_ > 0 ? kPi * radius_m_ * radius_m_ : 1;
  }

  void pack() {
    add_triangles();
    add_shapes();
    for (std::size_t i = 0; i < scene_.lights.size(); ++i) add_punctual(i);
    add_environment();
    if (packed_.lights.empty()) return;
    if (has_one_ && packed_.lights.size() > 1) throw InternalError("more lights than were counted");
    // The flux of a distant light enters the whole scene, and most of it misses what is seen. So
    // distant lights together count no more than local lights do; otherwise a lamp under an open
    // sky would hardly ever be chosen.
    double local = 0, distant = 0;
    for (const Strength& s : strengths_) (s.distant ? distant : local) += s.power;
    const double scale = local > 0 && distant > local ? local / distant : 1;
    if (has_tree_) grow_tree();
    const std::size_t in_tree = packed_.tree_light_count;
    std::vector<double> powers;
    powers.reserve(strengths_.size() - in_tree + 1);
    if (has_tree_) powers.push_back(local);
    for (std::size_t i = in_tree; i < strengths_.size(); ++i)
      powers.push_back(strengths_[i].power * (strengths_[i].distant ? scale : 1));
    const LightTable table = build_light_table(powers);
    if (table.buckets.empty()) throw InternalError("lights without power");
    packed_.light_alias_table = table.buckets;
    for (std::size_t i = 0; i < in_tree; ++i) set_probability(i, table.probability[0]);
    if (in_tree > 0) share_of_tree(table.probability[0]);
    for (std::size_t i = in_tree; i < packed_.lights.size(); ++i) {
      const double probability = table.probability[has_tree_ ? i - in_tree + 1 : i];
      set_probability(i, each_ ? 1 : probability);
      packed_.light_summary[strengths_[i].summary].probability += probability;
    }
    if (has_light_paths_) start_light_paths();
  }

 private:
  /// Moves the lights that have a place to the front, in the order of the tree's leaves.
  void grow_tree() {
    std::vector<std::size_t> order;
    std::vector<LightMoments> placed;
    for (std::size_t i = 0; i < strengths_.size(); ++i) {
      if (strengths_[i].distant) continue;
      order.push_back(i);
      placed.push_back(strengths_[i].moments);
      placed.back().power = strengths_[i].power;
    }
    const LightTree tree = build_light_tree(placed);
    std::vector<std::size_t> from;
    for (const std::uint32_t leaf : tree.order) from.push_back(order[leaf]);
    for (std::size_t i = 0; i < strengths_.size(); ++i)
      if (strengths_[i].distant) from.push_back(i);
    DeviceVector<Light> lights;
    std::vector<Strength> strengths;
    for (const std::size_t i : from) {
      lights.push_back(packed_.lights[i]);
      strengths.push_back(strengths_[i]);
    }
    packed_.lights = std::move(lights);
    strengths_ = std::move(strengths);
    packed_.light_nodes = tree.nodes;
    packed_.light_scale = tree.scale;
    packed_.tree_light_count = std::uint32_t(placed.size());
    name_lights(packed_.tree_light_count);
  }

  /// Notes with the triangles and shapes which of the first lights they are.
  void name_lights(std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const Light& light = packed_.lights[i];
      if (light.kind != kind_word(LightKind::area) && light.kind != kind_word(LightKind::shape_light)) continue;
      packed_.triangles[light.triangle].flags |= i << EK_TRIANGLE_LIGHT_SHIFT;
      if ((light.flags & EK_LIGHT_QUAD) != 0)
        packed_.triangles[light.triangle + 1].flags |= i << EK_TRIANGLE_LIGHT_SHIFT;
    }
  }

  /// Prepares the start of light paths. None starts from shapes, from an environment without small lights, from lights of
  /// a limited range, whose light fades in a way that does not go on behind glass, or from within a solid that absorbs or
  /// has a priority. A plane without end may lie before any place that parallel light could start from.
  void start_light_paths() {
    bool endless = false;
    for (std::size_t i = packed_.triangle_count(); i < packed_.triangles.size(); ++i)
      endless = endless || is_endless_box(&packed_.triangles[i].p0_x);
    std::vector<LightPathSource> emitters(packed_.lights.size());
    for (std::size_t i = 0; i < emitters.size(); ++i) {
      const Light& light = packed_.lights[i];
      const double emission = mean({light.emission_r, light.emission_g, light.emission_b});
      LightPathSource& emitter = emitters[i];
      if (light.kind == kind_word(LightKind::area)) {
        emitter = {strengths_[i].power / kPi, 0, strengths_[i].area_m2, strengths_[i].moments.centroid};
      } else if (light.kind == kind_word(LightKind::directional)) {
        emitter.irradiance = endless ? 0 : emission;
      } else if (light.kind == kind_word(LightKind::environment_map)) {
        emitter.irradiance = endless || !has_small_lights(*environment_.map) ? 0 : strengths_[i].power / section_m2_;
      } else if ((light.kind == kind_word(LightKind::point) || light.kind == kind_word(LightKind::spot)) &&
                 std::isinf(light.p2_z)) {
        emitter.radiance_area = emission;
        emitter.place = {light.p0_x, light.p0_y, light.p0_z};
      }
      if (emitter.radiance_area > 0 && is_within_a_medium(emitter.place)) emitter.radiance_area = 0;
    }
    if (!has_tree_) name_lights(std::uint32_t(packed_.lights.size()));
    pack_light_paths(scene_.materials, emitters, packed_);
    for (std::size_t i = 0; i < packed_.emission_pdf.size(); ++i)
      if (packed_.lights[i].kind == kind_word(LightKind::environment_map))
        packed_.environment_emission = packed_.emission_pdf[i] / packed_.environment_probability;
  }

  /// The probability of a light in the tree depends on the shading point. The summary says its
  /// share of the energy.
  void share_of_tree(double probability) {
    double flux = 0;
    for (const PackedLight& light : packed_.light_summary) flux += light_kind(light.kind).distant ? 0 : light.flux;
    for (PackedLight& light : packed_.light_summary)
      if (!light_kind(light.kind).distant) light.probability = probability * (light.flux / flux);
  }

  void add(const Light& light, const Strength& strength) {
    packed_.lights.push_back(light);
    strengths_.push_back(strength);
  }

  void add_distant(Light light, const PackedLight& summary) {
    light.kind = kind_word(summary.kind);
    add(light, {.power = summary.flux, .distant = true, .summary = summarise(summary)});
  }

  std::size_t summarise(const PackedLight& light) {
    packed_.light_summary.push_back(light);
    return packed_.light_summary.size() - 1;
  }

  void add_triangles() {
    for (std::size_t i = 0; i < packed_.triangle_count(); ++i) {
      if (has_quads_ && add_quad(i)) {
        ++i;
        continue;
      }
      const Triangle& t = packed_.triangles[i];
      const Material& material = scene_.materials[t.material];
      if (!emits(material)) continue;
      const glm::dvec3 normal = triangle_normal(t);
      const double area = 0.5 * glm::length(normal);
      if (!(area > 0) || !can_be_sampled(t, normal)) continue;
      const double radiance = textures_.mean_emission(std::uint32_t(i));
      if (!(radiance > 0)) continue;
      Light light{};
      const auto [p0, p1, p2] = corners_of(t);
      set_corners(light, p0, p1, p2);
      light.kind = kind_word(LightKind::area);
      light.triangle = std::uint32_t(i);
      light.flags = group_flag(group_of(t));
      add_surface(light, t.material, area, radiance, moments_of(t, normal));
    }
  }

  /// Adds triangles i and i + 1 as one light, if they form a parallelogram that emits evenly.
  /// Returns false if not.
  bool add_quad(std::size_t i) {
    if (i + 1 >= packed_.triangle_count()) return false;
    const Triangle &a = packed_.triangles[i], &b = packed_.triangles[i + 1];
    const Material& material = scene_.materials[a.material];
    if (a.material != b.material || a.node != b.node || !emits_evenly(material)) return false;
    if (scene_.nodes[a.node].moves) return false;  // it may cease to be one
    if (((a.flags | b.flags) & EK_TRIANGLE_ALPHA_TESTED) != 0) return false;
    // Triangles that were counted as one light stay one, however much the transform of their node
    // rounds.
    const double slack = has_one_ ? std::numeric_limits<double>::infinity() : kSlackOfPairs;
    const std::optional<Parallelogram> quad = parallelogram_of(corners_of(a), corners_of(b), slack);
    if (!quad) return false;
    const glm::dvec3 normal = triangle_normal(a);
    const double area = glm::length(normal);
    if (!(area > 0) || !can_be_sampled(a, normal) || !can_be_sampled(b, triangle_normal(b))) return false;
    Light light{};
    set_corners(light, quad->p0, quad->p1, quad->p2);
    light.flags = EK_LIGHT_QUAD | group_flag(group_of(a));
    light.kind = kind_word(LightKind::area);
    light.triangle = std::uint32_t(i);
    const glm::dvec3 p0(quad->p0), p1(quad->p1), p2(quad->p2);
    LightMoments moments;
    moments.centroid = 0.5 * (p1 + p2);
    moments.variance = (glm::dot(p1 - p0, p1 - p0) + glm::dot(p2 - p0, p2 - p0)) / 12;
    moments.mean_direction = glm::normalize(normal);
    add_surface(light, a.material, area, mean(material.emission), moments);
    return true;
  }

  void add_shapes() {
    for (std::size_t i = packed_.triangle_count(); i < packed_.triangles.size(); ++i) {
      const Triangle& t = packed_.triangles[i];
      const std::size_t index = i - packed_.triangle_count();
      const Shape& shape = scene_.shapes[index];
      const Material& material = scene_.materials[t.material];
      if (!is_sampled_light(shape, material)) continue;
      const double radiance = textures_.mean_emission_of_whole_texture(std::uint32_t(i));
      if (!(radiance > 0)) continue;
      const std::array<double, 3> parts = part_areas_m2(shape.kind, own_shape(shape));
      ShapeRecord& record = packed_.shapes[index];
      record.part0_m2 = float(parts[0]), record.part1_m2 = float(parts[1]), record.part2_m2 = float(parts[2]);
      Light light{};
      light.kind = kind_word(LightKind::shape_light);
      light.triangle = std::uint32_t(i);
      light.flags = group_flag(group_of(t));
      add_surface(light, t.material, parts[0] + parts[1] + parts[2], radiance, moments_of_shape(t));
    }
  }

  /// radiance: mean over the surface
  void add_surface(Light light, std::uint32_t material_index, double area, double radiance, LightMoments moments) {
    const Material& material = scene_.materials[material_index];
    set_emission(light, material.emission);
    light.flags |= material.double_sided ? EK_LIGHT_DOUBLE_SIDED : 0;
    constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
    summary_of_.resize(scene_.materials.size(), none);
    std::size_t& entry = summary_of_[material_index];
    if (entry == none) entry = summarise({.kind = LightKind::area, .name = material.name});
    const double flux = kPi * area * radiance * (material.double_sided ? 2 : 1);
    if (material.double_sided) moments.mean_direction = glm::dvec3(0);
    add(light, {.power = flux, .area_m2 = area, .summary = entry, .moments = moments});
    PackedLight& summary = packed_.light_summary[entry];
    summary.strength = (summary.strength * summary.area_m2 + radiance * area) / (summary.area_m2 + area);
    summary.flux += flux;
    summary.area_m2 += area;
  }

  void add_punctual(std::size_t index) {
    const PunctualLight& source = scene_.lights[index];
    const double intensity = mean(source.intensity);
    if (!(intensity > 0)) return;
    PackedPunctualLight packed = pack_punctual(source, intensity, section_m2_);
    if (!(packed.flux > 0)) return;  // a cone too narrow for any direction
    packed.record.kind = kind_word(source.kind);
    packed.record.flags = group_flag(source.light_group);
    set_emission(packed.record, source.intensity);
    if (scene_.moves_lights) packed.record.triangle = std::uint32_t(packed_.light_poses.size() + 1);
    for (const auto& pose : scene_.poses)
      if (scene_.moves_lights)
        packed_.light_poses.push_back(pack_punctual(pose->lights[index], intensity, section_m2_).record);
    const PackedLight summary{.kind = source.kind, .name = source.name, .flux = packed.flux, .strength = intensity};
    add(packed.record, {.power = packed.flux,
                        .distant = light_kind(source.kind).distant,
                        .summary = summarise(summary),
                        .moments = packed.moments});
  }

  void add_environment() {
    Light light{};
    light.flags = group_flag(scene_.environment_light_group);
    if (environment_.map) {
      const double integral = pack_environment_map(environment_, packed_);
      if (!(integral > 0)) return;
      add_distant(light, {.kind = LightKind::environment_map,
                          .name = environment_.map->name,
                          .flux = integral * section_m2_,
                          .strength = integral / (4 * kPi)});
      return;
    }
    const double radiance = mean(environment_.radiance);
    if (!(radiance > 0)) return;
    add_distant(light,
                {.kind = LightKind::environment, .flux = 4 * kPi * radiance * section_m2_, .strength = radiance});
  }

  void set_probability(std::size_t i, double probability) {
    Light& light = packed_.lights[i];
    light.pdf_m2 = float(probability);
    if (light.kind == kind_word(LightKind::area)) {
      light.pdf_m2 = float(probability / strengths_[i].area_m2);
      packed_.triangles[light.triangle].light_pdf_m2 = light.pdf_m2;
      if ((light.flags & EK_LIGHT_QUAD) != 0) packed_.triangles[light.triangle + 1].light_pdf_m2 = light.pdf_m2;
    }
    if (light.kind == kind_word(LightKind::shape_light)) packed_.triangles[light.triangle].light_pdf_m2 = light.pdf_m2;
    const bool is_map = light.kind == kind_word(LightKind::environment_map);
    if (is_map || light.kind == kind_word(LightKind::environment)) packed_.environment_probability = light.pdf_m2;
    if (is_map)
      for (float4& texel : packed_.environment_texels) texel.w = float(probability * double(texel.w));
  }

  /// Looks at as many triangles as take about a second, and then says so of every place.
  [[nodiscard]] bool is_within_a_medium(const glm::dvec3& place) {
    if (!has_media_) return false;
    constexpr std::uint64_t kMostTriangles = 1U << 28;
    looked_at_ += packed_.triangles.size();
    return looked_at_ > kMostTriangles || camera_medium(packed_, place, {0, -1, 0}) != 0;
  }

  static std::uint32_t group_of(const Triangle& t) {
    return t.flags >> EK_TRIANGLE_GROUP_SHIFT & (EK_LIGHT_GROUPS_MOST - 1);
  }
  static std::uint32_t group_flag(std::uint32_t group) { return group << EK_LIGHT_GROUP_SHIFT; }
  static void set_emission(Light& light, const glm::vec3& emission) {
    light.emission_r = emission.x, light.emission_g = emission.y, light.emission_b = emission.z;
  }

  const Scene& scene_;
  const Environment& environment_;
  PackedScene& packed_;
  EmissiveTextures textures_;
  std::vector<std::size_t> summary_of_;  // by material
  double radius_m_ = 0;                  // of the sphere around the scene
  double section_m2_ = 1;                // of that sphere, which parallel light meets
  bool has_tree_, has_quads_, has_one_, each_, has_light_paths_, has_media_;
  std::uint64_t looked_at_ = 0;      // triangles, by is_within_a_medium
  std::vector<Strength> strengths_;  // as packed_.lights
};

}  // namespace

void pack_lights(const Scene& scene, const Features& features, const Settings& settings, PackedScene& packed) {
  LightPacker(scene, features, settings, packed).pack();
}

}  // namespace eikon
