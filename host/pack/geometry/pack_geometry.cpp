// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "core/error.h"
#include "core/host_limits.h"
#include "pack/geometry/instanced_meshes.h"
#include "pack/geometry/solid_openings.h"
#include "pack/pack_parts.h"
#include "scene/emission.h"
#include "scene/transform.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxTriangles = std::uint64_t{1} << 28;  // that layouts of trees can number

constexpr std::size_t kManyTriangles = 1U << 14;  // of which pack_emitters tells

/// A primitive's vertices in world space; data that no feature needs is empty.
struct WorldVertices {
  std::vector<glm::vec3> positions, normals;
  std::vector<glm::vec4> tangents;  // w: that of the file
};

/// Indices of a triangle's corners; those of a mirrored mesh change places.
using Corners = std::array<std::uint32_t, 3>;

class GeometryPacker {
 public:
  GeometryPacker(const Scene& scene, std::vector<Mesh>* release, const Features& features, PackedScene& packed)
      : scene_(scene),
        release_(release),
        packed_(packed),
        passable_(scene),
        solid_openings_(features.has(Feature::open_solid) ? SolidOpenings(scene) : SolidOpenings()),
        features_(features),
        two_level_(features.has(Feature::instance)),
        has_vertex_normal_(features.has(Feature::vertex_normal)),
        has_uv_(features.has(Feature::uv)),
        has_normals_(has_vertex_normal_ || has_uv_),
        has_tangent_(features.has(Feature::tangent)),
        has_uv1_(features.has(Feature::uv1)),
        has_tangents_(has_tangent_ || has_uv1_),
        has_colors_(features.has(Feature::vertex_color)) {}

  void pack() {
    instanced_ = find_instanced_meshes(scene_);
    const bool two_level = two_level_ && !instanced_.instances.empty();
    if (!two_level) packed_.two_level_saving = two_level_saving(instanced_, features_);
    const std::uint64_t count = instanced_.packed_triangles(two_level);
    require_room(count);
    std::vector<std::size_t> last_node(scene_.meshes.size());
    for (std::size_t n = 0; n < scene_.nodes.size(); ++n) {
      // Instances are packed after all other nodes.
      last_node[scene_.nodes[n].mesh] = n + (instanced_.is_instance[n] ? scene_.nodes.size() : 0);
    }
    for (std::size_t n = 0; n < scene_.nodes.size(); ++n) {
      const std::uint32_t mesh = scene_.nodes[n].mesh;
      if (instanced_.is_instance[n]) last_node[mesh] = std::max(last_node[mesh], n + scene_.nodes.size());
    }
    packed_.triangles.reserve(count + scene_.shapes.size());
    if (has_normals_) packed_.normals.reserve(count);
    if (has_tangents_) packed_.tangents.reserve(count);
    if (has_colors_) packed_.colors.reserve(count);
    for (std::size_t n = 0; n < scene_.nodes.size(); ++n) {
      if (instanced_.is_instance[n]) continue;
      const std::uint32_t mesh = scene_.nodes[n].mesh;
      for_primitives(mesh, last_node[mesh] == n,
                     [&](const Primitive& primitive, Primitive* taken) { add(std::uint32_t(n), primitive, taken); });
    }
    if (two_level) {
      store_meshes();
      store_instances();
    } else {
      for (const MeshInstance& instance : instanced_.instances) {
        const std::uint32_t mesh = scene_.nodes[instance.node].mesh;
        std::size_t number = 0;
        for_primitives(
            mesh, last_node[mesh] == instance.node + scene_.nodes.size(),
            [&](const Primitive& primitive, Primitive* taken) { add_instance(instance, primitive, taken, number); });
      }
    }
    if (two_level && release_ != nullptr)
      for (const MeshInstance& instance : instanced_.instances)
        for (Primitive& primitive : (*release_)[scene_.nodes[instance.node].mesh].primitives) let_go(primitive);
  }

