// SPDX-License-Identifier: Apache-2.0
// The parts of pack_scene, one file each.
#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "pack/materials/material_traits.h"
#include "pack/pack.h"
#include "scene/transform.h"

namespace eikon {

/// The vector with twice a triangle's area for its length, and to the triangle's front.
[[nodiscard]] glm::dvec3 triangle_normal(const Triangle& t);

/// Sets or reads the corners p0, p1 and p2 of a Triangle or Light.
template <class Record>
void set_corners(Record& r, const glm::vec3& p0, const glm::vec3& p1, const glm::vec3& p2) {
  r.p0_x = p0.x, r.p0_y = p0.y, r.p0_z = p0.z;
  r.p1_x = p1.x, r.p1_y = p1.y, r.p1_z = p1.z;
  r.p2_x = p2.x, r.p2_y = p2.y, r.p2_z = p2.z;
}
[[nodiscard]] inline std::array<glm::vec3, 3> corners_of(const Triangle& t) {
  return {glm::vec3(t.p0_x, t.p0_y, t.p0_z), glm::vec3(t.p1_x, t.p1_y, t.p1_z), glm::vec3(t.p2_x, t.p2_y, t.p2_z)};
}

inline void grow(Bounds& bounds, const glm::dvec3& p) {
  bounds.lo = glm::min(bounds.lo, p);
  bounds.hi = glm::max(bounds.hi, p);
}

/// Grows them by a box of another space.
inline void grow(Bounds& bounds, const glm::dmat4& world_from_own, const Bounds& own) {
  for (int corner = 0; corner < 8 && !own.empty(); ++corner) {
    const glm::dvec3 at((corner & 1) != 0 ? own.hi.x : own.lo.x, (corner & 2) != 0 ? own.hi.y : own.lo.y,
                        (corner & 4) != 0 ? own.hi.z : own.lo.z);
    grow(bounds, transform_point(world_from_own, at));
  }
}

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

/// Packs the triangles of all nodes in world space, with the data that materials need at the
/// corners, and the bounds.
/// release: null, or scene.meshes, whose primitives are freed, but for their materials, once no
/// node needs them any more
/// throws InputError when they are more than trees or memory can hold
void pack_geometry(const Scene& scene, std::vector<Mesh>* release, const Features& features, PackedScene& packed);

/// Does the same for the triangles that emit alone; the bounds are those of all.
/// full  called whenever there are some ten thousand, so that it may take them away
void pack_emitters(const Scene& scene, const Features& features, PackedScene& packed,
                   const std::function<void()>& full);

/// Packs the poses of triangles that move while the shutter is open, and extends the bounds. Runs
/// after all other parts. throws InputError when they are more than an index can name
void pack_motion(const Scene& scene, const Features& features, PackedScene& packed);

/// Packs where the triangles that move until the next frame are then. Runs after all other parts.
/// throws InputError when they are more than an index can name
void pack_next_corners(const Scene& scene, const Features& features, PackedScene& packed);

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

/// Packs the shapes, the bounds and the summary of lights, and neither triangles nor lights: what
/// emits is looked at a few triangles at a time. Runs after pack_materials. Returns the bytes that
/// pack_lights would need for the lights. throws InputError as pack_emitters, pack_shapes and
/// pack_lights do
[[nodiscard]] std::uint64_t summarise_lights(const Scene& scene, const Features& features, const Settings& settings,
                                             PackedScene& packed);

}  // namespace eikon
