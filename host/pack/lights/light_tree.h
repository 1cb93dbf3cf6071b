// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "shared/records.h"

namespace eikon {

/// What the tree knows of a light that has a place: kernels/lights/light_tree.h.
struct LightMoments {
  double power = 0;      // any unit, > 0
  glm::dvec3 middle{0};  // mean of the places that emit, world, metres
  double spread2 = 0;    // mean square of their distance from the middle, m^2
  // Mean of the directions that its surface faces, of length 0 (a closed surface, a point, both sides of one) to 1.
  glm::dvec3 flow{0};
};

struct LightTree {
  std::vector<LightNode> nodes;      // one fewer than lights; in order of depth, left before right
  std::vector<std::uint32_t> order;  // lights in the order of leaves
  float scale = 1;                   // from metres to the nodes' unit, a power of two
};

/// A tree over lights. The same bits for the same lights, and scaling them by a power of two changes `scale` alone.
/// throws InternalError for moments that are not finite, power that is not positive, or more than 2^28 lights
LightTree build_light_tree(std::span<const LightMoments> lights);

}  // namespace eikon
