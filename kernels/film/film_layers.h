// SPDX-License-Identifier: Apache-2.0
// Layers of the film that show what the camera's ray meets first.
#ifndef EK_FILM_LAYERS_H
#define EK_FILM_LAYERS_H
#include "stages/wavefront.h"

EK_FN void film_set(global float* film_slots, uint film_stride, uint channel, vi live, vu path, vf value) {
#if EK_WIDTH == 1
  if (!live) return;
#endif
  const vu slot = live ? path : (vu)(film_stride - EK_PAD) + LANE_INDEX;
  scatter_f(film_slots + (size_t)channel * film_stride, slot, value);
}

EK_FN void film_set_3(global float* film_slots, uint film_stride, uint channel, vi live, vu path, v3 value) {
  film_set(film_slots, film_stride, channel, live, path, value.x);
  film_set(film_slots, film_stride, channel + 1, live, path, value.y);
  film_set(film_slots, film_stride, channel + 2, live, path, value.z);
}

typedef struct {
  v3 albedo, n_shade, n_geom, p;
  vf t, u, v;
  vu node, material;
} FirstHit;

// share: weight of the path by the pixel filter. Colours and normals are filtered as radiance is; depth, position and place
// in the texture are means over the samples that hit something.
EK_FN void film_first_hit(constant Frame* frame, global float* film_slots, vi live, vu path, vf share, FirstHit hit) {
  const uint stride = frame->film_stride;
  if (EK_HAS_albedo) film_set_3(film_slots, stride, FILM_albedo, live, path, scale3(hit.albedo, share));
  if (EK_HAS_normal) film_set_3(film_slots, stride, FILM_normal, live, path, scale3(hit.n_shade, share));
  if (EK_HAS_geometric_normal)
    film_set_3(film_slots, stride, FILM_geometric_normal, live, path, scale3(hit.n_geom, share));
  if (EK_HAS_depth)
    film_set(film_slots, stride, FILM_depth, live, path, EK_HAS_orthographic ? hit.t + frame->camera_origin.w : hit.t);
  if (EK_HAS_position) film_set_3(film_slots, stride, FILM_position, live, path, hit.p);
  if (EK_HAS_texture_place) {
    film_set(film_slots, stride, FILM_texture_place, live, path, hit.u);
    film_set(film_slots, stride, FILM_texture_place + 1, live, path, hit.v);
  }
  if (EK_HAS_hits) film_set(film_slots, stride, FILM_hits, live, path, (vf)(1.0f));
  if (EK_HAS_coverage) film_set(film_slots, stride, FILM_coverage, live, path, share);
  // The bits of whole numbers, which nothing computes with: 0 stays where a ray met nothing.
  if (EK_HAS_matte_object) film_set(film_slots, stride, FILM_matte_object, live, path, AS_F(hit.node + 1u));
  if (EK_HAS_matte_material) film_set(film_slots, stride, FILM_matte_material, live, path, AS_F(hit.material + 1u));
  if (EK_HAS_id | EK_HAS_material_id) {
    const vi first = (frame->sample_begin | frame->sample_high) == 0 ? live & (path < frame->pixel_count) : (vi)(0);
    if (EK_HAS_id) film_set(film_slots, stride, FILM_id, first, path, TO_F(AS_I(hit.node + 1u)));
    if (EK_HAS_material_id) film_set(film_slots, stride, FILM_material_id, first, path, TO_F(AS_I(hit.material + 1u)));
  }
}

#endif
