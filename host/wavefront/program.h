// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "device/device.h"
#include "pack/pack.h"
#include "wavefront/config.h"

namespace eikon {

/// The tree that a device traces rays through. throws InternalError if no tree of its layout was
/// built
const Accel& accel_of(const PackedScene& scene, const WavefrontConfig& config);

/// The source of one device's program. Text and options alone decide its machine code.
struct WavefrontProgram {
  std::vector<std::string> stages;  // kernels of stages.def that the scene needs, run as configured
  std::string text;
  std::string formula_code;  // the part of the text that evaluates the scene's implicit surfaces
  ProgramOptions options;

  WavefrontProgram(const DeviceInfo& info, const WavefrontConfig& config, const PackedScene& scene,
                   const Features& features, const Execution& execution);
};

}  // namespace eikon
