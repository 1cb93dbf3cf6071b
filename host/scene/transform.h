// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>

namespace eikon {

/// The rotation of a quaternion (x, y, z, w) of any length but 0. Quarter turns come out exact.
[[nodiscard]] glm::dmat4 rotation_matrix(const glm::dvec4& xyzw);

/// Translation * rotation * scale [glTF 2.0, section 3.5.3].
[[nodiscard]] glm::dmat4 transform_matrix(const glm::dvec3& translation, const glm::dvec4& rotation_xyzw,
                                          const glm::dvec3& scale);

/// A point of another space, in double.
[[nodiscard]] inline glm::dvec3 transform_point(const glm::dmat4& matrix, const glm::dvec3& p) {
  return glm::dvec3(matrix * glm::dvec4(p, 1.0));
}

[[nodiscard]] bool is_finite(const glm::dmat4& matrix);

/// The matrix of cofactors: where m takes u and v, it takes their cross product, so it takes
/// normals of surfaces. It is defined for flat scales, too.
[[nodiscard]] glm::dmat3 cofactors(const glm::dmat3& m);

/// v with length 1, or 0 if it has no direction. It is computed in double, because the square of a
/// float may overflow or vanish.
[[nodiscard]] glm::dvec3 direction_of(const glm::dvec3& v);

}  // namespace eikon
