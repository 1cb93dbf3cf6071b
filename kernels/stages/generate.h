// SPDX-License-Identifier: Apache-2.0
// Stage `generate`.   To: all paths of the unit, at depth 1.
// Starts one path per (pixel, sample): film position by the pixel filter, camera ray. Writes the path's
// state and clears its film slots.
#ifndef EK_STAGE_GENERATE_H
#define EK_STAGE_GENERATE_H
#include "film/camera.h"
#include "film/filter.h"
#include "lanes/sampler.h"
#include "stages/wavefront.h"

// first  path of slot 0 of `state`: paths first + 0 .. first + count - 1 of the unit
EK_FN_ONCE void stage_generate(constant Frame* frame, global const uint* pixels, global uint* state, global float* film_slots,
                               global const float* filter_table, uint first, uint count) {
  EK_FOR_EACH_NEW(slot, count) {
    const vu path = (vu)(first + slot) + LANE_INDEX;
    // path = sample * pixel_count + pixel. The quotient is exact: below 2^23 the float error is less than half a step.
    const uint pixel_count = frame->pixel_count;
    const vu sample = AS_U(TO_I((TO_F(AS_I(path)) + 0.5f) / (vf)((float)pixel_count)));
    const vu pixel = path - sample * pixel_count;
    const vu xy = gather_u(pixels, pixel < pixel_count ? pixel : (vu)(0u));
    const vu x = xy & 0xffffu, y = xy >> 16;

    const uint bits = frame->replicate_bits;
    const vu sample_low = (vu)(frame->sample_begin) + sample;
    const uint high = frame->sample_high;
    const vu replicate = sample_low & ((1u << bits) - 1u);
    const vu index = bits == 0 ? sample_low : (sample_low >> bits) | (high << (32u - bits));
    const vu key = sample_key(x, y, replicate, frame->seed, high >> bits);

    vf u, v;
    sample_2d(key, index, DIM_FILTER, &u, &v);
    const vf one = (vf)(1.0f);
    vf weight = one;
    if (EK_HAS_pixel_filter) {
      const FilterSample along_x = filter_sample(filter_table, u), along_y = filter_sample(filter_table, v);
      u = 0.5f + along_x.offset;
      v = 0.5f + along_y.offset;
      weight = along_x.weight * along_y.weight;
    }
    const CameraRay ray = camera_ray(frame, TO_F(AS_I(x)), TO_F(AS_I(y)), u, v, key, index);

    state_set_u(state, FIELD_path, slot, path);
    state_set_u(state, FIELD_key, slot, key);
    state_set_u(state, FIELD_index, slot, index);
    state_set_3(state, FIELD_origin_x, slot, ray.origin);
    state_set_3(state, FIELD_dir_x, slot, ray.dir);
    state_set_3(state, FIELD_beta_r, slot, V3(weight, weight, weight));
    state_set_f(state, FIELD_pdf, slot, -one);
    state_set_u(state, FIELD_hit_triangle, slot, (vu)(EK_NO_HIT));
    if (EK_HAS_absorption | EK_HAS_nested_media) state_set_u(state, FIELD_medium, slot, (vu)(frame->camera_medium));
    if (EK_HAS_nested_media) state_set_u(state, FIELD_crossed, slot, (vu)(0u));
    for (uint c = 0; c < FILM_PLANES; ++c)
      store_f(film_slots + (size_t)c * frame->film_stride + first + slot, (vf)(0.0f));
  }
}

#endif
