// SPDX-License-Identifier: Apache-2.0
// Instances of meshes that are stored once, in the form for devices and for builders of trees.
#pragma once
#include <vector>

#include "pack/pack.h"
#include "pack/geometry/placed_meshes.h"

namespace eikon {

/// Everything but `root`, which is set when a tree is built.
[[nodiscard]] InstanceRecord instance_record(const MeshPlace& place, const PlacedMesh& mesh);

/// The box of each instance. `bounds` grows to contain them, to the bit as if each corner had been
/// added.
[[nodiscard]] std::vector<PlaceBox> place_boxes(const Scene& scene, const PlacedMeshes& placed, Bounds& bounds);

}  // namespace eikon
