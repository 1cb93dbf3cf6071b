// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/error.h"
#include "render/pack_parts.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxTriangles = std::uint64_t{1} << 28;  // what the layouts of the trees can name

/// A primitive's vertices in world space; what nothing needs is empty.
struct WorldVertices {
  std::vector<glm::vec3> positions, normals;
  std::vector<glm::vec4> tangents;  // w: as in the file
};

glm::vec3 world_direction(const glm::dmat3& linear, const glm::vec3& direction) {
  const glm::dvec3 turned = linear * glm::dvec3(direction);
  const double length = glm::length(turned);
  return length > 0 ? glm::vec3(turned / length) : glm::vec3(0);
}

class GeometryPacker {
 public:
  GeometryPacker(const Scene& scene, std::vector<Mesh>* release, const Features& features, PackedScene& packed)
      : scene_(scene),
        release_(release),
        packed_(packed),
        passable_(scene),
        has_vertex_normal_(features.has("vertex_normal")),
        has_uv_(features.has("uv")),
        has_normals_(has_vertex_normal_ || has_uv_),
        has_normal_texture_(features.has("normal_texture")),
        has_uv1_(features.has("uv1")),
        has_tangents_(has_normal_texture_ || has_uv1_),
        has_colors_(features.has("vertex_color")) {}

  void pack() {
    std::size_t count = 0;
    std::vector<std::size_t> last_node(scene_.meshes.size());
    for (std::size_t n = 0; n < scene_.nodes.size(); ++n) {
      last_node[scene_.nodes[n].mesh] = n;
      for (const Primitive& primitive : scene_.meshes[scene_.nodes[n].mesh].primitives)
        count += primitive.indices.size() / 3;
    }
    const std::uint64_t bytes =
        count * (sizeof(Triangle) + (has_normals_ ? sizeof(TriangleNormals) : 0) +
                 (has_tangents_ ? sizeof(TriangleTangents) : 0) + (has_colors_ ? sizeof(TriangleColors) : 0));
    const std::uint64_t memory = std::uint64_t(sysconf(_SC_PHYS_PAGES)) * std::uint64_t(sysconf(_SC_PAGESIZE));
    if (count > kMaxTriangles || bytes > memory)
      throw InputError(fmt::format(
          "{}: {} triangles in all nodes need {} MB of {} MB and are {} at most; use fewer instances or simpler meshes",
          scene_.path.string(), count, bytes >> 20, memory >> 20, kMaxTriangles));
    packed_.triangles.reserve(count + scene_.shapes.size());
    if (has_normals_) packed_.normals.reserve(count);
    if (has_tangents_) packed_.tangents.reserve(count);
    if (has_colors_) packed_.colors.reserve(count);
    for (std::size_t n = 0; n < scene_.nodes.size(); ++n) {
      const std::uint32_t mesh = scene_.nodes[n].mesh;
      const bool last = release_ != nullptr && last_node[mesh] == n;
      for (std::size_t p = 0; p < scene_.meshes[mesh].primitives.size(); ++p)
        add(std::uint32_t(n), scene_.meshes[mesh].primitives[p], last ? &(*release_)[mesh].primitives[p] : nullptr);
    }
  }

