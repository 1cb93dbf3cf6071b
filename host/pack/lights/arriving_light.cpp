// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/arriving_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "scene/emission.h"
#include "scene/shape_area.h"
#include "pack/geometry/seen_points.h"

namespace eikon {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kEmitterSamples = 1024;
constexpr double kVisibleEmission = 1e-3;  // a point that emits less is there to be lit

/// A small piece of an emissive surface.
struct Emitter {
  glm::dvec3 position{};
  glm::dvec3 normal{};   // unit; zero: it shines the same way in every direction
  double intensity = 0;  // along the normal, W / sr
  bool both_sides = false;
};

double area_of(const WorldTriangle& t) {
  return 0.5 * glm::length(glm::cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]));
}

/// Points spread evenly over the power of all emissive triangles, textures left out: the additive
/// recurrence of Roberts [2018] places them within triangles.
std::vector<Emitter> sampled_triangles(const Scene& scene) {
  const auto strength = [&](const WorldTriangle& t) {
    return t.primitive == nullptr ? 0 : mean(scene.materials[t.material].emission) * area_of(t);
  };
  const auto each_emissive = [&](const auto& visit) {
    for_each_triangle(scene, [&](const WorldTriangle& t) {
      if (emits(scene.materials[t.material])) visit(t, strength(t));
    });
  };
  double total = 0;
  each_emissive([&](const WorldTriangle&, double power) { total += power; });
  std::vector<Emitter> emitters;
  if (!(total > 0 && total < kInfinity)) return emitters;
  double before = 0;
  int next = 0;
  each_emissive([&](const WorldTriangle& t, double power) {
    before += power;
    for (; next < kEmitterSamples && (next + 0.5) * total <= before * kEmitterSamples; ++next) {
      double u = std::fmod(0.5 + next * 0.7548776662466927, 1.0), v = std::fmod(0.5 + next * 0.5698402909980532, 1.0);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Material& material = scene.materials[t.material];
      const double area = total / kEmitterSamples / mean(material.emission);
      emitters.push_back({.position = t.corners[0] * (1 - u - v) + t.corners[1] * u + t.corners[2] * v,
                          .normal = front_normal(t),
                          .intensity = area * emission_at(scene, t, u, v),
                          .both_sides = material.double_sided});
    }
  });
  return emitters;
}

/// Shapes shine from their middles, with the quarter of their surface that convex bodies show on
/// average.
void add_shapes(const Scene& scene, std::vector<Emitter>& emitters) {
  for (const Shape& shape : scene.shapes) {
    const Material& material = scene.materials[shape.material];
    if (!is_sampled_light(shape, material)) continue;
    const OwnShape own = own_shape(shape);
    double area = 0;
    for (const double part : part_areas_m2(shape.kind, own)) area += part;
    emitters.push_back({.position = own.center, .intensity = 0.25 * area * mean(material.emission)});
  }
}

double irradiance(const SeenPoint& point, const Emitter& emitter) {
  const glm::dvec3 way = emitter.position - point.position;
  const double d2 = glm::dot(way, way), distance = std::sqrt(d2);
  const double cos_here = glm::dot(way, point.normal) / distance;
  if (!(d2 > 0) || !(cos_here > 0)) return 0;
  if (emitter.normal == glm::dvec3(0)) return emitter.intensity * cos_here / d2;
  const double cos_there = -glm::dot(way, emitter.normal) / distance;
  const double sent = emitter.both_sides ? std::abs(cos_there) : std::max(cos_there, 0.0);
  return emitter.intensity * sent * cos_here / d2;
}

double irradiance(const SeenPoint& point, const PunctualLight& light) {
  const double intensity = mean(light.intensity);
  if (light.kind == LightKind::directional) return intensity * std::max(0.0, -glm::dot(light.direction, point.normal));
  const glm::dvec3 way = light.position - point.position;
  const double distance = glm::length(way);
  if (light.range_m > 0 && distance > light.range_m) return 0;
  if (light.kind == LightKind::spot && -glm::dot(way, light.direction) < std::cos(light.outer_cone_rad) * distance)
    return 0;
  return irradiance(point, Emitter{.position = light.position, .intensity = intensity});
}

}  // namespace

double arriving_light(const Scene& scene, const Settings& settings) {
  for (const Shape& shape : scene.shapes)
    if (const Material& m = scene.materials[shape.material]; emits(m) && !is_sampled_light(shape, m)) return kInfinity;
  std::vector<Emitter> emitters = sampled_triangles(scene);
  add_shapes(scene, emitters);
  std::erase_if(emitters, [](const Emitter& emitter) { return !(emitter.intensity > 0); });
  double sum = 0;
  std::size_t lit_by_others = 0;
  for (const SeenPoint& point : seen_points(scene, settings)) {
    if (point.unlit || point.emission > kVisibleEmission) continue;
    ++lit_by_others;
    double arriving = 0;
    for (const Emitter& emitter : emitters) arriving += irradiance(point, emitter);
    for (const PunctualLight& light : scene.lights) arriving += irradiance(point, light);
    sum += std::min(arriving / std::numbers::pi, 1.0);
  }
  return lit_by_others == 0 ? kInfinity : sum / double(lit_by_others);
}

}  // namespace eikon
