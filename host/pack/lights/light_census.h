// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "pack/settings.h"
#include "shared/records.h"

namespace eikon {

/// Corners of a parallelogram: p0 + u (p1 - p0) + v (p2 - p0), u and v in [0, 1], p1 and p2 the ends of its diagonal.
struct Parallelogram {
  glm::vec3 p0, p1, p2;
};

/// Two triangles that share a diagonal and face the same way, as the parallelogram they form to within `slack` times the largest
/// coordinate; nothing if they do not.
std::optional<Parallelogram> parallelogram_of(const std::array<glm::vec3, 3>& a, const std::array<glm::vec3, 3>& b,
                                              double slack);

/// Whether a material's triangles may be sampled two at a time, unless a ray may pass them.
bool emits_evenly(const Material& material);

/// What a scene has of lights, before they are packed.
struct LightCensus {
  std::uint64_t placed = 0;   // emissive triangles and shapes, points, spots
  std::uint64_t distant = 0;  // directional ones and the environment
  std::uint64_t pairs = 0;    // of emissive triangles that form parallelograms; they count twice in `placed`
  bool together = false;      // all that are placed are one mesh's, and small beside the scene
  [[nodiscard]] std::uint64_t places() const { return placed - pairs; }
  /// Whether packing will find one light at most.
  [[nodiscard]] bool is_one() const { return places() + distant <= 1; }
  /// Whether choosing among them for each point is worth its time. The parts of one small lamp are as good as each other.
  [[nodiscard]] bool wants_tree() const { return places() >= 4 && placed <= kMostInTree && !together; }
  static constexpr std::uint64_t kMostInTree = std::uint64_t{1} << (32 - EK_TRIANGLE_LIGHT_SHIFT);
};
LightCensus count_lights(const Scene& scene, const Settings& settings);

}  // namespace eikon
