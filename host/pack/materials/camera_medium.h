// SPDX-License-Identifier: Apache-2.0
// Finds the solid that a camera or a light stands in.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>

#include "pack/pack.h"

namespace eikon {

/// 1 + the index of the material whose solid contains `eye`; 0 if none does. Of several solids it
/// is the innermost, which a ray along `view` leaves first. A point is inside if the triangles of a
/// material wind around it more than half a time. So holes and cracks do no harm, as they would if
/// crossings were counted along one ray. It takes a few nanoseconds per triangle of a solid.
/// source  [Jacobson, Kavan, Sorkine-Hornung 2013, "Robust Inside-Outside Segmentation using
///         Generalized Winding Numbers", section 3]; solid angles: [van Oosterom, Strackee 1983,
///         "The Solid Angle of a Plane Triangle"]
[[nodiscard]] std::uint32_t solid_around(const PackedScene& packed, const glm::dvec3& eye, const glm::dvec3& view);

/// The same for a scene of which nothing but shapes and materials is packed (look_at_light). Here
/// meshes count whatever openings they have.
[[nodiscard]] std::uint32_t solid_around(const Scene& scene, const PackedScene& light, const glm::dvec3& eye,
                                         const glm::dvec3& view);

/// The medium of a path that begins at `eye` (medium.h). It is 0 if nothing absorbs, because then
/// it does not matter. If solids have ranks, it is the list of those that contain the eye
/// (nested_media.h).
[[nodiscard]] std::uint32_t camera_medium(const PackedScene& packed, const glm::dvec3& eye, const glm::dvec3& view);

}  // namespace eikon
