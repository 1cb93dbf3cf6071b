// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "pack/settings.h"
#include "shared/records.h"

namespace eikon {

/// Corners of a parallelogram: p0 + u (p1 - p0) + v (p2 - p0), u and v in [0, 1], p1 and p2 the
/// ends of its diagonal.
struct Parallelogram {
  glm::vec3 p0, p1, p2;
};

/// The parallelogram that two triangles form, if they share a diagonal, face the same way, and fit
/// to within `slack` times the largest coordinate; nothing if they do not.
std::optional<Parallelogram> parallelogram_of(const std::array<glm::vec3, 3>& a, const std::array<glm::vec3, 3>& b,
                                              double slack);

/// True if a material's triangles may be sampled two at a time, unless a ray may pass them.
bool emits_evenly(const Material& material);

/// The lights of a scene before they are packed. Kernels are specialised by these numbers, so
/// packing keeps to them: it may leave out lights without area or power, and adds none.
struct LightCounts {
  std::uint64_t placed = 0;   // lights with a place: emissive triangles and shapes, points, spots
  std::uint64_t distant = 0;  // directional lights and the environment
  std::uint64_t pairs = 0;    // of emissive triangles that form parallelograms; both triangles count in `placed`
  bool together = false;      // all lights with a place are parts of one mesh that is small beside the scene
  [[nodiscard]] std::uint64_t places() const { return placed - pairs; }
  [[nodiscard]] std::uint64_t count() const { return places() + distant; }
  /// True if packing will find one light at most.
  [[nodiscard]] bool is_one() const { return count() <= 1; }
  /// True if a choice for each shading point is worth its time. Of one small lamp every part is as
  /// good as another.
  [[nodiscard]] bool wants_tree() const { return places() >= 4 && placed <= kMaxInTree && !together; }
  static constexpr std::uint64_t kMaxInTree = std::uint64_t{1} << (32 - EK_TRIANGLE_LIGHT_SHIFT);
};
LightCounts count_lights(const Scene& scene, const Settings& settings);

}  // namespace eikon
