// SPDX-License-Identifier: Apache-2.0
// Stage `shade` for the hits of one shading class (hit_queues.h).
#ifndef EK_SHADE_CLASS_H
#define EK_SHADE_CLASS_H
#include "stages/by_class/hit_queues.h"
#include "stages/shade.h"

#if !EK_CHUNKED
#define EK_SHADE_CLASS(name, k)                                                                                              \
  kernel void name(constant Frame* frame, global uint* path_state, global uint* counts, global const uint* queue_hits,       \
                   global float* film_slots, EK_SCENE_ARGUMENTS, EK_LIGHT_ARGUMENTS EK_LOG_ARGUMENT, uint depth) {           \
    SceneData scene = EK_SCENE_DATA;                                                                                         \
    scene.absent_classes = ((1u << SHADING_CLASS_COUNT) - 1u) & ~(1u << (k));                                                \
    const LightData light_data = EK_LIGHT_DATA;                                                                              \
    const StageContext stage = {.frame = frame,                                                                              \
                                .state = chunk_state(path_state),                                                            \
                                .queue = queue_hits + hit_queue_begin(k) + EK_ENTRY,                                         \
                                .film = {film_slots, frame->film_stride} EK_STAGE_LOG};                                      \
    (void)stage_shade(stage, scene, light_data, own_count(hit_counts(counts, depth)[k]), depth);                             \
  }
#else
#define EK_SHADE_CLASS(name, k)
#endif

#endif
