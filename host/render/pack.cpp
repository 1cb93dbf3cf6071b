// SPDX-License-Identifier: Apache-2.0
#include "render/pack.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "core/error.h"
#include "device/profiler.h"
#include "render/light_table.h"

namespace eikon {
namespace {

// Bits of features.def.
enum : std::uint32_t {
#define EK_LOBE(name, bit) kLobe_##name = 1U << bit,
#define EK_LIGHT(name, bit) kLight_##name = bit,
#include "shared/features.def"
};
constexpr std::uint64_t kMaxTriangles = std::uint64_t{1} << 28;  // what the layouts of the trees can name

double mean(const glm::vec3& colour) { return (double(colour.x) + double(colour.y) + double(colour.z)) / 3.0; }

MaterialRecord pack_material(const Material& material) {
  MaterialRecord record{};
  record.albedo_r = material.base_color.x;
  record.albedo_g = material.base_color.y;
  record.albedo_b = material.base_color.z;
  record.emission_r = material.emission.x;
  record.emission_g = material.emission.y;
  record.emission_b = material.emission.z;
  record.lobes = kLobe_diffuse;
  record.double_sided = material.double_sided ? 1 : 0;
  return record;
}

glm::vec3 to_world(const glm::dmat4& world_from_object, const glm::vec3& p) {
  return glm::vec3(glm::dvec3(world_from_object * glm::dvec4(glm::dvec3(p), 1.0)));
}

// To the front, as long as twice the area.
glm::dvec3 triangle_normal(const Triangle& t) {
  const glm::dvec3 p0(t.p0_x, t.p0_y, t.p0_z), p1(t.p1_x, t.p1_y, t.p1_z), p2(t.p2_x, t.p2_y, t.p2_z);
  return glm::cross(p1 - p0, p2 - p0);
}

// Light sampling derives a light's normal in floats. A needle for which that fails is not sampled: light_pdf_m2 stays 0, and
// what scattered rays find of it counts in full.
bool can_be_sampled(const Triangle& t, const glm::dvec3& normal) {
  const glm::vec3 p0(t.p0_x, t.p0_y, t.p0_z);
  const glm::dvec3 rounded(glm::cross(glm::vec3(t.p1_x, t.p1_y, t.p1_z) - p0, glm::vec3(t.p2_x, t.p2_y, t.p2_z) - p0));
  return glm::length(glm::normalize(rounded) - glm::normalize(normal)) < 0x1p-14;  // false for NaN
}

class Packer {
 public:
  Packer(const Scene& scene, const Features& features, PackedScene& out)
      : scene_(scene), out_(out), with_normals_(features.has("vertex_normal")) {}

  void triangles() {
    std::size_t count = 0;
    for (const Node& node : scene_.nodes)
      for (const Primitive& primitive : scene_.meshes[node.mesh].primitives) count += primitive.indices.size() / 3;
    // Records, normals, and the corners that the tree is built from.
    const std::uint64_t bytes =
        count * (sizeof(Triangle) + (with_normals_ ? sizeof(TriangleNormals) : 0) + 9 * sizeof(float));
    const std::uint64_t memory = std::uint64_t(sysconf(_SC_PHYS_PAGES)) * std::uint64_t(sysconf(_SC_PAGESIZE));
    if (count > kMaxTriangles || bytes > memory)
      throw InputError(fmt::format(
          "{}: {} triangles in all nodes need {} MB of {} MB and are {} at most; use fewer instances or simpler meshes",
          scene_.path.string(), count, bytes >> 20, memory >> 20, kMaxTriangles));
    out_.triangles.reserve(count);
    if (with_normals_) out_.normals.reserve(count);
    for (std::size_t n = 0; n < scene_.nodes.size(); ++n)
      for (const Primitive& primitive : scene_.meshes[scene_.nodes[n].mesh].primitives)
        add_primitive(scene_.nodes[n], std::uint32_t(n), primitive);
  }

  void lights(const Settings& settings) {
    std::vector<double> powers;
    std::vector<double> areas;
    std::vector<double> by_material(scene_.materials.size(), 0.0);
    std::vector<std::uint32_t> material_of_light;
    for (std::size_t i = 0; i < out_.triangles.size(); ++i) {
      const Triangle& t = out_.triangles[i];
      const Material& material = scene_.materials[t.material];
      const double radiance = mean(material.emission);
      if (!(radiance > 0)) continue;
      const glm::dvec3 normal = triangle_normal(t);
      const double area = 0.5 * glm::length(normal);
      if (!(area > 0) || !can_be_sampled(t, normal)) continue;
      Light light{};
      light.p0_x = t.p0_x, light.p0_y = t.p0_y, light.p0_z = t.p0_z;
      light.p1_x = t.p1_x, light.p1_y = t.p1_y, light.p1_z = t.p1_z;
      light.p2_x = t.p2_x, light.p2_y = t.p2_y, light.p2_z = t.p2_z;
      light.emission_r = material.emission.x, light.emission_g = material.emission.y,
      light.emission_b = material.emission.z;
      light.double_sided = material.double_sided ? 1 : 0;
      light.kind = kLight_area;
      light.triangle = std::uint32_t(i);
      out_.lights.push_back(light);
      areas.push_back(area);
      powers.push_back(std::numbers::pi * area * radiance * (material.double_sided ? 2 : 1));
      by_material[t.material] += powers.back();
      material_of_light.push_back(t.material);
    }
    const double sky = mean(settings.environment.radiance);
    if (sky > 0) {
      // What enters the sphere around the scene; a scene without extent is lit by the environment alone.
      const double radius = out_.bounds.empty() ? 0 : 0.5 * glm::length(out_.bounds.hi - out_.bounds.lo);
      Light light{};
      light.kind = kLight_environment;
      out_.lights.push_back(light);
      areas.push_back(0);
      powers.push_back(radius > 0 ? 4 * std::numbers::pi * std::numbers::pi * radius * radius * sky : sky);
    }
    if (out_.lights.empty()) return;
    const LightTable table = build_light_table(powers);
    if (table.buckets.empty()) throw InternalError("lights without power");
    out_.light_buckets = table.buckets;
    std::vector<double> probability(scene_.materials.size(), 0.0);
    for (std::size_t i = 0; i < out_.lights.size(); ++i) {
      Light& light = out_.lights[i];
      if (light.kind == kLight_environment) {
        out_.environment_probability = float(table.probability[i]);
        out_.light_summary.push_back({"environment", powers[i], table.probability[i]});
        continue;
      }
      light.pdf_m2 = float(table.probability[i] / areas[i]);
      out_.triangles[light.triangle].light_pdf_m2 = light.pdf_m2;
      probability[material_of_light[i]] += table.probability[i];
    }
    for (std::size_t m = 0; m < by_material.size(); ++m)
      if (by_material[m] > 0)
        out_.light_summary.push_back(
            {fmt::format("material '{}'", scene_.materials[m].name), by_material[m], probability[m]});
  }

