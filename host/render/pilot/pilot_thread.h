// SPDX-License-Identifier: Apache-2.0
// Gives a render its pilot before the devices begin: a known one, or one that the first device that
// can renders. It is rendered on a thread of its own, because a call into a driver may never
// return.
#pragma once
#include <atomic>

#include "render/device_worker.h"
#include "render/render.h"

namespace eikon {

/// Finds the image's pilot, if it has one (wants_pilot()), and writes what it decided into
/// devices.features and devices.settings: the number of light paths, and the table that guides
/// paths. The pilot comes from RenderHooks::pilot, or is rendered and handed to
/// RenderHooks::pilot_done.
/// prepared  a device that hangs gets an error, so that it takes no further part
/// report    gets the pilot's; PilotReport::cut_short if `stop` was set or RenderHooks::latest_s
///           came before it ended
/// throws DeviceError when no device can: without a pilot, the image would not have the bits of its
/// other parts
void prepare_pilot(WavefrontDevices& devices, std::vector<DeviceReport>& prepared, const std::atomic<bool>& stop,
                   const RenderHooks& hooks, RenderReport& report);

}  // namespace eikon
