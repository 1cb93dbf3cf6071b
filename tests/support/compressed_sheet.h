// SPDX-License-Identifier: Apache-2.0
// A mesh for the tests of codecs, what is left of it after one, and the lies that a file may tell.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "support/gltf_builder.h"

namespace scene_test {

constexpr std::uint32_t kSide = 6;

/// A bumpy sheet of kSide x kSide vertices with normals and colours.
struct Sheet {
  std::vector<float> positions, normals;
  std::vector<std::uint8_t> colors;  // RGBA
  std::vector<std::uint32_t> indices;
  Sheet() {
    for (std::uint32_t j = 0; j < kSide; ++j) {
      for (std::uint32_t i = 0; i < kSide; ++i) {
        const float x = static_cast<float>(i), y = static_cast<float>(j), z = static_cast<float>((i * j) % 3);
        positions.insert(positions.end(), {x, y, z});
        const float length = std::sqrt(x * x + 1.0F);
        normals.insert(normals.end(), {x / length, 0.0F, 1.0F / length});
        colors.insert(colors.end(), {static_cast<std::uint8_t>(i * 40), static_cast<std::uint8_t>(j * 40), 255, 255});
      }
    }
    for (std::uint32_t j = 0; j + 1 < kSide; ++j) {
      for (std::uint32_t i = 0; i + 1 < kSide; ++i) {
        const std::uint32_t a = j * kSide + i;
        for (const std::uint32_t k : {a, a + 1, a + kSide + 1, a, a + kSide + 1, a + kSide}) indices.push_back(k);
      }
    }
  }
  [[nodiscard]] std::size_t vertex_count() const { return positions.size() / 3; }
};

// Corners of each triangle as a multiset of lines: codecs reorder triangles and vertices, and turn
// corners.
inline std::vector<std::vector<float>> soup(const std::vector<glm::vec3>& positions,
                                            const std::vector<std::uint32_t>& indices) {
  std::vector<std::vector<float>> triangles;
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    std::vector<float> best;
    for (std::size_t turn = 0; turn < 3; ++turn) {
      std::vector<float> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const glm::vec3& p = positions[indices[i + (turn + k) % 3]];
        corners.insert(corners.end(), {p.x, p.y, p.z});
      }
      if (best.empty() || corners < best) best = corners;
    }
    triangles.push_back(best);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

inline std::vector<std::vector<float>> soup(const eikon::Scene& scene) {
  const eikon::Primitive& primitive = scene.meshes.at(0).primitives.at(0);
  return soup(primitive.positions_object, primitive.indices.list());
}

inline std::vector<std::vector<float>> soup(const Sheet& sheet) {
  std::vector<glm::vec3> positions;
  for (std::size_t i = 0; i < sheet.vertex_count(); ++i) {
    positions.emplace_back(sheet.positions[3 * i], sheet.positions[3 * i + 1], sheet.positions[3 * i + 2]);
  }
  return soup(positions, sheet.indices);
}

/// A change to a File that makes it invalid, and a part of what is said of it.
template <class File>
struct Lie {
  const char* name;
  std::function<void(File&)> tell;
  const char* says;
};

/// Loads a damaged file: either it holds a mesh whose indices are its own, or it is refused in one
/// line.
/// returns whether it was refused
template <class File>
bool refused_or_sound(const File& file) {
  try {
    const eikon::Scene scene = file.load();
    for (const eikon::Primitive& primitive : scene.meshes.at(0).primitives) {
      for (const std::uint32_t index : primitive.indices.list()) EXPECT_LT(index, primitive.positions_object.size());
      for (const glm::vec3& p : primitive.positions_object) EXPECT_TRUE(std::isfinite(p.x + p.y + p.z));
    }
  } catch (const eikon::InputError& e) {
    EXPECT_FALSE(contains(e.what(), "\n"));
    return true;
  }
  return false;
}

}  // namespace scene_test
