// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/light_counts.h"

#include <algorithm>
#include <cmath>

#include "pack/lights/light_kind.h"
#include "pack/pack_parts.h"
#include "scene/emission.h"

namespace eikon {
namespace {

constexpr double kSlackOfFiles = 0x1p-22;  // for the rounding of the file's numbers; packing allows more, for its own

std::array<glm::vec3, 3> corners_of(const Primitive& primitive, std::size_t triangle) {
  const auto [a, b, c] = primitive.indices.triangle(triangle);
  return {primitive.positions_object[a], primitive.positions_object[b], primitive.positions_object[c]};
}

double diagonal(const Bounds& bounds) { return glm::length(bounds.hi - bounds.lo); }

void add_primitive(const Node& node, const Primitive& primitive, Bounds& bounds) {
  Bounds own;
  for (const glm::vec3& p : primitive.positions_object) grow(own, glm::dvec3(p));
  grow(bounds, node.world_from_object, own);
}

// True if the extent of all emissive meshes is small beside the extent of all meshes.
bool is_small(const Scene& scene) {
  Bounds lamp, all;
  for (const Node& node : scene.nodes)
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives) {
      add_primitive(node, primitive, all);
      if (emits(scene.materials[primitive.material])) add_primitive(node, primitive, lamp);
    }
  return diagonal(lamp) < 0.25 * diagonal(all);
}

}  // namespace

std::optional<Parallelogram> parallelogram_of(const std::array<glm::vec3, 3>& a, const std::array<glm::vec3, 3>& b,
                                              double slack) {
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec3 &own = a[i], &s = a[(i + 1) % 3], &t = a[(i + 2) % 3], &other = b[k];
      if (b[(k + 1) % 3] != t || b[(k + 2) % 3] != s || own == other) continue;
      const glm::dvec3 off = glm::dvec3(s) + glm::dvec3(t) - glm::dvec3(own) - glm::dvec3(other);
      double largest = 0;
      for (const glm::vec3& p : {own, s, t, other})
        largest = std::max({largest, std::abs(double(p.x)), std::abs(double(p.y)), std::abs(double(p.z))});
      if (std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) <= slack * largest)
        return Parallelogram{own, s, t};
    }
  return std::nullopt;
}

bool emits_evenly(const Material& material) {
  return emits(material) && !material.emissive_texture && !material.clearcoat_texture;
}

LightCounts count_lights(const Scene& scene, const Settings& settings) {
  LightCounts counts;
  std::uint64_t lamps = 0;
  std::optional<PassableMaterials> passable;  // made only if necessary, because it may look at textures
  const auto is_whole = [&](const Primitive& primitive) {
    if (scene.materials[primitive.material].alpha_mode == AlphaMode::opaque) return true;
    if (!passable) passable.emplace(scene);
    return !passable->has(primitive);
  };
  for (const Node& node : scene.nodes)
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives) {
      const Material& material = scene.materials[primitive.material];
      if (!emits(material)) continue;
      const std::size_t count = primitive.indices.triangle_count();
      counts.placed += count;
      ++lamps;
      const bool in_pairs = !node.moves && emits_evenly(material) && is_whole(primitive);
      for (std::size_t i = 0; i + 1 < count && in_pairs; ++i)
        if (parallelogram_of(corners_of(primitive, i), corners_of(primitive, i + 1), kSlackOfFiles))
          ++counts.pairs, ++i;
    }
  const std::uint64_t triangles = counts.placed;
  for (const Shape& shape : scene.shapes) counts.placed += emits(scene.materials[shape.material]) ? 1 : 0;
  for (const PunctualLight& light : scene.lights)
    ++(light_kind(light.kind).distant ? counts.distant : counts.placed);
  if (shines(settings.environment)) ++counts.distant;
  counts.together = lamps == 1 && counts.placed == triangles && is_small(scene);
  return counts;
}

}  // namespace eikon
