// SPDX-License-Identifier: Apache-2.0
// Random numbers and directions for tests.
#pragma once
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <numbers>
#include <random>
#include <vector>

namespace eikon::test {

using Random = std::mt19937;

inline double uniform(Random& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}

/// A unit vector, uniform over the sphere.
inline glm::dvec3 random_direction(Random& random) {
  const double z = uniform(random, -1, 1), phi = uniform(random, 0, 2 * std::numbers::pi), s = std::sqrt(1 - z * z);
  return {s * std::cos(phi), s * std::sin(phi), z};
}

inline std::vector<std::uint32_t> random_words(Random& random, std::size_t count) {
  std::vector<std::uint32_t> words(count);
  for (std::uint32_t& word : words) word = std::uint32_t(random());
  return words;
}

}  // namespace eikon::test
