// SPDX-License-Identifier: Apache-2.0
// Trees in two levels: one in object space for each mesh that is stored once, and one over the
// instances and all other triangles and shapes of the scene. kernels/traverse/traverse_instance.h
// traces rays through them.
#pragma once
#include <glm/glm.hpp>
#include <span>

#include "accel/accel.h"

namespace eikon {

/// The triangles [first, first + count) of a mesh that is stored once.
struct StoredMesh {
  std::size_t first = 0, count = 0;
};

/// Box of an instance, world.
struct InstanceBox {
  glm::vec3 lo{0.0F}, hi{0.0F};
};

struct TwoLevelScene {
  TriangleSoup records;  // triangles in the world, then triangles of the meshes, then shapes
  std::size_t shapes = 0;
  std::span<const StoredMesh> meshes;
  std::span<const InstanceRecord> instances;
  std::span<const InstanceBox> boxes;  // of the instances
};

/// Builds layout bvh16, bvh8 or bvh2. Accel::instances are `instances` with their roots. The result
/// does not depend on the number of threads.
/// throws UsageError for another layout
[[nodiscard]] Accel build_two_level(const TwoLevelScene& scene, const AccelOptions& options);

}  // namespace eikon
