// SPDX-License-Identifier: Apache-2.0
// Makes the pilot of a render: on a thread of its own, because a driver may hang, and on the first device that can.
#pragma once
#include <atomic>

#include "render/device_worker.h"
#include "render/render.h"

namespace eikon {

/// Lets a pilot learn how to guide paths, or takes the one that the hooks know, and guides the devices by it.
/// prepared  a device that hangs gets an error, so that it takes no further part
/// report    gets the pilot's; PilotReport::cut_short if `stop` was set or RenderHooks::latest_s came before it ended
/// throws DeviceError when no device can: without a pilot, the image would not have the bits of its other parts
void guide_paths(WavefrontDevices& devices, std::vector<DeviceReport>& prepared, const std::atomic<bool>& stop,
                 const RenderHooks& hooks, RenderReport& report);

}  // namespace eikon
