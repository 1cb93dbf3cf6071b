// SPDX-License-Identifier: Apache-2.0
// The probe of where light paths start.
#pragma once
#include <vector>

#include "guide/light_aim.h"
#include "kernels/probe.h"
#include "shared/records.h"

namespace eikon::test {

/// The probe with the functions of light_path_probes.cl. aim: by default starts are even
inline Probe light_path_probe(const std::vector<float4>& targets, const LightAim& aim = {}) {
  Frame frame{};
  frame.light_target_count = std::uint32_t(targets.size());
  frame.scene_half = {3, 4, 12, 0};
  Probe probe("light_path");
  probe.define("EK_HAS_light_paths", "1").append_file("lights/light_path_probes.cl");
  probe.buffer("frame", std::vector<Frame>{frame}).buffer("targets", targets).buffer("aim", aim.words);
  return probe;
}

}  // namespace eikon::test