  /// Packs what emits, and of everything else only the bounds. full: called whenever there are many
  /// triangles
  void pack_emitters(const std::function<void()>& full) {
    full_ = full;
    instanced_ = find_instanced_meshes(scene_);
    require_room(instanced_.packed_triangles(two_level_));
    for (std::size_t n = 0; n < scene_.nodes.size(); ++n) {
      if (instanced_.is_instance[n]) continue;
      const Node& node = scene_.nodes[n];
      for (const Primitive& primitive : scene_.meshes[node.mesh].primitives) {
        if (emits(scene_.materials[primitive.material]))
          add(std::uint32_t(n), primitive, nullptr);
        else
          for (const glm::vec3& p : primitive.positions_object) grow(packed_.bounds, glm::dvec3(world_point(node, p)));
      }
    }
    if (instanced_.instances.empty()) return;  // they never emit
    static_cast<void>(instance_boxes(scene_, instanced_, packed_.bounds));
  }

 private:
  static glm::vec3 world_point(const Node& node, const glm::vec3& p) {
    return glm::vec3(transform_point(node.world_from_object, p));
  }

  /// taken: null, or the same primitive, whose vertices may be moved from
  WorldVertices to_world(const Node& node, const Primitive& primitive, Primitive* taken) {
    const glm::dmat3 linear(node.world_from_object);
    WorldVertices world;
    world.positions = taken != nullptr ? taken->positions_object.take() : primitive.positions_object.all();
    for (glm::vec3& p : world.positions) {
      p = world_point(node, p);
      grow(packed_.bounds, glm::dvec3(p));
    }
    if (has_vertex_normal_) {
      const glm::dmat3 facing = cofactors(linear) * (node.mirrored ? -1.0 : 1.0);
      world.normals = taken != nullptr ? taken->normals_object.take() : primitive.normals_object.all();
      for (glm::vec3& n : world.normals) n = direction_of(facing * glm::dvec3(n));
    }
    if (has_tangent_) {
      world.tangents = taken != nullptr ? taken->tangents_object.take() : primitive.tangents_object.all();
      for (glm::vec4& t : world.tangents) t = glm::vec4(direction_of(linear * glm::dvec3(t)), t.w);
    }
    return world;
  }

  void add(std::uint32_t node_index, const Primitive& primitive, Primitive* released) {
    const Node& node = scene_.nodes[node_index];
    const bool is_alpha_tested = passable_.has(primitive) && !solid_openings_.has(node.mesh, primitive);
    const std::uint32_t flags = (is_alpha_tested ? EK_TRIANGLE_ALPHA_TESTED : 0) |
                                surface_flags(scene_.materials[primitive.material], &primitive) |
                                light_group(node.light_group, scene_.materials[primitive.material])
                                    << EK_TRIANGLE_GROUP_SHIFT;
    const WorldVertices world = to_world(node, primitive, released);
    for (std::size_t i = 0; i < primitive.indices.triangle_count(); ++i) {
      const Corners corners = corners_at(primitive, i, node.mirrored);
      Triangle t = triangle_of(world, primitive.material, corners);
      t.flags = flags;
      t.node = node_index;
      const glm::dvec3 cross = triangle_normal(t);
      const double length = glm::length(cross);
      if (length > 0) t.n_x = float(cross.x / length), t.n_y = float(cross.y / length), t.n_z = float(cross.z / length);
      push(t, world, primitive, node.mirrored, corners);
    }
    if (released != nullptr) let_go(*released);
  }

  static void let_go(Primitive& primitive) {
    Primitive rest;
    rest.material = primitive.material;
    primitive = std::move(rest);
  }

  /// Calls fn(primitive, taken) for each primitive of a mesh. last: nothing else needs the mesh,
  /// and taken is the primitive itself
  template <class Fn>
  void for_primitives(std::uint32_t mesh, bool last, const Fn& fn) {
    for (std::size_t p = 0; p < scene_.meshes[mesh].primitives.size(); ++p)
      fn(scene_.meshes[mesh].primitives[p], release_ != nullptr && last ? &(*release_)[mesh].primitives[p] : nullptr);
  }

