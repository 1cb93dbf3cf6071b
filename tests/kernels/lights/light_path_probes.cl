// SPDX-License-Identifier: Apache-2.0
// Probes of where light paths start, behind the text of probes.cl.
#include "lights/light_path.h"
#if EK_HAS_light_paths
EK_FN LightData probe_targets(global const float4* targets, global const uint* aim) {
  const LightData lights = {.light_paths = {.light_targets = targets, .light_aim = aim}};
  return lights;
}
#define TARGET_PROBE(name)                                                                                         \
  kernel void name(PROBE_ARGUMENTS, constant Frame* frame, global const float4* targets, global const uint* aim) { \
    name##_run(PROBE_PASSED, frame, probe_targets(targets, aim));                                                  \
  }

// Inputs: a point, three random numbers. Outputs: a direction from there to the targets, its
// density per sr, and the name of the start.
EK_FN_ONCE void probe_target_directions_run(PROBE_ITEMS, constant Frame* frame, LightData lights) {
  vu start;
  const v3 dir = direction_to_targets(frame, lights, IN_3(0), IN_3(3), &start);
  OUT_3(0, dir);
  OUT_F(3, target_pdf_sr(frame, lights, IN_3(0), dir));
  OUT_U(4, start);
}
TARGET_PROBE(probe_target_directions)

// Inputs: a direction of parallel light, three random numbers. Outputs: the origin of a light path,
// its density per m^2, and the name of the start.
EK_FN_ONCE void probe_target_origins_run(PROBE_ITEMS, constant Frame* frame, LightData lights) {
  vu start;
  const v3 p = point_of_discs(frame, lights, IN_3(0), IN_3(3), &start);
  OUT_3(0, before_scene(frame, p, IN_3(0)));
  OUT_F(3, parallel_pdf_m2(frame, lights, p, IN_3(0)));
  OUT_U(4, start);
}
TARGET_PROBE(probe_target_origins)

// Inputs: a point, a direction. Output: the density of the direction per sr.
EK_FN_ONCE void probe_target_pdf_sr_run(PROBE_ITEMS, constant Frame* frame, LightData lights) {
  OUT_F(0, target_pdf_sr(frame, lights, IN_3(0), IN_3(3)));
}
TARGET_PROBE(probe_target_pdf_sr)

// Inputs: a direction of parallel light, a point. Output: the density of light paths there per m^2.
EK_FN_ONCE void probe_parallel_pdf_m2_run(PROBE_ITEMS, constant Frame* frame, LightData lights) {
  OUT_F(0, parallel_pdf_m2(frame, lights, IN_3(3), IN_3(0)));
}
TARGET_PROBE(probe_parallel_pdf_m2)
#endif
