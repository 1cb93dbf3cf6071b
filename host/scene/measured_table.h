// SPDX-License-Identifier: Apache-2.0
// A measured material as kernels read it: its values, and the distributions of half vectors by
// which it is sampled.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "shared/measured.h"

namespace eikon {

struct MeasuredTable {
  std::string name;                  // of its file, in quotes
  std::vector<std::uint32_t> words;  // EK_MEASURED_WORDS floats: shared/measured.h
  std::size_t holes = 0;             // entries above the surface without a measurement: they reflect nothing
  /// The albedo of each view at the middle of its cosines, by the midpoint rule over the cells:
  /// within about 1 %.
  std::array<glm::dvec3, EK_MEASURED_VIEWS> albedos{};

  [[nodiscard]] static double cosine(std::size_t view) { return (double(view) + 0.5) / EK_MEASURED_VIEWS; }
  /// The view with the largest albedo in some channel.
  [[nodiscard]] std::size_t brightest_view() const;
};

/// Makes a table of values as read_merl gives them. Interpolation at grazing angles meets entries
/// for which a direction lies below the surface; they become those of the next smaller theta_d
/// above it. Negative entries above the surface become 0.
[[nodiscard]] MeasuredTable make_measured_table(std::vector<float> rgb);

}  // namespace eikon
