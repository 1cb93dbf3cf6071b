// SPDX-License-Identifier: Apache-2.0
// Which meshes stand at several places and can be stored once, in two levels of trees (kernels/traverse/traverse_instance.h), or for each place; and
// which of the two a render does. The image has the same bits either way.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "pack/features.h"
#include "pack/settings.h"
#include "gltf/geometry/placed.h"
#include "scene/scene.h"

namespace eikon {

/// A mesh that is or could be stored once, for the nodes that mirror it or for those that do not.
struct PlacedMesh {
  std::uint32_t mesh = 0;
  bool mirrored = false;
  std::vector<bool> dropped = {};  // per triangle of all primitives in order: it has no area, and is in no tree
  std::uint64_t triangles = 0;     // others
  glm::vec3 lo{0.0F}, hi{0.0F};    // of its positions
  glm::vec3 extent{0.0F};          // of the largest box of a triangle
  double least_height = 0;         // of a triangle on its longest side
};

/// A node whose mesh could be stored once.
struct MeshPlace {
  std::uint32_t node = 0, mesh = 0;  // mesh: of PlacedMeshes::meshes
  PlacingMatrix matrix;
  float error = 0;  // InstanceRecord's
};

struct PlacedMeshes {
  std::vector<PlacedMesh> meshes;
  std::vector<MeshPlace> places;       // in the order of the nodes
  std::vector<bool> is_place;          // per node
  std::uint64_t placed_triangles = 0;  // of all places
  std::uint64_t stored_triangles = 0;  // of all meshes here
};

/// The meshes of two nodes and more, but for those that emit (each place is a light of its own), that rays may pass, and that hold a
/// medium (whether a camera is in it is found by counting); and but for nodes that flatten a mesh, or are so far away from it that triangles
/// lose their area to rounding. Of the scene alone: corners at these places have the bits of placed.h, however they are stored.
[[nodiscard]] PlacedMeshes find_placed_meshes(const Scene& scene);

struct InstanceChoice {
  bool two_level = false;
  std::string why;       // "saves 120 MB", "--accel grid has one level", ...
  bool refused = false;  // two levels were asked for, but cannot be had
  std::uint64_t flat_bytes = 0,
                two_level_bytes = 0;  // of what the places and their meshes take, trees included, roughly
};

/// What two levels save of the scene's memory, roughly; 0: nothing.
[[nodiscard]] std::uint64_t bytes_saved_once(const PlacedMeshes& placed, const Features& features);

/// By --instances; with `automatic`, two levels where they save half of the bytes, and so many that it matters.
[[nodiscard]] InstanceChoice choose_instances(const PlacedMeshes& placed, const Features& features,
                                              const Execution& execution);

/// What scene, settings and --instances need of the kernels. choice: what was decided, if wanted
[[nodiscard]] Features features_of(const Scene& scene, const Settings& settings, const Execution& execution,
                                   InstanceChoice* choice = nullptr);

/// Whether trees of this layout can have two levels.
[[nodiscard]] bool has_two_levels(const std::string& layout);

}  // namespace eikon
