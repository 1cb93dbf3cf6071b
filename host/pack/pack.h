// SPDX-License-Identifier: Apache-2.0
// A scene laid out for devices: immutable, shared by all of them.
#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>

#include "accel/accel.h"
#include "accel/two_level.h"
#include "core/device_vector.h"
#include "pack/features.h"
#include "scene/scene.h"
#include "shared/records.h"

namespace eikon {

/// What is said of a light; quantities are means of R, G and B, in watts, or in lumens if that is what the file means.
struct PackedLight {
  std::string kind{};  // of features.def; "area" for all triangles of a material
  std::string name{};  // of the material or light; empty for a constant environment
  double flux = 0;     // that it gives off, W; of distant light what enters the sphere around the scene
  double area_m2 = 0;  // of an area light
  // Point, spot: intensity, W / sr; directional: irradiance, W / m^2; else mean radiance, W / (sr m^2).
  double strength = 0;
  double probability = 0;  // of being sampled
};

struct PackedScene {
  // Of the world; behind them of meshes that are stored once, in their own space; behind them the records of shapes.
  DeviceVector<Triangle> triangles;
  std::vector<StoredMesh> stored_meshes;    // those meshes,
  DeviceVector<InstanceRecord> instances;   // and where they stand: all but `root`, which hangs on the tree
  std::vector<PlaceBox> place_boxes;        // of each instance
  DeviceVector<ShapeRecord> shapes;
  std::vector<formula::Formula> formulas;  // of implicit surfaces
  // One per triangle, or empty where features.def says that nothing needs them.
  DeviceVector<TriangleNormals> normals;
  DeviceVector<TriangleTangents> tangents;
  DeviceVector<TriangleColors> colors;
  std::vector<MaterialRecord> materials;
  std::vector<MaterialExtension> material_extensions;  // one per material, or empty
  std::vector<MaterialDetail> material_details;        // the same
  std::vector<TextureRecord> textures;                 // one per use of an image
  // The words of `texels` in order: EK_TEXEL_TABLE of them, then the images and measured tables. Views of the Scene, which must live as long: one
  // copy of the pictures is enough. Empty without textures and tables.
  std::vector<std::span<const std::uint32_t>> texels;
  DeviceVector<Light> lights;
  std::vector<AliasEntry> light_alias_table;        // with a tree: the tree, then lights that have no place
  std::vector<LightNode> light_nodes;            // of the tree, if there is one, over the first lights
  std::uint32_t tree_light_count = 0;            // how many those are
  float light_scale = 1;                         // metres to the unit of the nodes
  DeviceVector<float4> environment_texels;       // of a map: radiance; density of light sampling per sr
  std::vector<AliasEntry> environment_alias_table;  // choice among them
  std::vector<PackedLight> light_summary;        // one per emissive material, other light, and the environment
  std::map<std::string, Accel> accels;           // by layout
  std::uint64_t saved_once = 0;                  // bytes that two levels would save, roughly; 0 where there are two
  float environment_probability = 0;             // of light sampling choosing the environment
  Bounds bounds;                                 // of the triangles and shapes; empty when there are none
  double build_s = 0;

  [[nodiscard]] std::uint64_t texel_count() const;
  [[nodiscard]] std::size_t triangle_count() const { return triangles.size() - shapes.size(); }
  /// The triangles of all places of all meshes.
  [[nodiscard]] std::uint64_t seen_triangle_count() const;
  /// On a device, textures included.
  [[nodiscard]] std::uint64_t bytes(const std::string& layout) const;
};

/// The array of the scene's triangles and shapes, for builders.
[[nodiscard]] TriangleSoup soup_of(const PackedScene& packed);

/// Lays out everything but the trees; with feature `instance` in two levels where that can be (placed_meshes.h). The result refers to pictures of `scene`. throws InputError when the instances of all meshes are more triangles than trees or memory can hold.
PackedScene pack_scene(const Scene& scene, const Features& features, const Settings& settings);
PackedScene pack_scene(Scene&& scene, const Features& features, const Settings& settings) = delete;

/// The same, but frees what the meshes hold as it goes: of their primitives only the materials are left.
PackedScene pack_and_release(Scene& scene, const Features& features, const Settings& settings);

/// Adds the tree that `layout` (of tree_layouts(), or "none") needs, once.
void add_accel(PackedScene& packed, const std::string& accel, const std::string& layout, unsigned threads,
               double rays = 0);

}  // namespace eikon
