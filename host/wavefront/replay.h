// SPDX-License-Identifier: Apache-2.0
// A single sample of a pixel, watched while it is traced: --pixel --sample.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace eikon {

/// The state of a single path between stages, for --pixel --sample.
struct PathVertex {
  std::uint32_t depth = 0;
  glm::vec3 origin, dir, beta;
  float t = 0;
  std::uint32_t triangle = 0;  // EK_NO_HIT: none
};

/// The light of one sample of a pixel, by where it comes from.
struct ReplayedSample {
  glm::vec3 radiance{0.0F};  // that the path from the camera brings
  /// The light that one light path of that sample index brings to the pixel.
  struct Splat {
    glm::vec3 radiance{0.0F};
    std::uint32_t scatterings = 0;  // of the light path, the last one towards the camera included
  };
  std::vector<Splat> splats;  // the brightest first
};

/// The splats of a list, of a unit whose pixel owns all light paths of a sample index.
/// words  SPLAT_WORDS of each; paths: number of the light paths
[[nodiscard]] std::vector<ReplayedSample::Splat> replayed_splats(std::span<const std::uint32_t> words,
                                                                 std::uint64_t paths);

}  // namespace eikon
