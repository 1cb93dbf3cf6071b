// SPDX-License-Identifier: Apache-2.0
// The parts of pack_scene, one file each.
#pragma once
#include <cmath>
#include <limits>

#include "pack/pack.h"

namespace eikon {

/// Twice the area of a packed triangle as a vector to its front.
[[nodiscard]] glm::dvec3 triangle_normal(const Triangle& t);

/// The nearest float that is not above x, or not below.
[[nodiscard]] inline float down(double x) {
  const auto f = float(x);
  return double(f) <= x ? f : std::nextafterf(f, -std::numeric_limits<float>::infinity());
}
[[nodiscard]] inline float up(double x) { return -down(-x); }

/// Light group of what a material emits at a place: the place's, if it has one.
[[nodiscard]] inline std::uint32_t light_group(std::uint32_t of_place, const Material& material) {
  return of_place != 0 ? of_place : material.light_group;
}

/// Which primitives have an opacity below 1 somewhere, so that a ray may pass them: materials of alphaMode MASK or BLEND whose
/// factor, texture or vertex colours say so. Many files have BLEND where everything is opaque.
class PassableMaterials {
 public:
  explicit PassableMaterials(const Scene& scene);
  [[nodiscard]] bool has(const Primitive& primitive) const;
  /// Of a surface without colours of its own.
  [[nodiscard]] bool has(std::uint32_t material) const { return by_material_.at(material) == Passable::always; }

 private:
  enum class Passable { never, if_colors, always };
  std::vector<Passable> by_material_;
};

/// Triangles of all nodes in world space with what their materials need at the corners, and the bounds.
/// `release`: null, or scene.meshes; each primitive of those is freed, but for its material, once no node needs it any more.
/// throws InputError when they are more than trees or memory can hold
void pack_geometry(const Scene& scene, std::vector<Mesh>* release, const Features& features, PackedScene& packed);

/// Shapes, their records behind the triangles', and the bounds of all. After pack_geometry.
/// throws InputError when they are more than trees can name
void pack_shapes(const Scene& scene, const Features& features, PackedScene& packed);

/// Material records with their textures. throws InputError when those are more than an index can name
void pack_materials(const Scene& scene, const Features& features, PackedScene& packed);

/// Lights of all kinds, their table, and the environment's map. After the other parts.
/// throws InputError for an environment that is too large or too bright
void pack_lights(const Scene& scene, const Features& features, const Settings& settings, PackedScene& packed);

}  // namespace eikon
