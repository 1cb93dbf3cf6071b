// SPDX-License-Identifier: Apache-2.0
// Probes of where light paths start, behind the text of probes.cl.
#include "lights/light_path.h"
#if EK_HAS_light_paths
EK_FN LightData probe_targets(global const float4* targets) {
  const LightData lights = {.light_paths = {.light_targets = targets}};
  return lights;
}

// Inputs: a point, three random numbers. Outputs: a direction from there to the targets, and its density per sr.
EK_FN_ONCE void probe_target_directions_run(PROBE_ITEMS, constant Frame* frame, global const float4* targets) {
  const LightData lights = probe_targets(targets);
  const v3 dir = direction_to_targets(frame, lights, IN_3(0), IN_3(3));
  OUT_3(0, dir);
  OUT_F(3, target_pdf_sr(frame, lights, IN_3(0), dir));
}
kernel void probe_target_directions(PROBE_ARGUMENTS, constant Frame* frame, global const float4* targets) {
  probe_target_directions_run(PROBE_PASSED, frame, targets);
}

// Inputs: a direction of parallel light, three random numbers. Outputs: the origin of a light path, and its density per m^2.
EK_FN_ONCE void probe_target_origins_run(PROBE_ITEMS, constant Frame* frame, global const float4* targets) {
  const LightData lights = probe_targets(targets);
  const v3 p = point_of_discs(frame, lights, IN_3(0), IN_3(3));
  OUT_3(0, before_scene(frame, p, IN_3(0)));
  OUT_F(3, parallel_pdf_m2(frame, lights, p, IN_3(0)));
}
kernel void probe_target_origins(PROBE_ARGUMENTS, constant Frame* frame, global const float4* targets) {
  probe_target_origins_run(PROBE_PASSED, frame, targets);
}
#endif
