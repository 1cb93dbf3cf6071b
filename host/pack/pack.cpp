// SPDX-License-Identifier: Apache-2.0
#include "pack/pack.h"

#include "core/clock.h"
#include "pack/origin.h"
#include "pack/pack_parts.h"
#include "scene/scene_memory.h"

namespace eikon {

std::uint64_t PackedScene::texel_count() const {
  std::uint64_t count = 0;
  for (const std::span<const std::uint32_t> part : texels) count += part.size();
  return count;
}

std::uint64_t PackedScene::instanced_triangle_count() const {
  std::uint64_t count = triangle_count();
  for (const StoredMesh& mesh : stored_meshes) count -= mesh.count;
  for (const InstanceRecord& instance : instances) count += stored_meshes[instance.mesh].count;
  return count;
}

std::uint64_t PackedScene::motion_bytes() const {
  return motion.size() * sizeof(std::uint32_t) + pose_triangles.size() * sizeof(Triangle) +
         pose_normals.size() * sizeof(TriangleNormals) + pose_tangents.size() * sizeof(TriangleTangents) +
         light_poses.size() * sizeof(Light) + next_corners.size() * sizeof(std::uint32_t);
}

std::uint64_t PackedScene::bytes(const std::string& layout) const {
  const auto accel = accels.find(layout);
  return triangles.size() * sizeof(Triangle) + shapes.size() * sizeof(ShapeRecord) +
         normals.size() * sizeof(TriangleNormals) + tangents.size() * sizeof(TriangleTangents) +
         colors.size() * sizeof(TriangleColors) + materials.size() * sizeof(MaterialRecord) +
         material_extensions.size() * sizeof(MaterialExtension) + material_details.size() * sizeof(MaterialDetail) +
         textures.size() * sizeof(TextureRecord) + texel_count() * sizeof(std::uint32_t) +
         lights.size() * sizeof(Light) + light_nodes.size() * sizeof(LightNode) +
         light_alias_table.size() * sizeof(AliasEntry) + emission_alias_table.size() * sizeof(AliasEntry) +
         (emission_pdf.size() + emission_aim.size()) * sizeof(float) + motion_bytes() +
         environment_texels.size() * sizeof(float4) + environment_alias_table.size() * sizeof(AliasEntry) +
         (accel == accels.end() ? 0 : accel->second.bytes());
}

namespace {

/// release: as of pack_geometry
PackedScene pack(const Scene& scene, std::vector<Mesh>* release, const Features& features, const Settings& settings) {
  PackedScene packed;
  packed.pose_steps = scene.shutter.steps;
  pack_materials(scene, features, packed);
  pack_geometry(scene, release, features, packed);
  pack_shapes(scene, features, packed);
  pack_lights(scene, features, settings, packed);
  if (features.has(Feature::moving_surface)) pack_motion(scene, features, packed);
  if (features.has(Feature::motion)) pack_next_corners(scene, features, packed);
  return packed;
}

}  // namespace

PackedScene pack_in_world(const Scene& scene, const Features& features, const Settings& settings) {
  return pack(scene, nullptr, features, settings);
}

PackedScene pack_scene(const Scene& scene, const Features& features, const Settings& settings) {
  const glm::dvec3 origin = origin_of(scene);
  if (origin == glm::dvec3(0)) return pack_in_world(scene, features, settings);
  // The copy shares geometry and pictures with the scene.
  PackedScene packed = pack(seen_from_origin(scene, origin), nullptr, features, settings);
  packed.origin = origin;
  return packed;
}

PackedScene pack_and_release(Scene& scene, const Features& features, const Settings& settings) {
  if (scene.memory) scene.memory->forget_primitives();
  const glm::dvec3 origin = origin_of(scene);
  if (origin != glm::dvec3(0)) scene = seen_from_origin(std::move(scene), origin);
  PackedScene packed = pack(scene, &scene.meshes, features, settings);
  packed.origin = origin;
  scene.poses.clear();
  scene.next.reset();
  if (origin != glm::dvec3(0)) scene = seen_from_origin(std::move(scene), -origin);
  return packed;
}

std::shared_ptr<PackedScene> share(PackedScene packed, std::shared_ptr<const void> owner) {
  struct Owned {
    std::shared_ptr<const void> owner;
    PackedScene packed;  // destroyed before what it refers to
  };
  const auto owned = std::make_shared<Owned>(Owned{std::move(owner), std::move(packed)});
  return {owned, &owned->packed};
}

LightOverview look_at_light(const Scene& scene, const Features& features, const Settings& settings) {
  LightOverview light;
  pack_materials(scene, features, light.packed);
  const std::uint64_t lights = summarise_lights(scene, features, settings, light.packed);
  light.bytes = light.packed.bytes("") + lights;
  return light;
}

TriangleSoup soup_of(const PackedScene& packed) {
  const float* corners = packed.triangles.empty() ? nullptr : &packed.triangles.front().p0_x;
  return {corners, packed.triangles.size(), sizeof(Triangle) / sizeof(float), packed.shapes.size()};
}

void add_accel(PackedScene& packed, const std::string& accel, const std::string& layout, unsigned threads,
               double rays) {
  if (packed.accels.count(layout) != 0) return;
  const double begin = host_seconds();
  const AccelOptions options{accel, layout, threads, rays};
  if (!packed.motion.empty()) {
    packed.accels.emplace(layout, build_over_time(packed, options));
  } else if (packed.instances.empty()) {
    packed.accels.emplace(layout, packed.trees != nullptr ? packed.trees->tree(soup_of(packed), options)
                                                          : build_accel(soup_of(packed), options));
  } else {
    const TwoLevelScene scene{soup_of(packed), packed.shapes.size(), packed.stored_meshes, packed.instances,
                              packed.instance_boxes};
    packed.accels.emplace(layout, build_two_level(scene, options));
  }
  packed.build_s += host_seconds() - begin;
}

}  // namespace eikon
