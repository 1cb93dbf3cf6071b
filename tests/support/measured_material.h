// SPDX-License-Identifier: Apache-2.0
// Measures a material that is known, for the tests of measured ones.
#pragma once
#include <stdexcept>
#include <string>
#include <vector>

#include "device/device.h"
#include "instruments/measure.h"
#include "scene/scene.h"

namespace eikon::test {

/// f of every cell, by the first device that can be used, as `eikon measure` has it: negative where
/// a direction lies below the surface.
inline std::vector<float> measured(const Material& known) {
  for (const DeviceInfo& info : list_devices()) {
    if (!info.unusable.empty()) continue;
    Device device(info);
    Scene scene;
    scene.materials = {known};
    return measure(scene, 0, {0, 0}, device, info.platform.find("Oclgrind") == std::string::npos);
  }
  throw std::runtime_error("no OpenCL device");
}

}  // namespace eikon::test
