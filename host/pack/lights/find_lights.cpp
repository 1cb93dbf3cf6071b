// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/find_lights.h"

#include <limits>
#include <numbers>
#include <utility>

#include "pack/lights/light_counts.h"
#include "pack/lights/pack_environment.h"
#include "pack/pack_parts.h"
#include "scene/emission.h"
#include "scene/shape_area.h"

namespace eikon {
namespace {

constexpr double kPi = std::numbers::pi;

// Light sampling derives a light's normal in floats. A needle for which that fails is not sampled.
// Its light_pdf_m2 stays 0, so that emission found by scattered rays counts in full.
bool can_be_sampled(const Triangle& t, const glm::dvec3& normal) {
  const auto [p0, p1, p2] = corners_of(t);
  const glm::dvec3 rounded(glm::cross(p1 - p0, p2 - p0));
  return glm::length(glm::normalize(rounded) - glm::normalize(normal)) < 0x1p-14;  // false for NaN
}

constexpr double kSlackOfPairs = 0x1p-20;  // of parallelogram_of for world space, which rounds more than the file

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

LightMoments moments_of(const Parallelogram& quad, const glm::dvec3& normal) {
  const glm::dvec3 p0(quad.p0), p1(quad.p1), p2(quad.p2);
  LightMoments m;
  m.centroid = 0.5 * (p1 + p2);
  m.variance = (glm::dot(p1 - p0, p1 - p0) + glm::dot(p2 - p0, p2 - p0)) / 12;
  m.mean_direction = glm::normalize(normal);
  return m;
}

/// The moments of a shape from its box, as if it were closed, and its surface as far from the
/// centroid as a sphere's.
LightMoments moments_of_shape(const Triangle& box) {
  const glm::dvec3 lo(box.p0_x, box.p0_y, box.p0_z), hi(box.p1_x, box.p1_y, box.p1_z);
  LightMoments m;
  m.centroid = 0.5 * (lo + hi);
  m.variance = glm::dot(hi - lo, hi - lo) / 12;
  return m;
}

std::uint32_t group_of(const Triangle& t) { return t.flags >> EK_TRIANGLE_GROUP_SHIFT & (EK_LIGHT_GROUPS_MOST - 1); }
std::uint32_t group_flag(std::uint32_t group) { return group << EK_LIGHT_GROUP_SHIFT; }
void set_emission(Light& light, const glm::vec3& emission) {
  light.emission_r = emission.x, light.emission_g = emission.y, light.emission_b = emission.z;
}

}  // namespace

glm::dvec3 middle_of(const Light& light) {
  const glm::dvec3 p0(light.p0_x, light.p0_y, light.p0_z), p1(light.p1_x, light.p1_y, light.p1_z),
      p2(light.p2_x, light.p2_y, light.p2_z);
  return (light.flags & EK_LIGHT_QUAD) != 0 ? 0.5 * (p1 + p2) : (p0 + p1 + p2) / 3.0;
}

double section_m2(const Bounds& bounds) {
  const double radius_m = bounds.empty() ? 0 : 0.5 * glm::length(bounds.hi - bounds.lo);
  return radius_m > 0 ? kPi * radius_m * radius_m : 1;
}

double scale_of_distant(double local, double distant) { return local > 0 && distant > local ? local / distant : 1; }

void share_by_flux(double probability, std::vector<PackedLight>& summary) {
  double flux = 0;
  for (const PackedLight& light : summary) flux += light_kind(light.kind).distant ? 0 : light.flux;
  for (PackedLight& light : summary)
    if (!light_kind(light.kind).distant) light.probability = probability * (light.flux / flux);
}

LightFinder::LightFinder(const Scene& scene, const Features& features, const Settings& settings, PackedScene& packed,
                         std::function<void(const FoundLight&)> take)
    : scene_(scene),
      environment_(settings.environment),
      packed_(packed),
      textures_(packed),
      take_(std::move(take)),
      has_quads_(features.has(Feature::quad_light)),
      has_one_(features.has(Feature::one_light)) {}

void LightFinder::find_others() {
  find_shapes();
  for (std::size_t i = 0; i < scene_.lights.size(); ++i) find_punctual(i);
  find_environment();
}

std::size_t LightFinder::find_triangles(bool more_follow) {
  const std::size_t count = packed_.triangle_count();
  for (std::size_t i = 0; i < count; ++i) {
    if (more_follow && i + 1 == count) return i;
    if (has_quads_ && find_quad(i)) {
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
    take_surface(light, t.material, area, radiance, moments_of(t, normal));
  }
  return count;
}

/// Adds triangles i and i + 1 as one light, if they form a parallelogram that emits evenly.
/// Returns false if not.
bool LightFinder::find_quad(std::size_t i) {
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
  take_surface(light, a.material, area, mean(material.emission), moments_of(*quad, normal));
  return true;
}

void LightFinder::find_shapes() {
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
    take_surface(light, t.material, parts[0] + parts[1] + parts[2], radiance, moments_of_shape(t));
  }
}

/// radiance: mean over the surface
void LightFinder::take_surface(Light light, std::uint32_t material_index, double area, double radiance,
                               LightMoments moments) {
  const Material& material = scene_.materials[material_index];
  set_emission(light, material.emission);
  light.flags |= material.double_sided ? EK_LIGHT_DOUBLE_SIDED : 0;
  constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  summary_of_.resize(scene_.materials.size(), none);
  std::uint32_t& entry = summary_of_[material_index];
  if (entry == none) entry = summarise({.kind = LightKind::area, .name = material.name});
  const double flux = kPi * area * radiance * (material.double_sided ? 2 : 1);
  if (material.double_sided) moments.mean_direction = glm::dvec3(0);
  take_({.light = light, .power = flux, .area_m2 = area, .summary = entry, .moments = moments});
  PackedLight& summary = packed_.light_summary[entry];
  summary.strength = (summary.strength * summary.area_m2 + radiance * area) / (summary.area_m2 + area);
  summary.flux += flux;
  summary.area_m2 += area;
}

void LightFinder::find_punctual(std::size_t index) {
  const PunctualLight& source = scene_.lights[index];
  const double intensity = mean(source.intensity);
  if (!(intensity > 0)) return;
  PackedPunctualLight packed = pack_punctual(source, intensity, section_m2(packed_.bounds));
  if (!(packed.flux > 0)) return;  // a cone too narrow for any direction
  packed.record.kind = kind_word(source.kind);
  packed.record.flags = group_flag(source.light_group);
  set_emission(packed.record, source.intensity);
  if (scene_.moves_lights) packed.record.triangle = std::uint32_t(packed_.light_poses.size() + 1);
  for (const auto& pose : scene_.poses)
    if (scene_.moves_lights)
      packed_.light_poses.push_back(pack_punctual(pose->lights[index], intensity, section_m2(packed_.bounds)).record);
  const PackedLight summary{.kind = source.kind, .name = source.name, .flux = packed.flux, .strength = intensity};
  const bool distant = light_kind(source.kind).distant;
  take_({.light = packed.record,
         .power = packed.flux,
         .summary = summarise(summary),
         .distant = distant,
         .moments = packed.moments});
}

void LightFinder::find_environment() {
  Light light{};
  light.flags = group_flag(scene_.environment_light_group);
  if (environment_.map) {
    const double integral = pack_environment_map(environment_, packed_);
    if (!(integral > 0)) return;
    take_distant(light, {.kind = LightKind::environment_map,
                         .name = environment_.map->name,
                         .flux = integral * section_m2(packed_.bounds),
                         .strength = integral / (4 * kPi)});
    return;
  }
  const double radiance = mean(environment_.radiance);
  if (!(radiance > 0)) return;
  take_distant(
      light,
      {.kind = LightKind::environment, .flux = 4 * kPi * radiance * section_m2(packed_.bounds), .strength = radiance});
}

void LightFinder::take_distant(Light light, const PackedLight& summary) {
  light.kind = kind_word(summary.kind);
  take_({.light = light, .power = summary.flux, .summary = summarise(summary), .distant = true});
}

std::uint32_t LightFinder::summarise(const PackedLight& light) {
  packed_.light_summary.push_back(light);
  return std::uint32_t(packed_.light_summary.size() - 1);
}

}  // namespace eikon
