// SPDX-License-Identifier: Apache-2.0
// Random numbers and directions for tests.
#pragma once
#include <cmath>
#include <glm/glm.hpp>
#include <random>

namespace eikon {

using Random = std::mt19937;

inline double uniform(Random& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}

inline glm::dvec3 direction(Random& random) {
  const double z = uniform(random, -1, 1), phi = uniform(random, 0, 6.283185307), s = std::sqrt(1 - z * z);
  return {s * std::cos(phi), s * std::sin(phi), z};
}

}  // namespace eikon
