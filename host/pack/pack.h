// SPDX-License-Identifier: Apache-2.0
// A scene laid out for devices: immutable, shared by all of them.
#pragma once
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "accel/accel.h"
#include "accel/refit.h"
#include "accel/two_level.h"
#include "core/device_vector.h"
#include "pack/features.h"
#include "pack/lights/light_kind.h"
#include "scene/scene.h"
#include "shared/records.h"

namespace eikon {

/// A light for people to read about. Quantities are means of R, G and B, in watts, or in lumens if
/// the file means those.
struct PackedLight {
  LightKind kind{};        // `area` stands for all triangles and shapes of a material
  std::string name{};      // of the material or light; empty for a constant environment
  double flux = 0;         // that it gives off, W; of a distant light what enters the sphere around the scene
  double area_m2 = 0;      // of an area light
  double strength = 0;     // LightKindInfo says of what, and the unit
  double probability = 0;  // of being sampled
};

/// The arrays that are uploaded to devices, and what the host needs beside them to trace, guide and
/// report.
struct PackedScene {
  // Triangles of the world, then triangles of the stored meshes in object space, then a record for
  // each shape.
  DeviceVector<Triangle> triangles;
  std::vector<StoredMesh> stored_meshes;   // meshes that are stored once for all their instances
  DeviceVector<InstanceRecord> instances;  // of them; `root` is set when a tree is built
  std::vector<InstanceBox> instance_boxes;  // of each instance
  DeviceVector<ShapeRecord> shapes;
  std::vector<formula::Formula> formulas;  // of implicit surfaces
  // One per triangle, or empty if no feature needs them.
  DeviceVector<TriangleNormals> normals;
  DeviceVector<TriangleTangents> tangents;
  DeviceVector<TriangleColors> colors;
  std::vector<MaterialRecord> materials;
  std::vector<MaterialExtension> material_extensions;  // one per material, or empty
  std::vector<MaterialDetail> material_details;        // likewise
  std::vector<TextureRecord> textures;                 // one per use of an image
  // The words of `texels` in order: EK_TEXEL_TABLE of them, then the images and measured tables.
  // Empty without those. These are views of the Scene, which must live as long, so that the
  // pictures are not copied.
  std::vector<std::span<const std::uint32_t>> texels;
  DeviceVector<Light> lights;
  std::vector<AliasEntry> light_alias_table;  // of lights; its first entry is the light tree, if there is one
  std::vector<LightNode> light_nodes;         // of the light tree, over the first tree_light_count lights
  std::uint32_t tree_light_count = 0;
  float light_scale = 1;                            // from metres to the unit of the nodes
  DeviceVector<float4> environment_texels;          // of a map: radiance, and the density of light sampling per sr
  std::vector<AliasEntry> environment_alias_table;  // of the texels
  // With feature light_paths; empty where no light reaches anything that reflects or refracts
  // exactly.
  std::vector<AliasEntry> emission_alias_table;  // of lights, by which light paths start
  std::vector<float> emission_pdf;               // probability of each light, of triangles per m^2
  std::vector<float> emission_aim;  // of each: density of directions to the targets, per sr, a power of two
  std::vector<float4> light_targets;             // balls, world: centre and radius
  /// In proportion to the light paths that are aimed at each target if they start evenly: from
  /// points, and of parallel light, in turn.
  std::vector<double> light_target_shares;
  bool has_specular_light_targets = false;       // is_specular_light_target of some material
  std::vector<PackedLight> light_summary;        // one per emissive material, other light, and the environment
  // Triangles and lights that move while the shutter is open (kernels/surface/motion.h,
  // kernels/lights/light.h).
  std::uint32_t pose_steps = 0;           // steps of the shutter's time; 0: nothing moves
  DeviceVector<std::uint32_t> motion;     // empty: no triangle moves
  DeviceVector<Triangle> pose_triangles;  // as among `triangles`, but for the corners and n_x: twice the area there
  DeviceVector<TriangleNormals> pose_normals;
  DeviceVector<TriangleTangents> pose_tangents;
  DeviceVector<Light> light_poses;
  DeviceVector<std::uint32_t> next_corners;  // of layer `motion` (kernels/film/motion_vector.h)
  std::map<std::string, Accel> accels;  // by layout
  std::shared_ptr<TreeMemory> trees{};  // of other frames of the file; null: there are none
  std::uint64_t two_level_saving = 0;   // rough bytes that two levels would save; 0 if there are two
  float environment_probability = 0;    // that light sampling chooses the environment
  float environment_emission = 0;       // that a light path starts from its map, over that probability
  glm::dvec3 origin{0.0};               // world: where the coordinates of all that is here begin (origin.h)
  Bounds bounds;                        // of the triangles and shapes, from `origin`; empty when there are none
  double build_s = 0;                   // time to build the trees

