// SPDX-License-Identifier: Apache-2.0
// Finds meshes with several instances, and decides whether a render stores them once, in two levels
// of trees (kernels/traverse/traverse_instance.h), or once per instance. The image has the same
// bits either way.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "gltf/geometry/instance_transform.h"
#include "pack/features.h"
#include "pack/pack.h"
#include "pack/settings.h"
#include "scene/scene.h"

namespace eikon {

/// A mesh of several nodes that can be stored once for all of them. Nodes that mirror it and nodes
/// that do not have an entry each.
struct InstancedMesh {
  std::uint32_t mesh = 0;
  bool mirrored = false;
  std::vector<bool> dropped = {};  // per triangle of all primitives in order: true if it has no area, and is in no tree
  std::uint64_t triangles = 0;     // those that are not dropped
  glm::vec3 lo{0.0F}, hi{0.0F};    // bounds of its positions
  glm::vec3 extent{0.0F};          // largest extent of a triangle's box, per axis
  double least_height = 0;         // smallest height of a triangle above its longest side
};

/// An instance of such a mesh: a node that shows it.
struct MeshInstance {
  std::uint32_t node = 0, mesh = 0;  // mesh: of InstancedMeshes::meshes
  InstanceTransform matrix;
  float error = 0;  // InstanceRecord's
};

/// The meshes of a scene that can be stored once, and their instances.
struct InstancedMeshes {
  std::vector<InstancedMesh> meshes;
  std::vector<MeshInstance> instances;    // in the order of the nodes
  std::vector<bool> is_instance;          // per node
  std::uint64_t instanced_triangles = 0;  // of all instances
  std::uint64_t stored_triangles = 0;  // of all meshes here
  std::uint64_t other_triangles = 0;   // of nodes that are no such instances

  /// Triangles that devices get.
  [[nodiscard]] std::uint64_t packed_triangles(bool two_level) const {
    return other_triangles + (two_level ? stored_triangles : instanced_triangles);
  }
};

/// Finds the meshes of two nodes and more. Left out are meshes that emit (each instance is a light
/// of its own), that rays may pass, and that contain a medium (camera_medium.h counts triangles of
/// the world); and nodes that flatten a mesh, or move it so far away that triangles lose their area
/// to rounding; and all where triangles move while the shutter is open. The answer depends on the
/// scene alone, and corners of these instances have the bits of instance_transform.h however they
/// are stored.
[[nodiscard]] InstancedMeshes find_instanced_meshes(const Scene& scene);

/// The decision about --instances: whether such meshes are stored once, in two levels of trees.
struct InstanceChoice {
  bool two_level = false;
  std::string why;       // "saves 120 MB", "--accel grid has one level", ...
  bool refused = false;  // two levels were asked for, but cannot be had
  std::uint64_t flat_bytes = 0, two_level_bytes = 0;  // rough size of instances and their meshes, trees included
};

/// Bytes of a triangle's records on devices.
[[nodiscard]] std::uint64_t triangle_bytes(const Features& features);

/// A rough number of bytes that two levels save.
[[nodiscard]] std::uint64_t two_level_saving(const InstancedMeshes& instanced, const Features& features);

/// Decides by --instances. `automatic` takes two levels if they save half of the bytes, and enough
/// of them to matter.
[[nodiscard]] InstanceChoice choose_instances(const InstancedMeshes& instanced, const Features& features,
                                              const Execution& execution);

/// The features that scene, settings and --instances need. choice: receives the decision, unless
/// null
[[nodiscard]] Features features_of(const Scene& scene, const Settings& settings, const Execution& execution,
                                   InstanceChoice* choice = nullptr);

/// True if trees of this layout can have two levels.
[[nodiscard]] bool has_two_levels(const std::string& layout);

/// Everything but `root`, which is set when a tree is built.
[[nodiscard]] InstanceRecord instance_record(const MeshInstance& instance, const InstancedMesh& mesh);

/// The box of each instance. `bounds` grows to contain them, to the bit as if each corner had been
/// added.
[[nodiscard]] std::vector<InstanceBox> instance_boxes(const Scene& scene, const InstancedMeshes& instanced,
                                                      Bounds& bounds);

}  // namespace eikon
