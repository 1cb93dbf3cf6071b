// SPDX-License-Identifier: Apache-2.0
// What kernels read of the scene, on one device.
#pragma once
#include <cstdint>
#include <span>

#include "device/device.h"
#include "pack/pack.h"

namespace eikon {

/// Makes the scene's arrays, the tree's and the filter's table into buffers and names them in `arguments`. A CPU device reads the
/// arrays where they are: they must live, unchanged, as long as the buffers. returns bytes, moved or not. throws DeviceError
std::uint64_t upload_scene(Device& device, const PackedScene& scene, const Accel& accel,
                           const std::vector<float>& filter, Arguments& arguments);

/// Only what tracing rays and sampling lights read of it. throws DeviceError
void upload_tree_and_lights(Device& device, const PackedScene& scene, const Accel& accel, Arguments& arguments);

}  // namespace eikon
