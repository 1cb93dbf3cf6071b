// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "device/device.h"
#include "pack/pack.h"
#include "wavefront/wavefront_config.h"

namespace eikon {

/// The tree that a device's rays meet. throws InternalError where packing built none of its layout
const Accel& accel_of(const PackedScene& scene, const WavefrontConfig& config);

/// What one device's program is made of: text and defines decide its machine code, and nothing else does.
struct WavefrontProgram {
  std::vector<std::string> stages;  // kernels of stages.def that the scene needs, run as configured
  std::string text;
  std::string formula_code;  // the part of the text that the scene's implicit surfaces are
  ProgramOptions options;

  WavefrontProgram(const DeviceInfo& info, const WavefrontConfig& config, const PackedScene& scene,
                   const Features& features, const Execution& execution);
};

}  // namespace eikon
