// SPDX-License-Identifier: Apache-2.0
#include "pack/materials/medium_ranks.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "pack/materials/lobe.h"
#include "shared/records.h"

namespace eikon {

std::vector<std::uint32_t> medium_ranks(const Scene& scene) {
  std::vector<bool> shown(scene.materials.size());
  for (const Node& node : scene.nodes)
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives) shown[primitive.material] = true;
  for (const Shape& shape : scene.shapes) shown[shape.material] = true;
  std::vector<std::uint32_t> solids;
  for (std::uint32_t i = 0; i < scene.materials.size(); ++i)
    if (shown[i] && is_solid(scene.materials[i])) solids.push_back(i);
  if (solids.size() > EK_MEDIA_RANKS)
    throw InputError(fmt::format(
        "{}: mediumPriority orders {} solids at most, and materials of {} are shown; let some share one, or "
        "leave the priorities out",
        scene.path.string(), EK_MEDIA_RANKS, solids.size()));
  std::ranges::stable_sort(solids, {}, [&](std::uint32_t i) { return scene.materials[i].medium_priority.value_or(0); });
  std::vector<std::uint32_t> ranks(scene.materials.size());
  for (std::size_t i = 0; i < solids.size(); ++i) ranks[solids[i]] = std::uint32_t(i + 1);
  return ranks;
}

}  // namespace eikon