 private:
  void add_primitive(const Node& node, std::uint32_t node_index, const Primitive& primitive) {
    const glm::dmat4& m = node.world_from_object;
    std::vector<glm::vec3> world;
    world.reserve(primitive.positions_object.size());
    for (const glm::vec3& p : primitive.positions_object) {
      world.push_back(to_world(m, p));
      for (int axis = 0; axis < 3; ++axis) {
        out_.bounds.lo[axis] = std::min(out_.bounds.lo[axis], double(world.back()[axis]));
        out_.bounds.hi[axis] = std::max(out_.bounds.hi[axis], double(world.back()[axis]));
      }
    }
    const glm::dmat3 linear(m);
    const bool mirrored = node.mirrored;
    std::vector<glm::vec3> normals;
    if (with_normals_ && !primitive.normals_object.empty()) {
      // The cofactor matrix is the inverse transpose times the determinant: defined for flat scales too.
      const glm::dmat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                                glm::cross(linear[0], linear[1]));
      for (const glm::vec3& n : primitive.normals_object) {
        const glm::dvec3 turned = cofactor * glm::dvec3(n) * (mirrored ? -1.0 : 1.0);
        const double length = glm::length(turned);
        normals.push_back(length > 0 ? glm::vec3(turned / length) : glm::vec3(0));
      }
    }
    for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
      const std::uint32_t a = primitive.indices[i];
      const std::uint32_t b = primitive.indices[i + (mirrored ? 2 : 1)], c = primitive.indices[i + (mirrored ? 1 : 2)];
      Triangle t{};
      t.p0_x = world[a].x, t.p0_y = world[a].y, t.p0_z = world[a].z;
      t.p1_x = world[b].x, t.p1_y = world[b].y, t.p1_z = world[b].z;
      t.p2_x = world[c].x, t.p2_y = world[c].y, t.p2_z = world[c].z;
      t.material = primitive.material;
      t.node = node_index;
      const glm::dvec3 cross = triangle_normal(t);
      const double length = glm::length(cross);
      if (length > 0) t.n_x = float(cross.x / length), t.n_y = float(cross.y / length), t.n_z = float(cross.z / length);
      out_.triangles.push_back(t);
      if (!with_normals_) continue;
      TriangleNormals n{};  // all zero: shading_normal falls back to the geometric one
      if (!normals.empty()) {
        n.n0_x = normals[a].x, n.n0_y = normals[a].y, n.n0_z = normals[a].z;
        n.n1_x = normals[b].x, n.n1_y = normals[b].y, n.n1_z = normals[b].z;
        n.n2_x = normals[c].x, n.n2_y = normals[c].y, n.n2_z = normals[c].z;
      }
      out_.normals.push_back(n);
    }
  }

  const Scene& scene_;
  PackedScene& out_;
  bool with_normals_;
};

}  // namespace

std::uint64_t PackedScene::bytes(const std::string& layout) const {
  const auto accel = accels.find(layout);
  return triangles.size() * sizeof(Triangle) + normals.size() * sizeof(TriangleNormals) +
         materials.size() * sizeof(MaterialRecord) + lights.size() * sizeof(Light) +
         light_buckets.size() * sizeof(LightBucket) + (accel == accels.end() ? 0 : accel->second.bytes());
}

PackedScene pack_scene(const Scene& scene, const Features& features, const Settings& settings) {
  PackedScene packed;
  for (const Material& material : scene.materials) packed.materials.push_back(pack_material(material));
  if (packed.materials.empty()) packed.materials.push_back(MaterialRecord{});
  Packer packer(scene, features, packed);
  packer.triangles();
  packer.lights(settings);
  return packed;
}

void add_accel(PackedScene& packed, const std::string& accel, const std::string& layout, unsigned threads) {
  if (packed.accels.count(layout) != 0) return;
  const double begin = host_seconds();
  std::vector<float> positions;
  positions.reserve(packed.triangles.size() * 9);
  for (const Triangle& t : packed.triangles)
    positions.insert(positions.end(), {t.p0_x, t.p0_y, t.p0_z, t.p1_x, t.p1_y, t.p1_z, t.p2_x, t.p2_y, t.p2_z});
  AccelOptions options;
  options.accel = accel;
  options.layout = layout;
  options.threads = threads;
  packed.accels.emplace(layout, build_accel({positions}, options));
  packed.build_s += host_seconds() - begin;
}

}  // namespace eikon
