// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "device/device_pool.h"
#include "io/json_text.h"
#include "view/scenery.h"
#include "wavefront/wavefront.h"

namespace eikon {

/// Traces the path of a sample of the picture again:
///   "vertices"  [{"pixel", "point", "distance"}]: where the path was, from the camera on; pixel
///               and distance may be null
///   "radiance"  that it brings, "light_paths" that light paths of the same sample bring to the
///               pixel
/// throws UsageError, DeviceError
[[nodiscard]] Json traced_path(const Scenery& scenery, const DevicePool& devices, const PixelSample& at);

}  // namespace eikon
