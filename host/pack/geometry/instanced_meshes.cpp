// SPDX-License-Identifier: Apache-2.0
#include "pack/geometry/instanced_meshes.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "accel/binary_tree.h"
#include "pack/pack_parts.h"
#include "shared/records.h"

namespace eikon {

namespace {

constexpr double kMinSaving = 0x1p24;     // bytes; less than this fits the caches, and costs nothing to repeat
constexpr std::uint64_t kTreeBytes = 80;  // per triangle, in any of the trees
constexpr std::uint64_t kTopBytes = 64;   // per instance in the scene's tree
constexpr double kMaxCondition = 1e6;     // condition number of an instance's matrix

using Corners = std::array<std::uint32_t, 3>;

/// The Frobenius norm, which is at least the largest singular value.
double norm(const glm::dmat3& m) {
  return std::sqrt(glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]));
}

/// Calls fn(primitive, indices of the corners, number of the triangle in the mesh).
template <class Fn>
void for_each_triangle(const Mesh& mesh, const Fn& fn) {
  std::size_t number = 0;
  for (const Primitive& primitive : mesh.primitives)
    for (std::size_t t = 0; t < primitive.indices.triangle_count(); ++t)
      fn(primitive, primitive.indices.triangle(t), number++);
}

InstancedMesh measure(const Mesh& mesh, std::uint32_t index) {
  InstancedMesh m;
  m.mesh = index;
  m.lo = glm::vec3(std::numeric_limits<float>::max());
  m.hi = -m.lo;
  m.least_height = std::numeric_limits<double>::max();
  for (const Primitive& primitive : mesh.primitives)
    for (const glm::vec3& p : primitive.positions_object) m.lo = glm::min(m.lo, p), m.hi = glm::max(m.hi, p);
  for_each_triangle(mesh, [&](const Primitive& primitive, const Corners& corner, std::size_t) {
    const glm::vec3 &a = primitive.positions_object[corner[0]], &b = primitive.positions_object[corner[1]],
                    &c = primitive.positions_object[corner[2]];
    const float corners[9] = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};
    const bool dropped = is_degenerate(corners);
    m.dropped.push_back(dropped);
    if (dropped) return;
    ++m.triangles;
    m.extent = glm::max(m.extent, glm::max(a, glm::max(b, c)) - glm::min(a, glm::min(b, c)));
    const glm::dvec3 ab = glm::dvec3(b) - glm::dvec3(a), ac = glm::dvec3(c) - glm::dvec3(a), bc = ac - ab;
    const double longest = std::sqrt(std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(bc, bc)}));
    m.least_height = std::min(m.least_height, glm::length(glm::cross(ab, ac)) / longest);
  });
  return m;
}

/// True if a triangle with an area has none in this instance.
bool loses_triangles(const Mesh& mesh, const InstancedMesh& instanced, const InstanceTransform& matrix) {
  bool loses = false;
  for_each_triangle(mesh, [&](const Primitive& primitive, const Corners& corner, std::size_t number) {
    if (loses || instanced.dropped[number]) return;
    float corners[9];
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec3 p = instance_point(matrix, primitive.positions_object[corner[k]]);
      corners[3 * k] = p.x, corners[3 * k + 1] = p.y, corners[3 * k + 2] = p.z;
    }
    loses = is_degenerate(corners);
  });
  return loses;
}

/// Finds the matrix of an instance. Returns false if its mesh cannot be stored once for this node.
bool find_transform(const Scene& scene, const Node& node, const InstancedMesh& mesh, MeshInstance& instance) {
  instance.matrix = instance_transform(node.world_from_object);
  const auto& rows = instance.matrix.rows;
  const glm::dmat3 linear = linear_part(instance.matrix);
  double largest = 0;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 row(rows[std::size_t(i)]);
    const glm::dvec3 farthest = glm::max(glm::abs(glm::dvec3(mesh.lo)), glm::abs(glm::dvec3(mesh.hi)));
    largest = std::max(largest, glm::dot(glm::abs(row), farthest) + std::abs(double(instance.matrix.translation[i])));
  }
  const glm::dmat3 inverse = glm::inverse(linear);
  const double scale = norm(linear), inverse_scale = norm(inverse);
  if (!(scale * inverse_scale < kMaxCondition) || !(largest < 0x1p100) || !(scale > 0x1p-60) ||
      (glm::determinant(linear) < 0) != node.mirrored)
    return false;
  // Bounds the errors of three products, two sums and the translation, half a unit each, with room
  // to spare.
  instance.error = float(largest * 0x1p-21);
  const double least = 1 / (inverse_scale * inverse_scale * scale);  // heights shrink by this factor at most
  return least * mesh.least_height > 32 * double{instance.error} ||
         !loses_triangles(scene.meshes[node.mesh], mesh, instance.matrix);
}

