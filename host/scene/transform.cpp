// SPDX-License-Identifier: Apache-2.0
#include "scene/transform.h"

#include <cmath>

namespace eikon {

glm::dmat4 rotation_matrix(const glm::dvec4& xyzw) {
  // It is divided by its largest component first, so that the squares neither overflow nor vanish.
  const glm::dvec4 size = glm::abs(xyzw);
  const glm::dvec4 q = xyzw / glm::max(glm::max(size.x, size.y), glm::max(size.z, size.w));
  const double x = q.x, y = q.y, z = q.z, w = q.w;
  const double s = 2 / (x * x + y * y + z * z + w * w);
  return {glm::dvec4{1 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y), 0},
          glm::dvec4{s * (x * y - w * z), 1 - s * (x * x + z * z), s * (y * z + w * x), 0},
          glm::dvec4{s * (x * z + w * y), s * (y * z - w * x), 1 - s * (x * x + y * y), 0}, glm::dvec4{0, 0, 0, 1}};
}

glm::dmat4 transform_matrix(const glm::dvec3& translation, const glm::dvec4& rotation_xyzw, const glm::dvec3& scale) {
  glm::dmat4 matrix = rotation_matrix(rotation_xyzw);
  for (int axis = 0; axis < 3; ++axis) matrix[axis] *= scale[axis];
  matrix[3] = glm::dvec4(translation, 1.0);
  return matrix;
}

bool is_finite(const glm::dmat4& matrix) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      if (!std::isfinite(matrix[column][row])) return false;
    }
  }
  return true;
}

glm::dmat3 cofactors(const glm::dmat3& m) {
  return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

glm::dvec3 direction_of(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 && std::isfinite(length) ? v / length : glm::dvec3(0);
}

}  // namespace eikon
