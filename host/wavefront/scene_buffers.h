// SPDX-License-Identifier: Apache-2.0
// The buffers with the scene on one device.
#pragma once
#include <cstdint>
#include <span>

#include "device/device.h"
#include "pack/pack.h"

namespace eikon {

/// Makes buffers of the scene's arrays, the tree and the filter's table, and names them in
/// `arguments`. A CPU device reads the arrays in place, so they must live, unchanged, as long as
/// the buffers.
/// returns  the bytes of all buffers, copied or not
/// throws   DeviceError
std::uint64_t upload_scene(Device& device, const PackedScene& scene, const Accel& accel,
                           const std::vector<float>& filter, Arguments& arguments);

/// Makes only those buffers that tracing rays and sampling lights read. throws DeviceError
void upload_tree_and_lights(Device& device, const PackedScene& scene, const Accel& accel, Arguments& arguments);

}  // namespace eikon