bool can_be_stored_once(const Scene& scene, const Mesh& mesh, const PassableMaterials& passable) {
  return std::ranges::none_of(mesh.primitives, [&](const Primitive& primitive) {
    const Material& material = scene.materials[primitive.material];
    return material.emission != glm::vec3(0) || material.solid || passable.has(primitive);
  });
}

void find_instances(const Scene& scene, InstancedMeshes& found) {
  std::vector<std::uint32_t> uses(scene.meshes.size(), 0);
  for (const Node& node : scene.nodes) ++uses[node.mesh];
  if (std::ranges::none_of(uses, [](std::uint32_t n) { return n > 1; })) return;
  const PassableMaterials passable(scene);
  constexpr std::uint32_t kNone = 0xffffffffU;
  std::vector<std::uint32_t> entry[2] = {std::vector(scene.meshes.size(), kNone),
                                         std::vector(scene.meshes.size(), kNone)};
  std::vector<std::uint32_t> measured(scene.meshes.size(), kNone);
  std::vector<InstancedMesh> measures;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    if (uses[m] < 2 || !can_be_stored_once(scene, scene.meshes[m], passable)) continue;
    InstancedMesh mesh = measure(scene.meshes[m], std::uint32_t(m));
    if (mesh.triangles == 0) continue;
    measured[m] = std::uint32_t(measures.size());
    measures.push_back(std::move(mesh));
  }
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    const Node& node = scene.nodes[n];
    if (measured[node.mesh] == kNone) continue;
    MeshInstance instance;
    const InstancedMesh& mesh = measures[measured[node.mesh]];
    if (!find_transform(scene, node, mesh, instance)) continue;
    std::uint32_t& to = entry[node.mirrored ? 1 : 0][node.mesh];
    if (to == kNone) {
      to = std::uint32_t(found.meshes.size());
      found.meshes.push_back(mesh);
      found.meshes.back().mirrored = node.mirrored;
      found.stored_triangles += mesh.triangles;
    }
    instance.node = std::uint32_t(n);
    instance.mesh = to;
    found.instances.push_back(instance);
    found.is_instance[n] = true;
    found.instanced_triangles += mesh.triangles;
  }
}

/// Rough sizes of instances and their meshes.
struct StoredBytes {
  std::uint64_t flat = 0, two_level = 0;
};

StoredBytes stored_bytes(const InstancedMeshes& instanced, const Features& features) {
  const std::uint64_t bytes = kTreeBytes + triangle_bytes(features);
  return {bytes * instanced.instanced_triangles,
          bytes * instanced.stored_triangles + (sizeof(InstanceRecord) + kTopBytes) * instanced.instances.size()};
}

}  // namespace

std::uint64_t triangle_bytes(const Features& features) {
  return sizeof(Triangle) +
         (features.has(Feature::vertex_normal) || features.has(Feature::uv) ? sizeof(TriangleNormals) : 0) +
         (features.has(Feature::tangent) || features.has(Feature::uv1) ? sizeof(TriangleTangents) : 0) +
         (features.has(Feature::vertex_color) ? sizeof(TriangleColors) : 0);
}

std::uint64_t two_level_saving(const InstancedMeshes& instanced, const Features& features) {
  const StoredBytes bytes = stored_bytes(instanced, features);
  return bytes.flat > bytes.two_level ? bytes.flat - bytes.two_level : 0;
}

InstancedMeshes find_instanced_meshes(const Scene& scene) {
  InstancedMeshes found;
  found.is_instance.resize(scene.nodes.size(), false);
  if (!scene.in_motion) find_instances(scene, found);
  for (std::size_t n = 0; n < scene.nodes.size(); ++n)
    if (!found.is_instance[n])
      for (const Primitive& primitive : scene.meshes[scene.nodes[n].mesh].primitives)
        found.other_triangles += primitive.indices.triangle_count();
  return found;
}

bool has_two_levels(const std::string& layout) { return layout == "bvh16" || layout == "bvh8" || layout == "bvh2"; }

InstanceChoice choose_instances(const InstancedMeshes& instanced, const Features& features,
                                const Execution& execution) {
  InstanceChoice choice;
  const bool asked = execution.instances == InstanceMode::two_level;
  const auto flat = [&](std::string why) {
    choice.why = std::move(why);
    choice.refused = asked;
    return choice;
  };
  if (instanced.instances.empty()) return flat("no opaque mesh has two instances");
  const StoredBytes bytes = stored_bytes(instanced, features);
  choice.flat_bytes = bytes.flat;
  choice.two_level_bytes = bytes.two_level;
  if (execution.accel != "bvh") return flat(fmt::format("--accel {} has one level", execution.accel));
  if (!execution.layout.empty() && execution.layout != "probe" && !has_two_levels(execution.layout))
    return flat(fmt::format("--layout {} has one level", execution.layout));
  if (execution.instances == InstanceMode::flat) return flat("asked for");
  const double saved = double(choice.flat_bytes) - double(choice.two_level_bytes);
  choice.two_level = asked || (saved >= kMinSaving && 2 * choice.two_level_bytes <= choice.flat_bytes);
  choice.why = asked              ? "asked for"
               : choice.two_level ? fmt::format("saves {:.0f} MB", saved * 1e-6)
                                  : "two levels would save too little";
  return choice;
}

