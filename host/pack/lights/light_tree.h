// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "shared/records.h"

namespace eikon {

/// A light that has a place, as the tree sees it: kernels/lights/light_tree.h.
struct LightMoments {
  double power = 0;        // any unit, > 0
  glm::dvec3 centroid{0};  // mean of the places that emit, world, metres
  double variance = 0;     // mean square of their distance from the centroid, m^2
  // The mean of the directions that its surface faces: its length is 1 for a flat surface, and 0
  // for a closed surface, a point, and a surface that emits to both sides.
  glm::dvec3 mean_direction{0};
};

struct LightTree {
  std::vector<LightNode> nodes;      // one fewer than lights; in order of depth, left before right
  std::vector<std::uint32_t> order;  // lights in the order of leaves
  float scale = 1;                   // from metres to the nodes' unit, a power of two
};

/// A tree over lights. The same bits for the same lights, and scaling them by a power of two
/// changes `scale` alone.
/// lights  are worked on in place, and freed: move them here where there are millions
/// throws InternalError for moments that are not finite, power that is not positive, or more than
/// 2^28 lights
LightTree build_light_tree(std::vector<LightMoments> lights);

}  // namespace eikon
