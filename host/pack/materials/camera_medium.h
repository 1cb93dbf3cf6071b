// SPDX-License-Identifier: Apache-2.0
// Which solid a camera or a light stands in.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>

#include "pack/pack.h"

namespace eikon {

/// 1 + the index of the material whose solid holds `eye`; 0 where none does. Of solids inside each other the innermost, which is the first that a way along `view` leaves.
/// Inside is where the triangles of a material turn more than half a time around, so that holes, cracks and rays through edges do
/// no harm, as they do where crossings are counted along one ray. A few nanoseconds per triangle of a solid.
/// source  [Jacobson, Kavan, Sorkine-Hornung 2013, "Robust Inside-Outside Segmentation using Generalized Winding Numbers",
///         section 3]; solid angles: [van Oosterom, Strackee 1983, "The Solid Angle of a Plane Triangle"]
[[nodiscard]] std::uint32_t solid_around(const PackedScene& packed, const glm::dvec3& eye, const glm::dvec3& view);

/// The same as a path's medium (medium.h): 0 also where nothing absorbs and it does not matter; of solids that have ranks, a list of
/// those that hold the eye (nested_media.h).
[[nodiscard]] std::uint32_t camera_medium(const PackedScene& packed, const glm::dvec3& eye, const glm::dvec3& view);

}  // namespace eikon
