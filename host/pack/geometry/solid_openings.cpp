// SPDX-License-Identifier: Apache-2.0
#include "pack/geometry/solid_openings.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pack/pack_parts.h"

namespace eikon {
namespace {

// A closed mesh leaves at most this share of its area open, and moments of at most this share of
// its area times its radius. Seams whose vertices were rounded apart leave less, and a hole that
// matters leaves more.
constexpr double kOpenShare = 1e-4;

}  // namespace

// By the divergence theorem the integral of the normal n over a closed surface is 0, and that of
// the outer product of p and n is the volume times the unit matrix.
bool is_closed(const Scene& scene, const Mesh& mesh) {
  Bounds bounds;
  const auto for_each_solid = [&](const auto& visit) {
    for (const Primitive& primitive : mesh.primitives)
      if (is_solid(scene.materials[primitive.material])) visit(primitive);
  };
  for_each_solid([&](const Primitive& primitive) {
    for (const glm::vec3& p : primitive.positions_object) grow(bounds, glm::dvec3(p));
  });
  if (bounds.empty()) return false;
  const glm::dvec3 center = 0.5 * (bounds.lo + bounds.hi);
  glm::dvec3 normals(0);
  glm::dmat3 moments(0);
  double area = 0;
  for_each_solid([&](const Primitive& primitive) {
    for (std::size_t t = 0; t < primitive.indices.triangle_count(); ++t) {
      const std::array<std::uint32_t, 3> corners = primitive.indices.triangle(t);
      const auto at = [&](std::size_t i) { return glm::dvec3(primitive.positions_object[corners[i]]) - center; };
      const glm::dvec3 p0 = at(0), p1 = at(1), p2 = at(2), n = 0.5 * glm::cross(p1 - p0, p2 - p0);
      normals += n;
      moments += glm::outerProduct((p0 + p1 + p2) / 3.0, n);
      area += glm::length(n);
    }
  });
  const double volume = (moments[0][0] + moments[1][1] + moments[2][2]) / 3;
  const glm::dmat3 rest = moments - glm::dmat3(volume);
  double off = 0;
  for (int i = 0; i < 3; ++i) off = std::max(off, glm::length(rest[i]));
  return glm::length(normals) <= kOpenShare * area &&
         off <= kOpenShare * area * 0.5 * glm::length(bounds.hi - bounds.lo);
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
