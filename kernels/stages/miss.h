// SPDX-License-Identifier: Apache-2.0
// Stage `miss`.   From: paths of this depth whose ray left the scene.
// Adds the environment, weighted against light sampling; a transparent picture shows it to no camera ray. Such paths end here:
// shade.cl drops them.
#ifndef EK_STAGE_MISS_H
#define EK_STAGE_MISS_H
#include "lights/light.h"
#include "surface/medium.h"
#include "stages/wavefront.h"

EK_FN_ONCE void stage_miss(constant Frame* frame, SceneData scene, global const float4* environment_texels, global uint* state,
                           global float* film_slots, global const uint* queue, uint count, uint depth) {
  if (EK_HAS_coverage && depth == 1) return;
  EK_FOR_EACH(slot, count, queue) {
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
        if (EK_HAS_bsdf_emission) scattered = power_heuristic(pdf, sky.pdf * EK_LIGHT_MEAN);
        weight = pdf < 0.0f ? weight : scattered;
      }
      v3 beta = state_3(state, FIELD_beta_r, slot);
      if (EK_HAS_nested_media) {  // Solids are closed, so it has left them, also those whose surface it stepped over.
        beta = scale3(beta, media_radiance_outside(scene, state_u(state, FIELD_medium, slot)));
      } else if (EK_HAS_absorption) {  // out of an open solid: it goes on for ever
        const v3 absorption = medium_absorption(scene, state_u(state, FIELD_medium, slot));
        beta = mul3(beta, transmittance(absorption, EK_INFINITY));
      }
      film_add_light(film_slots, frame->film_stride, escaped, state_u(state, FIELD_path, slot), depth - 1,
                     EK_HAS_nested_media ? state_u(state, FIELD_crossed, slot) : (vu)(0u), (vu)(EK_ENVIRONMENT_GROUP),
                     scale3(mul3(beta, sky.radiance), weight));
    }
  }
}

#endif