Features features_of(const Scene& scene, const Settings& settings, const Execution& execution, InstanceChoice* choice) {
  Features features(scene, settings);
  InstanceChoice chosen = choose_instances(find_instanced_meshes(scene), features, execution);
  features.set_two_level(chosen.two_level, chosen.why);
  if (choice != nullptr) *choice = std::move(chosen);
  return features;
}

namespace {

// Most corners that are transformed for tight boxes, which takes about a second.
constexpr std::uint64_t kMaxCorners = std::uint64_t{1} << 27;

/// A box from the mesh's box alone, which is larger than necessary but takes no time.
InstanceBox quick_box(const MeshInstance& instance, const InstancedMesh& mesh) {
  const glm::dvec3 middle = 0.5 * (glm::dvec3(mesh.lo) + glm::dvec3(mesh.hi)), half = glm::dvec3(mesh.hi) - middle;
  InstanceBox box;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 row(instance.matrix.rows[std::size_t(i)]);
    const double at = glm::dot(row, middle) + double(instance.matrix.translation[i]);
    const double reach = glm::dot(glm::abs(row), half) + 2 * double{instance.error};
    box.lo[i] = down(at - reach);
    box.hi[i] = up(at + reach);
  }
  return box;
}

InstanceBox exact_box(const Scene& scene, const MeshInstance& instance) {
  InstanceBox box{glm::vec3(std::numeric_limits<float>::infinity()),
                  glm::vec3(-std::numeric_limits<float>::infinity())};
  for (const Primitive& primitive : scene.meshes[scene.nodes[instance.node].mesh].primitives) {
    for (const glm::vec3& p : primitive.positions_object) {
      const glm::vec3 world = instance_point(instance.matrix, p);
      box.lo = glm::min(box.lo, world);
      box.hi = glm::max(box.hi, world);
    }
  }
  return box;
}

}  // namespace

InstanceRecord instance_record(const MeshInstance& instance, const InstancedMesh& mesh) {
  const auto& rows = instance.matrix.rows;
  const glm::vec3& t = instance.matrix.translation;
  InstanceRecord r{};
  r.m_xx = rows[0].x, r.m_xy = rows[0].y, r.m_xz = rows[0].z, r.t_x = t.x;
  r.m_yx = rows[1].x, r.m_yy = rows[1].y, r.m_yz = rows[1].z, r.t_y = t.y;
  r.m_zx = rows[2].x, r.m_zy = rows[2].y, r.m_zz = rows[2].z, r.t_z = t.z;
  const glm::vec3 middle(0.5 * (glm::dvec3(mesh.lo) + glm::dvec3(mesh.hi)));
  r.middle_x = middle.x, r.middle_y = middle.y, r.middle_z = middle.z;
  glm::vec3 extent;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 row(rows[std::size_t(i)]);
    extent[i] = up(glm::dot(glm::abs(row), glm::dvec3(mesh.extent)) + 4 * double{instance.error});
  }
  const glm::mat3 inverse(glm::inverse(linear_part(instance.matrix)));
  r.i_xx = inverse[0][0], r.i_xy = inverse[1][0], r.i_xz = inverse[2][0];
  r.i_yx = inverse[0][1], r.i_yy = inverse[1][1], r.i_yz = inverse[2][1];
  r.i_zx = inverse[0][2], r.i_zy = inverse[1][2], r.i_zz = inverse[2][2];
  r.extent_x = extent.x, r.extent_y = extent.y, r.extent_z = extent.z;
  r.error = instance.error;
  r.facing = mesh.mirrored ? -1.0F : 1.0F;
  r.node = instance.node;
  r.mesh = instance.mesh;
  return r;
}

std::vector<InstanceBox> instance_boxes(const Scene& scene, const InstancedMeshes& instanced, Bounds& bounds) {
  const std::size_t count = instanced.instances.size();
  std::uint64_t corners = 0;
  for (const MeshInstance& instance : instanced.instances)
    for (const Primitive& primitive : scene.meshes[scene.nodes[instance.node].mesh].primitives)
      corners += primitive.positions_object.size();
  std::vector<InstanceBox> boxes(count);
  std::vector<char> exact(count, corners <= kMaxCorners ? 1 : 0);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const MeshInstance& instance = instanced.instances[i];
    boxes[i] = exact[i] != 0 ? exact_box(scene, instance) : quick_box(instance, instanced.meshes[instance.mesh]);
  });
  // Bounds must not grow by a box that is larger than its corners.
  const auto settle = [&](std::size_t i) {
    if (exact[i] == 0) boxes[i] = exact_box(scene, instanced.instances[i]);
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
