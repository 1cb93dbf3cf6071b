// SPDX-License-Identifier: Apache-2.0
#include "wavefront/program.h"

#include <fmt/format.h>

#include "core/error.h"
#include "device/kernel_sources.h"

namespace eikon {

const Accel& accel_of(const PackedScene& scene, const WavefrontConfig& config) {
  const auto found = scene.accels.find(config.layout);
  if (found == scene.accels.end()) throw InternalError(fmt::format("no tree of layout '{}' was built", config.layout));
  return found->second;
}

WavefrontProgram::WavefrontProgram(const DeviceInfo& info, const WavefrontConfig& config, const PackedScene& scene,
                                   const Features& features, const Execution& execution)
    : formula_code(features.formula_code()),
      options(program_options(info, config, features, accel_of(scene, config), execution)) {
  std::vector<std::string> files;
#define EK_STAGE(name) \
  if (needs_stage(config, features, #name)) stages.push_back(#name), files.push_back("stages/" #name ".cl");
#include "shared/stages.def"
  files.push_back("probe/probes.cl");
  text = kernel_text(files) + formula_code;
}

}  // namespace eikon
