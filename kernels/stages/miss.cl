// SPDX-License-Identifier: Apache-2.0
// Stage `miss`.   From: paths of this depth whose ray left the scene.
// Adds the environment, weighted against light sampling; a transparent picture shows it to no camera ray. Such paths end here:
// shade.cl drops them.
#include "light.h"
#include "medium.h"
#include "wavefront.h"

kernel void miss(constant Frame* frame, global uint* path_state, global const uint* counts, global const uint* queue_rays,
                 global float* film_slots, EK_SCENE_ARGUMENTS, global const float4* environment_texels, uint depth) {
  const SceneData scene = EK_SCENE_DATA;
  global uint* state = chunk_state(path_state);
  const uint count = counts[4 * EK_CHUNK_INDEX + (depth & 1)];
  if (EK_HAS_coverage && depth == 1) return;
  EK_FOR_EACH(slot, count, queue_rays + (depth & 1) * EK_CHUNK) {
    const vi escaped = ((vu)(slot) + LANE_INDEX < (vu)(EK_CHUNKED ? count : slot + 1u)) &
                       (state_u(state, FIELD_hit_triangle, slot) == EK_NO_HIT);
    if (ANY(escaped)) {
      const vf pdf = state_f(state, FIELD_pdf, slot);
      MapValue sky = {splat3(frame->environment), (vf)(0.0f)};
      if (EK_HAS_environment_map)
        sky = environment_map_value(frame, environment_texels, state_3(state, FIELD_dir_x, slot));
      else if (EK_HAS_environment & EK_HAS_next_event & EK_HAS_bsdf_emission)
        sky.pdf = state_f(state, FIELD_pdf_environment, slot);
      vf weight = (vf)(1.0f);
      if (EK_HAS_next_event) {
        vf scattered = (vf)(0.0f);
        if (EK_HAS_bsdf_emission) scattered = power_heuristic(pdf, sky.pdf);
        weight = pdf < 0.0f ? weight : scattered;
      }
      v3 beta = state_3(state, FIELD_beta_r, slot);
      if (EK_HAS_absorption) {  // out of an open solid: it goes on for ever
        const v3 absorption = medium_absorption(scene, state_u(state, FIELD_medium, slot));
        beta = mul3(beta, transmittance(absorption, EK_INFINITY));
      }
      film_add(film_slots, frame->film_stride, FILM_r, escaped, state_u(state, FIELD_path, slot),
               scale3(mul3(beta, sky.radiance), weight));
    }
  }
}
