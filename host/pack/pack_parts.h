// SPDX-License-Identifier: Apache-2.0
// The parts of pack_scene, one file each.
#pragma once
#include <cmath>
#include <limits>

#include "pack/pack.h"

namespace eikon {

/// The vector with twice a triangle's area for its length, and to the triangle's front.
[[nodiscard]] glm::dvec3 triangle_normal(const Triangle& t);

/// down: the largest float that is not above x; up: the smallest that is not below.
[[nodiscard]] inline float down(double x) {
  const auto f = float(x);
  return double(f) <= x ? f : std::nextafterf(f, -std::numeric_limits<float>::infinity());
}
[[nodiscard]] inline float up(double x) { return -down(-x); }

/// Light group of what a material emits on a node: that of the node, if it has one.
[[nodiscard]] inline std::uint32_t light_group(std::uint32_t of_place, const Material& material) {
  return of_place != 0 ? of_place : material.light_group;
}

/// Tells which primitives have an opacity below 1 somewhere, so that a ray may pass them: those
/// with alphaMode MASK or BLEND whose factor, texture or vertex colours are below 1. Many files say
/// BLEND where everything is opaque.
class PassableMaterials {
 public:
  explicit PassableMaterials(const Scene& scene);
  [[nodiscard]] bool has(const Primitive& primitive) const;
  /// The same for a surface without vertex colours.
  [[nodiscard]] bool has(std::uint32_t material) const { return by_material_.at(material) == Passable::always; }

 private:
  enum class Passable { never, if_colors, always };
  std::vector<Passable> by_material_;
};

/// Packs the triangles of all nodes in world space, with the data that materials need at the
/// corners, and the bounds.
/// release: null, or scene.meshes, whose primitives are freed, but for their materials, once no
/// node needs them any more
/// throws InputError when they are more than trees or memory can hold
void pack_geometry(const Scene& scene, std::vector<Mesh>* release, const Features& features, PackedScene& packed);

/// Packs the shapes, with their records behind the triangles, and extends the bounds. Runs after
/// pack_geometry.
/// throws InputError when they are more than trees can name
void pack_shapes(const Scene& scene, const Features& features, PackedScene& packed);

/// Packs the material records with their textures. throws InputError when those are more than an
/// index can name
void pack_materials(const Scene& scene, const Features& features, PackedScene& packed);

/// Packs lights of all kinds, the table that chooses among them, and the environment's map. Runs
/// after the other parts.
/// throws InputError for an environment that is too large or too bright
void pack_lights(const Scene& scene, const Features& features, const Settings& settings, PackedScene& packed);

}  // namespace eikon