 private:
  /// `taken`: null, or the same primitive, whose vertices may be moved.
  WorldVertices to_world(const Node& node, const Primitive& primitive, Primitive* taken) {
    const glm::dmat4& m = node.world_from_object;
    const glm::dmat3 linear(m);
    WorldVertices world;
    world.positions = taken != nullptr ? std::move(taken->positions_object) : primitive.positions_object;
    for (glm::vec3& p : world.positions) {
      p = glm::vec3(glm::dvec3(m * glm::dvec4(glm::dvec3(p), 1.0)));
      for (int axis = 0; axis < 3; ++axis) {
        packed_.bounds.lo[axis] = std::min(packed_.bounds.lo[axis], double(p[axis]));
        packed_.bounds.hi[axis] = std::max(packed_.bounds.hi[axis], double(p[axis]));
      }
    }
    if (has_vertex_normal_) {
      // The cofactor matrix is the inverse transpose times the determinant: defined for flat scales too.
      const glm::dmat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                                glm::cross(linear[0], linear[1]));
      const glm::dmat3 facing = cofactor * (node.mirrored ? -1.0 : 1.0);
      world.normals = taken != nullptr ? std::move(taken->normals_object) : primitive.normals_object;
      for (glm::vec3& n : world.normals) n = world_direction(facing, n);
    }
    if (has_normal_texture_) {
      world.tangents = taken != nullptr ? std::move(taken->tangents_object) : primitive.tangents_object;
      for (glm::vec4& t : world.tangents) t = glm::vec4(world_direction(linear, glm::vec3(t)), t.w);
    }
    return world;
  }

  void add(std::uint32_t node_index, const Primitive& primitive, Primitive* released) {
    const Node& node = scene_.nodes[node_index];
    const std::uint32_t flags = passable_.has(primitive) ? EK_TRIANGLE_PASSABLE : 0;
    const WorldVertices world = to_world(node, primitive, released);
    for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
      const std::uint32_t a = primitive.indices[i];
      const std::uint32_t b = primitive.indices[i + (node.mirrored ? 2 : 1)];
      const std::uint32_t c = primitive.indices[i + (node.mirrored ? 1 : 2)];
      Triangle t{};
      const glm::vec3 &p0 = world.positions[a], &p1 = world.positions[b], &p2 = world.positions[c];
      t.p0_x = p0.x, t.p0_y = p0.y, t.p0_z = p0.z;
      t.p1_x = p1.x, t.p1_y = p1.y, t.p1_z = p1.z;
      t.p2_x = p2.x, t.p2_y = p2.y, t.p2_z = p2.z;
      t.material = primitive.material;
      t.flags = flags;
      t.node = node_index;
      const glm::dvec3 cross = triangle_normal(t);
      const double length = glm::length(cross);
      if (length > 0) t.n_x = float(cross.x / length), t.n_y = float(cross.y / length), t.n_z = float(cross.z / length);
      packed_.triangles.push_back(t);
      if (has_normals_) packed_.normals.push_back(normals_of(world, primitive, a, b, c));
      if (has_tangents_) packed_.tangents.push_back(tangents_of(world, primitive, node.mirrored, a, b, c));
      if (has_colors_) packed_.colors.push_back(colors_of(primitive, a, b, c));
    }
    if (released == nullptr) return;
    Primitive rest;
    rest.material = primitive.material;
    *released = std::move(rest);
  }

  template <class Record>
  static void set_uv(Record& r, const std::vector<glm::vec2>& uv, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (uv.empty()) return;
    r.u0 = uv[a].x, r.v0 = uv[a].y, r.u1 = uv[b].x, r.v1 = uv[b].y, r.u2 = uv[c].x, r.v2 = uv[c].y;
  }

  TriangleNormals normals_of(const WorldVertices& world, const Primitive& primitive, std::uint32_t a, std::uint32_t b,
                             std::uint32_t c) const {
    TriangleNormals r{};
    if (!world.normals.empty()) {
      const glm::vec3 &n0 = world.normals[a], &n1 = world.normals[b], &n2 = world.normals[c];
      r.n0_x = n0.x, r.n0_y = n0.y, r.n0_z = n0.z;
      r.n1_x = n1.x, r.n1_y = n1.y, r.n1_z = n1.z;
      r.n2_x = n2.x, r.n2_y = n2.y, r.n2_z = n2.z;
    }
    if (has_uv_) set_uv(r, primitive.uv[0], a, b, c);
    return r;
  }

  TriangleTangents tangents_of(const WorldVertices& world, const Primitive& primitive, bool mirrored, std::uint32_t a,
                               std::uint32_t b, std::uint32_t c) const {
    TriangleTangents r{};
    if (!world.tangents.empty()) {
      const glm::vec4 &t0 = world.tangents[a], &t1 = world.tangents[b], &t2 = world.tangents[c];
      r.t0_x = t0.x, r.t0_y = t0.y, r.t0_z = t0.z;
      r.t1_x = t1.x, r.t1_y = t1.y, r.t1_z = t1.z;
      r.t2_x = t2.x, r.t2_y = t2.y, r.t2_z = t2.z;
      // The cross product of normal and tangent does not turn with a mirror.
      r.bitangent_sign = t0.w * (mirrored ? -1.0F : 1.0F);
    }
    if (has_uv1_) set_uv(r, primitive.uv[1], a, b, c);
    return r;
  }

  static TriangleColors colors_of(const Primitive& primitive, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const bool has = !primitive.colors.empty();
    const glm::vec4 white(1.0F);
    const glm::vec4 c0 = has ? primitive.colors[a] : white, c1 = has ? primitive.colors[b] : white,
                    c2 = has ? primitive.colors[c] : white;
    return {c0.x, c0.y, c0.z, c0.w, c1.x, c1.y, c1.z, c1.w, c2.x, c2.y, c2.z, c2.w, 0, 0, 0, 0};
  }

  const Scene& scene_;
  std::vector<Mesh>* release_;  // scene_'s own, or null
  PackedScene& packed_;
  PassableMaterials passable_;
  bool has_vertex_normal_, has_uv_, has_normals_, has_normal_texture_, has_uv1_, has_tangents_, has_colors_;
};

}  // namespace

glm::dvec3 triangle_normal(const Triangle& t) {
  const glm::dvec3 p0(t.p0_x, t.p0_y, t.p0_z), p1(t.p1_x, t.p1_y, t.p1_z), p2(t.p2_x, t.p2_y, t.p2_z);
  return glm::cross(p1 - p0, p2 - p0);
}

void pack_geometry(const Scene& scene, std::vector<Mesh>* release, const Features& features, PackedScene& packed) {
  GeometryPacker(scene, release, features, packed).pack();
}

}  // namespace eikon
