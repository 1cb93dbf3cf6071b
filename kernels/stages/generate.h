// SPDX-License-Identifier: Apache-2.0
// Stage `generate`.   To: all paths of the unit, at depth 1.
// Starts one path per (pixel, sample): the pixel filter gives its place on the film, and the camera
// its ray. Writes the path's state and clears its film slots.
#ifndef EK_STAGE_GENERATE_H
#define EK_STAGE_GENERATE_H
#include "film/camera.h"
#include "film/filter.h"
#include "lanes/sampler.h"
#include "lights/density.h"
#include "stages/wavefront.h"

/// The pixels and samples that paths start from.
typedef struct {
  global const uint* pixels;         // x | y << 16 of each pixel of the unit
  global const float* filter_table;  // filter.h
#if EK_HAS_camera_motion
  global const float* camera_poses;  // camera.h
#endif
} PathSource;

/// Share of the shutter's time that has passed when the light of a path meets the film, [0, 1).
EK_FN vf path_time(vu key, vu index) {
  vf time = (vf)(0.0f), unused;
  if (EK_HAS_camera_motion | EK_HAS_moving_surface | EK_HAS_moving_light)
    sample_2d(key, index, DIM_TIME_DISPERSION, &time, &unused);
  return time;
}

EK_FN CameraPose camera_at(constant Frame* frame, PathSource source, vf time) {
#if EK_HAS_camera_motion
  return moving_camera(frame, source.camera_poses, time);
#else
  return still_camera(frame);
#endif
}

/// first  path of slot 0 of the state: paths first + 0 .. first + count - 1 of the unit
EK_FN_ONCE void stage_generate(StageContext stage, PathSource source, uint first, uint count) {
  constant Frame* frame = stage.frame;
  for (uint slot = 0; slot < count; slot += EK_WIDTH) {
    const vu path = (vu)(first + slot) + LANE_INDEX;
    const uint pixel_count = frame->pixel_count;
    const vu sample = sample_of_path(path, pixel_count);
    const vu pixel = path - sample * pixel_count;
    const vu xy = gather_u(source.pixels, pixel < pixel_count ? pixel : (vu)(0u));
    const vu x = xy & 0xffffu, y = xy >> 16;

    const ReplicateSample in_replicate = replicate_sample(frame, sample);
    const vu index = in_replicate.index;
    const vu key = sample_key(x, y, in_replicate.replicate, frame->seed, frame->sample_high >> frame->replicate_bits);

    vf u, v;
    sample_2d(key, index, DIM_FILTER, &u, &v);
    vf weight = (vf)(1.0f);
    if (EK_HAS_pixel_filter) {
      const FilterSample along_x = filter_sample(source.filter_table, u);
      const FilterSample along_y = filter_sample(source.filter_table, v);
      u = 0.5f + along_x.offset;
      v = 0.5f + along_y.offset;
      weight = along_x.weight * along_y.weight;
    }
    const FilmPoint point = {TO_F(AS_I(x)), TO_F(AS_I(y)), u, v};
    const vf time = path_time(key, index);
    const CameraRay ray = camera_ray(frame, camera_at(frame, source, time), point, key, index);

    const PathState start = {.path = path,
                             .key = key,
                             .index = index,
                             .time = time,
                             .origin = ray.origin,
                             .dir = ray.dir,
                             .beta = V3(weight, weight, weight),
                             .pdf = (vf)(EK_NO_DENSITY),
#if EK_HAS_path_log
                             .plain_pdf = (vf)(EK_NO_DENSITY),
#endif
                             .expected = (vf)(0.0f),
                             .light_ratio = (vf)(0.0f),
                             .source_group = (vu)(0u),
                             .medium = (vu)(frame->camera_medium),
                             .hit_triangle = (vu)(EK_NO_HIT)};
    path_store(stage.state, slot, packing_all(), start);
#if EK_HAS_path_log
    for (uint depth = 0; depth < EK_LOG_DEPTHS; ++depth)
      store_u(stage.log.words + (size_t)(depth * LOG_WORDS + LOG_info) * stage.log.stride + first + slot, (vu)(0u));
#endif
    for (uint plane = 0; plane < SLOT_PLANES; ++plane)
      store_f(film_plane(stage.film, plane) + first + slot, (vf)(0.0f));
  }
}

#endif
