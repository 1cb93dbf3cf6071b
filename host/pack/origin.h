// SPDX-License-Identifier: Apache-2.0
// Scenes far from the origin. Devices compute in floats, whose error grows with the distance from
// it, so such a scene is packed around an origin of its own (PackedScene::origin).
#pragma once
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "pack/settings.h"
#include "scene/scene.h"

namespace eikon {

/// The origin to pack a scene around, in world coordinates: 0 where the scene is not far from there
/// for its size. Parts that have a twentieth of the surfaces or less do not count if the rest is
/// far, and if a camera of the file is nearer to the rest than to 0, or the file has none. The
/// camera of --look-at does not count, so that all pictures of a scene have the same origin. It
/// lies on a grid of a power of two, so that it stays where it is while small things move.
/// more  points at which something will be added to the scene, world
[[nodiscard]] glm::dvec3 origin_of(const Scene& scene, std::span<const glm::dvec3> more = {});

/// The box of each node's mesh in the world. It may be larger than the mesh, of which it turns the
/// box, but each mesh is looked at once however many nodes show it.
[[nodiscard]] std::vector<Bounds> boxes_of_nodes(const Scene& scene);

/// The scene, with its poses, in coordinates that begin at `origin`.
[[nodiscard]] Scene seen_from_origin(Scene scene, const glm::dvec3& origin);

/// The same for cameras.
[[nodiscard]] Settings seen_from_origin(Settings settings, const glm::dvec3& origin);

}  // namespace eikon
