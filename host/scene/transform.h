// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>

namespace eikon {

/// The rotation of a quaternion (x, y, z, w) of any length but 0. Quarter turns come out exact.
[[nodiscard]] glm::dmat4 rotation_matrix(const glm::dvec4& xyzw);

/// Translation * rotation * scale [glTF 2.0, section 3.5.3].
[[nodiscard]] glm::dmat4 transform_matrix(const glm::dvec3& translation, const glm::dvec4& rotation_xyzw,
                                          const glm::dvec3& scale);

[[nodiscard]] bool is_finite(const glm::dmat4& matrix);

}  // namespace eikon
