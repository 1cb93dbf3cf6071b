// SPDX-License-Identifier: Apache-2.0
// Trees in two levels: one for each mesh that is stored once, in its own space, and one of the scene over its places and all other
// triangles and shapes. kernels/traverse/traverse_instance.h says how rays go through them.
#pragma once
#include <glm/glm.hpp>
#include <span>

#include "accel/accel.h"

namespace eikon {

/// Records of a mesh that is stored once.
struct StoredMesh {
  std::size_t first = 0, count = 0;
};

/// World.
struct PlaceBox {
  glm::vec3 lo{0.0F}, hi{0.0F};
};

struct TwoLevelScene {
  TriangleSoup records;  // triangles in the world, then those of the meshes, then shapes
  std::size_t shapes = 0;
  std::span<const StoredMesh> meshes;
  std::span<const InstanceRecord> instances;
  std::span<const PlaceBox> boxes;  // of the instances
};

/// Layouts bvh16, bvh8 and bvh2; Accel::instances are `instances` with their roots. Deterministic for any number of threads.
/// throws UsageError for another layout
[[nodiscard]] Accel build_two_level(const TwoLevelScene& scene, const AccelOptions& options);

}  // namespace eikon
