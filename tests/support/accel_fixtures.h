// SPDX-License-Identifier: Apache-2.0
// Triangle soups for the tests of trees and traversal.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "accel/accel.h"

namespace eikon::fixtures {

using Soup = std::vector<float>;

inline void add_triangle(Soup& soup, const float (&a)[3], const float (&b)[3], const float (&c)[3]) {
  for (const auto* p : {&a, &b, &c}) soup.insert(soup.end(), *p, *p + 3);
}

/// A closed sphere of 2 * rings * 2 * rings triangles whose radius per vertex is radius(ring,
/// segment); watertight, since shared vertices have the same bits. The rows at the poles are
/// degenerate on one side.
template <class Radius>
Soup sphere(int rings, const Radius& radius, const double (&center)[3] = {0, 0, 0}) {
  const double pi = std::acos(-1.0);
  std::vector<std::array<float, 3>> vertices;
  const int segments = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < segments; ++j) {
      const bool pole = i == 0 || i == rings;
      const double theta = pi * i / rings, phi = pole ? 0 : 2 * pi * j / segments;
      const double r = radius(i, pole ? 0 : j), s = pole ? 0 : std::sin(theta);
      vertices.push_back({static_cast<float>(center[0] + r * s * std::cos(phi)),
                          static_cast<float>(center[1] + r * (i == 0 ? 1
                                                              : pole ? -1
                                                                     : std::cos(theta))),
                          static_cast<float>(center[2] + r * s * std::sin(phi))});
    }
  }
  Soup soup;
  const auto add = [&](int i, int j) {
    const auto& v = vertices[static_cast<std::size_t>(i * segments + j % segments)];
    soup.insert(soup.end(), v.begin(), v.end());
  };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < segments; ++j) {
      add(i, j), add(i + 1, j), add(i + 1, j + 1);
      add(i, j), add(i + 1, j + 1), add(i, j + 1);
    }
  }
  return soup;
}

/// `count` triangles of very different sizes, scattered over [-scale, scale]^3.
inline Soup scattered(std::size_t count, float scale, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  Soup soup;
  for (std::size_t i = 0; i < count; ++i) {
    const float size = scale * std::exp2(-6.0F + 4.0F * unit(random));
    const float center[3] = {scale * unit(random), scale * unit(random), scale * unit(random)};
    for (int k = 0; k < 9; ++k) soup.push_back(center[k % 3] + size * unit(random));
  }
  return soup;
}

/// A room as modelled by hand: a few large triangles among heaps of small ones, in which a greedy
/// builder does badly.
inline Soup room() {
  Soup soup;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  for (int heap = 0; heap < 60; ++heap) {
    const Soup small = scattered(200, 0.4F, 100 + static_cast<std::uint32_t>(heap));
    const float at[3] = {4 * unit(random), 4 * unit(random), 4 * unit(random)};
    for (std::size_t i = 0; i < small.size(); ++i) soup.push_back(small[i] + at[i % 3]);
    for (int k = 0; k < 9; ++k) soup.push_back(4 * unit(random));
  }
  return soup;
}

inline Soup bumpy_sphere(int rings) {
  return sphere(rings, [](int i, int j) { return 1.0 + 0.2 * std::sin(0.37 * i) * std::cos(0.41 * j); });
}

}  // namespace eikon::fixtures
