// SPDX-License-Identifier: Apache-2.0
#include "pack/geometry/pack_places.h"

#include <tbb/parallel_for.h>

#include <limits>

#include "pack/pack_parts.h"

namespace eikon {
namespace {

// Most corners that are transformed for tight boxes, which takes about a second.
constexpr std::uint64_t kMostCorners = std::uint64_t{1} << 27;

/// A box from the mesh's box alone, which is larger than necessary but takes no time.
PlaceBox quick_box(const MeshPlace& place, const PlacedMesh& mesh) {
  const glm::dvec3 middle = 0.5 * (glm::dvec3(mesh.lo) + glm::dvec3(mesh.hi)), half = glm::dvec3(mesh.hi) - middle;
  PlaceBox box;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 row(place.matrix.rows[std::size_t(i)]);
    const double at = glm::dot(row, middle) + double(place.matrix.translation[i]);
    const double reach = glm::dot(glm::abs(row), half) + 2 * double{place.error};
    box.lo[i] = down(at - reach);
    box.hi[i] = up(at + reach);
  }
  return box;
}

PlaceBox exact_box(const Scene& scene, const MeshPlace& place) {
  PlaceBox box{glm::vec3(std::numeric_limits<float>::infinity()), glm::vec3(-std::numeric_limits<float>::infinity())};
  for (const Primitive& primitive : scene.meshes[scene.nodes[place.node].mesh].primitives) {
    for (const glm::vec3& p : primitive.positions_object) {
      const glm::vec3 world = placed_point(place.matrix, p);
      box.lo = glm::min(box.lo, world);
      box.hi = glm::max(box.hi, world);
    }
  }
  return box;
}

}  // namespace

InstanceRecord instance_record(const MeshPlace& place, const PlacedMesh& mesh) {
  const auto& rows = place.matrix.rows;
  const glm::vec3& t = place.matrix.translation;
  InstanceRecord r{};
  r.m_xx = rows[0].x, r.m_xy = rows[0].y, r.m_xz = rows[0].z, r.t_x = t.x;
  r.m_yx = rows[1].x, r.m_yy = rows[1].y, r.m_yz = rows[1].z, r.t_y = t.y;
  r.m_zx = rows[2].x, r.m_zy = rows[2].y, r.m_zz = rows[2].z, r.t_z = t.z;
  const glm::vec3 middle(0.5 * (glm::dvec3(mesh.lo) + glm::dvec3(mesh.hi)));
  r.middle_x = middle.x, r.middle_y = middle.y, r.middle_z = middle.z;
  glm::vec3 extent;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 row(rows[std::size_t(i)]);
    extent[i] = up(glm::dot(glm::abs(row), glm::dvec3(mesh.extent)) + 4 * double{place.error});
  }
  const glm::mat3 inverse(glm::inverse(linear_part(place.matrix)));
  r.i_xx = inverse[0][0], r.i_xy = inverse[1][0], r.i_xz = inverse[2][0];
  r.i_yx = inverse[0][1], r.i_yy = inverse[1][1], r.i_yz = inverse[2][1];
  r.i_zx = inverse[0][2], r.i_zy = inverse[1][2], r.i_zz = inverse[2][2];
  r.extent_x = extent.x, r.extent_y = extent.y, r.extent_z = extent.z;
  r.error = place.error;
  r.facing = mesh.mirrored ? -1.0F : 1.0F;
  r.node = place.node;
  r.mesh = place.mesh;
  return r;
}

std::vector<PlaceBox> place_boxes(const Scene& scene, const PlacedMeshes& placed, Bounds& bounds) {
  const std::size_t count = placed.places.size();
  std::uint64_t corners = 0;
  for (const MeshPlace& place : placed.places)
    for (const Primitive& primitive : scene.meshes[scene.nodes[place.node].mesh].primitives)
      corners += primitive.positions_object.size();
  std::vector<PlaceBox> boxes(count);
  std::vector<char> exact(count, corners <= kMostCorners ? 1 : 0);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const MeshPlace& place = placed.places[i];
    boxes[i] = exact[i] != 0 ? exact_box(scene, place) : quick_box(place, placed.meshes[place.mesh]);
  });
  // Bounds must not grow by a box that is larger than its corners.
  const auto settle = [&](std::size_t i) {
    if (exact[i] == 0) boxes[i] = exact_box(scene, placed.places[i]);
    exact[i] = 1;
    bounds.lo = glm::min(bounds.lo, glm::dvec3(boxes[i].lo));
    bounds.hi = glm::max(bounds.hi, glm::dvec3(boxes[i].hi));
  };
  for (int axis = 0; axis < 3; ++axis) {
    std::size_t first = 0, last = 0;
    for (std::size_t i = 1; i < count; ++i) {
      if (boxes[i].lo[axis] < boxes[first].lo[axis]) first = i;
      if (boxes[i].hi[axis] > boxes[last].hi[axis]) last = i;
    }
    settle(first);
    settle(last);
  }
  for (std::size_t i = 0; i < count; ++i) {
    bool within = true;
    for (int axis = 0; axis < 3; ++axis)
      within = within && double(boxes[i].lo[axis]) >= bounds.lo[axis] && double(boxes[i].hi[axis]) <= bounds.hi[axis];
    if (!within) settle(i);
  }
  return boxes;
}

}  // namespace eikon