  [[nodiscard]] std::uint64_t texel_count() const;
  [[nodiscard]] std::size_t triangle_count() const { return triangles.size() - shapes.size(); }
  /// Triangles with each instance counted.
  [[nodiscard]] std::uint64_t instanced_triangle_count() const;
  /// For each triangle that moves 1 + its first record among those of poses, 0 for others. `motion`
  /// is not empty.
  [[nodiscard]] const std::uint32_t* first_records() const { return motion.data() + motion[1]; }
  /// Bytes of what moves, on a device.
  [[nodiscard]] std::uint64_t motion_bytes() const;
  /// Bytes on a device, textures included.
  [[nodiscard]] std::uint64_t bytes(const std::string& layout) const;
};

/// The array of the scene's triangles and shapes, for builders.
[[nodiscard]] TriangleSoup soup_of(const PackedScene& packed);

/// The words of PackedScene::motion, as kernels/surface/motion.h describes them.
/// records  as of PackedScene::first_records()
[[nodiscard]] DeviceVector<std::uint32_t> motion_table(std::uint32_t steps, std::span<const std::uint32_t> records);

/// A tree of the triangles that stand still, and one of those that move; brute force takes both
/// together.
[[nodiscard]] Accel build_over_time(const PackedScene& packed, const AccelOptions& options);

/// Lays out everything but the trees. With feature `instance` the meshes that allow it are stored
/// once (instanced_meshes.h). The result refers to pictures of `scene`.
/// throws InputError when the triangles of all instances are more than trees or memory can hold
PackedScene pack_scene(const Scene& scene, const Features& features, const Settings& settings);
PackedScene pack_scene(Scene&& scene, const Features& features, const Settings& settings) = delete;

/// Does the same in the file's own coordinates, however far from the origin, for tests of what
/// kernels make of those.
PackedScene pack_in_world(const Scene& scene, const Features& features, const Settings& settings);

/// Does the same, and frees the geometry of the meshes as it goes: their primitives keep only the
/// materials. Its poses are freed, too.
PackedScene pack_and_release(Scene& scene, const Features& features, const Settings& settings);

/// Shares a packed scene that keeps alive what it refers to.
/// owner  of the scene that it was packed from; null: the scene outlives all who share it
[[nodiscard]] std::shared_ptr<PackedScene> share(PackedScene packed, std::shared_ptr<const void> owner);

/// The most bytes of records of what moves while the shutter is open: of all triangles of the nodes
/// that move, at each pose.
[[nodiscard]] std::uint64_t pose_bytes(const Scene& scene, const Features& features);

/// Holds what `eikon info` tells of the light in a scene.
struct LightOverview {
  PackedScene packed;  // bounds, shapes, materials and light_summary are those of pack_scene; no triangles, no lights
  std::uint64_t bytes = 0;  // of `packed` and the lights, on a device
};

/// Looks at the light in a scene without laying it out, in memory that does not grow with the
/// lights. throws InputError as pack_scene does
LightOverview look_at_light(const Scene& scene, const Features& features, const Settings& settings);
LightOverview look_at_light(Scene&& scene, const Features& features, const Settings& settings) = delete;

/// Builds the tree that `layout` (of tree_layouts(), or "none") needs, unless it is there. rays:
/// expected to be traced
void add_accel(PackedScene& packed, const std::string& accel, const std::string& layout, unsigned threads,
               double rays = 0);

}  // namespace eikon
