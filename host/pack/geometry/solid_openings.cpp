// SPDX-License-Identifier: Apache-2.0
#include "pack/geometry/solid_openings.h"

#include <algorithm>
#include <array>
#include <bit>

namespace eikon {
namespace {

/// The finaliser of SplitMix64 [Steele, Lea, Flood 2014, "Fast Splittable Pseudorandom Number
/// Generators"].
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ x >> 27) * 0x94d049bb133111ebULL;
  return x ^ x >> 31;
}

std::uint64_t hash_of(const glm::vec3& p) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis)  // + 0 makes one zero of both
    hash = mixed(hash ^ std::bit_cast<std::uint32_t>(p[axis] + 0.0F));
  return hash;
}

}  // namespace

// The sum of a hash of all directed edges, less that of the same edges the other way round, is 0 if
// each edge goes both ways equally often.
bool is_closed(const Scene& scene, const Mesh& mesh) {
  std::uint64_t sum = 0;
  bool has_triangles = false;
  for (const Primitive& primitive : mesh.primitives) {
    if (!is_solid(scene.materials[primitive.material])) continue;
    for (std::size_t t = 0; t < primitive.indices.triangle_count(); ++t) {
      const std::array<std::uint32_t, 3> corners = primitive.indices.triangle(t);
      std::array<std::uint64_t, 3> hash;
      for (std::size_t i = 0; i < 3; ++i) hash[i] = hash_of(primitive.positions_object[corners[i]]);
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint64_t from = hash[i], to = hash[(i + 1) % 3];
        sum += mixed(from + 3 * to) - mixed(to + 3 * from);
      }
      has_triangles = true;
    }
  }
  return has_triangles && sum == 0;
}

SolidOpenings::SolidOpenings(const Scene& scene)
    : by_material_(scene.materials.size()), is_closed_(scene.meshes.size()) {
  for (std::size_t i = 0; i < scene.materials.size(); ++i) by_material_[i] = may_have_openings(scene.materials[i]);
  if (std::ranges::find(by_material_, true) == by_material_.end()) return;
  passable_.emplace(scene);
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const auto may_open = [&](const Primitive& p) { return by_material_[p.material] && passable_->has(p); };
    if (std::ranges::any_of(scene.meshes[i].primitives, may_open)) is_closed_[i] = is_closed(scene, scene.meshes[i]);
  }
}

bool SolidOpenings::has(std::uint32_t mesh, const Primitive& primitive) const {
  return passable_ && is_closed_[mesh] && by_material_[primitive.material] && passable_->has(primitive);
}

bool SolidOpenings::has(const Shape& shape) const {
  return passable_ && shape.kind != ShapeKind::implicit && by_material_[shape.material] &&
         passable_->has(shape.material);
}

std::optional<std::uint32_t> SolidOpenings::first_material(const Scene& scene) const {
  if (!passable_) return std::nullopt;
  for (const Node& node : scene.nodes)
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives)
      if (has(node.mesh, primitive)) return primitive.material;
  const auto shape = std::ranges::find_if(scene.shapes, [&](const Shape& s) { return has(s); });
  return shape == scene.shapes.end() ? std::nullopt : std::optional(shape->material);
}

}  // namespace eikon