  void require_room(std::uint64_t count) const {
    const std::uint64_t bytes = count * triangle_bytes(features_);
    const std::uint64_t memory = usable_memory_bytes();
    if (count <= kMaxTriangles && bytes <= memory) return;
    const bool repeats = !two_level_ && instanced_.instanced_triangles > 2 * instanced_.stored_triangles;
    throw InputError(
        fmt::format("{}: {} triangles in all nodes need {} MB of {} MB and are {} at most; {}", scene_.path.string(),
                    count, bytes >> 20, memory >> 20, kMaxTriangles,
                    repeats ? "store meshes once (--instances two-level)" : "use fewer instances or simpler meshes"));
  }

  /// Adds triangles: for each instance with vertices in the world, or once with those in object
  /// space.
  void add_triangles(const WorldVertices& at, const Primitive& primitive, const InstancedMesh& mesh, std::uint32_t node,
                     std::size_t& number, bool in_world) {
    const std::uint32_t flags = surface_flags(scene_.materials[primitive.material], &primitive);
    for (std::size_t i = 0; i < primitive.indices.triangle_count(); ++i) {
      if (mesh.dropped[number++]) continue;
      const Corners corners = corners_at(primitive, i, mesh.mirrored);
      Triangle t = triangle_of(at, primitive.material, corners);
      t.node = node;
      t.flags = flags;
      if (in_world) {
        const auto [a, b, c] = corners;
        const glm::vec3 n = accurate_triangle_normal(at.positions[a], at.positions[b], at.positions[c]);
        t.n_x = n.x, t.n_y = n.y, t.n_z = n.z;
      }
      push(t, at, primitive, mesh.mirrored, corners);
    }
  }

  /// Adds a triangle with the data of its corners.
  void push(const Triangle& t, const WorldVertices& at, const Primitive& primitive, bool mirrored,
            const Corners& corners) {
    packed_.triangles.push_back(t);
    if (has_normals_) packed_.normals.push_back(normals_of(at, primitive, corners));
    if (has_tangents_) packed_.tangents.push_back(tangents_of(at, primitive, mirrored, corners));
    if (has_colors_) packed_.colors.push_back(colors_of(primitive, corners));
    if (full_ && packed_.triangles.size() >= kManyTriangles) full_();
  }

  /// Adds a mesh for one instance, with the bits that it would have if it were stored once.
  void add_instance(const MeshInstance& instance, const Primitive& primitive, Primitive* released,
                    std::size_t& number) {
    const bool mirrored = instanced_.meshes[instance.mesh].mirrored;
    WorldVertices world;
    world.positions.reserve(primitive.positions_object.size());
    for (const glm::vec3& p : primitive.positions_object) {
      world.positions.push_back(instance_point(instance.matrix, p));
      grow(packed_.bounds, glm::dvec3(world.positions.back()));
    }
    if (has_vertex_normal_)
      for (const glm::vec3& n : primitive.normals_object)
        world.normals.push_back(instance_normal(instance.matrix, mirrored, n));
    if (has_tangent_)
      for (const glm::vec4& t : primitive.tangents_object)
        world.tangents.emplace_back(instance_tangent(instance.matrix, glm::vec3(t)), t.w);
    add_triangles(world, primitive, instanced_.meshes[instance.mesh], instance.node, number, true);
    if (released != nullptr) let_go(*released);
  }

  void store_meshes() {
    for (const InstancedMesh& mesh : instanced_.meshes) {
      packed_.stored_meshes.push_back({packed_.triangles.size(), std::size_t(mesh.triangles)});
      std::size_t number = 0;
      for (const Primitive& primitive : scene_.meshes[mesh.mesh].primitives) {
        WorldVertices own;
        own.positions = primitive.positions_object;
        if (has_vertex_normal_) own.normals = primitive.normals_object;
        if (has_tangent_) own.tangents = primitive.tangents_object;
        add_triangles(own, primitive, mesh, 0, number, false);
      }
    }
  }

  void store_instances() {
    packed_.instances.reserve(instanced_.instances.size());
    for (const MeshInstance& instance : instanced_.instances)
      packed_.instances.push_back(instance_record(instance, instanced_.meshes[instance.mesh]));
    packed_.instance_boxes = instance_boxes(scene_, instanced_, packed_.bounds);
  }

  static Corners corners_at(const Primitive& primitive, std::size_t triangle, bool mirrored) {
    Corners corners = primitive.indices.triangle(triangle);
    if (mirrored) std::swap(corners[1], corners[2]);
    return corners;
  }

