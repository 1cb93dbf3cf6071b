// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <glm/glm.hpp>

#include "io/json_text.h"
#include "pack/settings.h"
#include "scene/scene.h"

namespace eikon {

/// The choices that a page offers for a scene with these bounds:
///   "name"        of its file
///   "cameras"     [{"name", "eye", "back", "up", "fov": degrees or null}]
///   "view"        the camera in force, likewise
///   "variants"    names
///   "time"        [first, last second] of what moves, or null
///   "environment" its name: of its file, neutral, constant or none
///   "lights"      names of its light groups, if it has several
///   "middle", "radius"  of what the camera may turn around; metres
[[nodiscard]] Json scene_outline(const Scene& scene, const Bounds& bounds, const Settings& settings);

/// Half the diagonal of the box around a scene; metres, above 0.
[[nodiscard]] double radius_of(const Bounds& bounds);

/// Returns the place of a point of world space in the picture, in pixels from its upper left
/// corner; null behind the camera, and for a panorama.
[[nodiscard]] Json pixel_of(const Settings& settings, const glm::dvec3& point);

}  // namespace eikon
