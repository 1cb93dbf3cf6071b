// SPDX-License-Identifier: Apache-2.0
// A replay of a single sample of a pixel (--pixel --sample) reports the vertices of its path, and
// the light that it brings.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace eikon {

/// An edge of the path, after stage `intersect`: from one vertex to the next.
struct PathVertex {
  std::uint32_t depth = 0;     // of the edge; 1: from the camera
  glm::dvec3 origin;           // where the ray begins; world space, metres
  glm::vec3 dir;               // unit, world space
  glm::vec3 beta;              // throughput of the path before what the ray hits scatters it
  float t = 0;                 // distance to what the ray hits, metres
  std::uint32_t triangle = 0;  // number of what the ray hits; EK_NO_HIT: it leaves the scene
};

/// The light of one sample of a pixel, by where it comes from.
struct ReplayedSample {
  glm::vec3 radiance{0.0F};  // of the path from the camera, W/(sr m^2)
  /// The light that one light path of that sample index brings to the pixel.
  struct Splat {
    glm::vec3 radiance{0.0F};
    std::uint32_t scatterings = 0;  // of the light path, the last one towards the camera included
  };
  std::vector<Splat> splats;  // the brightest first
};

/// Reads the splats of a unit of one pixel that owns all light paths of a sample index. Each
/// splat's radiance is divided by the number of these paths, as the film does.
/// words  SPLAT_WORDS words of each splat
/// paths  number of the light paths
[[nodiscard]] std::vector<ReplayedSample::Splat> replayed_splats(std::span<const std::uint32_t> words,
                                                                 std::uint64_t paths);

}  // namespace eikon