  static Triangle triangle_of(const WorldVertices& at, std::uint32_t material, const Corners& corners) {
    Triangle t{};
    const auto [a, b, c] = corners;
    set_corners(t, at.positions[a], at.positions[b], at.positions[c]);
    t.material = material;
    return t;
  }

  template <class Record>
  static void set_uv(Record& r, const SharedVector<glm::vec2>& uv, const Corners& corners) {
    if (uv.empty()) return;
    const auto [a, b, c] = corners;
    r.u0 = uv[a].x, r.v0 = uv[a].y, r.u1 = uv[b].x, r.v1 = uv[b].y, r.u2 = uv[c].x, r.v2 = uv[c].y;
  }

  TriangleNormals normals_of(const WorldVertices& world, const Primitive& primitive, const Corners& corners) const {
    TriangleNormals r{};
    if (!world.normals.empty()) {
      const auto [a, b, c] = corners;
      const glm::vec3 &n0 = world.normals[a], &n1 = world.normals[b], &n2 = world.normals[c];
      r.n0_x = n0.x, r.n0_y = n0.y, r.n0_z = n0.z;
      r.n1_x = n1.x, r.n1_y = n1.y, r.n1_z = n1.z;
      r.n2_x = n2.x, r.n2_y = n2.y, r.n2_z = n2.z;
    }
    if (has_uv_) set_uv(r, primitive.uv[0], corners);
    return r;
  }

  TriangleTangents tangents_of(const WorldVertices& world, const Primitive& primitive, bool mirrored,
                               const Corners& corners) const {
    TriangleTangents r{};
    if (!world.tangents.empty()) {
      const auto [a, b, c] = corners;
      const glm::vec4 &t0 = world.tangents[a], &t1 = world.tangents[b], &t2 = world.tangents[c];
      r.t0_x = t0.x, r.t0_y = t0.y, r.t0_z = t0.z;
      r.t1_x = t1.x, r.t1_y = t1.y, r.t1_z = t1.z;
      r.t2_x = t2.x, r.t2_y = t2.y, r.t2_z = t2.z;
      // A mirror does not reverse the cross product of normal and tangent.
      r.bitangent_sign = t0.w * (mirrored ? -1.0F : 1.0F);
    }
    if (has_uv1_) set_uv(r, primitive.uv[1], corners);
    return r;
  }

  static TriangleColors colors_of(const Primitive& primitive, const Corners& corners) {
    const auto at = [&](std::size_t k) {
      return primitive.colors.empty() ? glm::vec4(1) : primitive.colors[corners[k]];
    };
    const glm::vec4 c0 = at(0), c1 = at(1), c2 = at(2);
    return {c0.x, c0.y, c0.z, c0.w, c1.x, c1.y, c1.z, c1.w, c2.x, c2.y, c2.z, c2.w, 0, 0, 0, 0};
  }

  const Scene& scene_;
  std::vector<Mesh>* release_;  // scene_'s own, or null
  PackedScene& packed_;
  PassableMaterials passable_;
  SolidOpenings solid_openings_;
  InstancedMeshes instanced_;
  const Features& features_;
  std::function<void()> full_ = {};
  bool two_level_;
  bool has_vertex_normal_, has_uv_, has_normals_, has_tangent_, has_uv1_, has_tangents_, has_colors_;
};

}  // namespace

glm::dvec3 triangle_normal(const Triangle& t) {
  const glm::dvec3 p0(t.p0_x, t.p0_y, t.p0_z), p1(t.p1_x, t.p1_y, t.p1_z), p2(t.p2_x, t.p2_y, t.p2_z);
  return glm::cross(p1 - p0, p2 - p0);
}

void pack_geometry(const Scene& scene, std::vector<Mesh>* release, const Features& features, PackedScene& packed) {
  GeometryPacker(scene, release, features, packed).pack();
}

void pack_emitters(const Scene& scene, const Features& features, PackedScene& packed,
                   const std::function<void()>& full) {
  GeometryPacker(scene, nullptr, features, packed).pack_emitters(full);
}

}  // namespace eikon
