// SPDX-License-Identifier: Apache-2.0
// Places of meshes that are stored once, as devices and builders of trees see them.
#pragma once
#include <vector>

#include "pack/pack.h"
#include "pack/geometry/placed_meshes.h"

namespace eikon {

/// All but `root`.
[[nodiscard]] InstanceRecord instance_record(const MeshPlace& place, const PlacedMesh& mesh);

/// A box around all corners at each place; and `bounds` grows to hold them all, to the bit as if each had been added.
[[nodiscard]] std::vector<PlaceBox> place_boxes(const Scene& scene, const PlacedMeshes& placed, Bounds& bounds);

}  // namespace eikon
