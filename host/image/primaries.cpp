// SPDX-License-Identifier: Apache-2.0
#include "image/primaries.h"

#include <cmath>

#include "core/error.h"

namespace eikon {
namespace {

glm::dvec3 xyz_of(const glm::dvec2& xy) { return {xy.x, xy.y, 1 - xy.x - xy.y}; }

/// The matrix that takes (1, 1, 1) to the white of luminance 1.
glm::dmat3 xyz_from(const Chromaticities& primaries) {
  const glm::dmat3 columns(xyz_of(primaries.red), xyz_of(primaries.green), xyz_of(primaries.blue));
  const glm::dvec3 white = xyz_of(primaries.white) / primaries.white.y;
  const glm::dvec3 parts = glm::inverse(columns) * white;
  const bool usable = std::abs(glm::determinant(columns)) > 1e-6 && primaries.white.y > 1e-6 && parts.x > 0 &&
                      parts.y > 0 && parts.z > 0 && std::isfinite(parts.x + parts.y + parts.z);
  if (!usable) throw InputError("states primaries that make no white; save it as linear Rec. 709");
  return {columns[0] * parts.x, columns[1] * parts.y, columns[2] * parts.z};
}

// The responses in which Bradford's adaptation scales them [Lam 1985, "Metamerism and Colour
// Constancy"].
const glm::dmat3 kResponses{{0.8951, -0.7502, 0.0389}, {0.2664, 1.7135, -0.0685}, {-0.1614, 0.0367, 1.0296}};

}  // namespace

bool is_rec709(const Chromaticities& primaries) {
  const auto near = [](const glm::dvec2& a, const glm::dvec2& b) {
    return std::abs(a.x - b.x) < 1e-3 && std::abs(a.y - b.y) < 1e-3;
  };
  return near(primaries.red, kRec709.red) && near(primaries.green, kRec709.green) &&
         near(primaries.blue, kRec709.blue) && near(primaries.white, kRec709.white);
}

glm::dmat3 rec709_from(const Chromaticities& primaries) {
  const glm::dmat3 from = xyz_from(primaries), to = xyz_from(kRec709);
  const glm::dvec3 white(1), given = kResponses * (from * white), wanted = kResponses * (to * white);
  glm::dmat3 scales(0);
  for (int c = 0; c < 3; ++c) scales[c][c] = wanted[c] / given[c];
  return glm::inverse(to) * glm::inverse(kResponses) * scales * kResponses * from;
}

}  // namespace eikon
