// SPDX-License-Identifier: Apache-2.0
// The layers of the film that show what a camera ray meets first.
#ifndef EK_FIRST_HIT_H
#define EK_FIRST_HIT_H
#include "film/fixed_point.h"
#include "film/slots.h"

typedef struct {
  vf filter_weight;  // of the path, by the pixel filter
  v3 albedo, n_shade, n_geom, p;
  vf t;
  vf uv_u, uv_v;     // TEXCOORD_0
  vu node, material;
} FirstHit;

/// Writes the layers of the paths of the mask `live`. Colours, normals and coverage are filtered as
/// radiance is; depth, position and texture coordinates are means over the samples that hit
/// something.
EK_FN void film_first_hit(constant Frame* frame, FilmSlots film, vi live, vu path, FirstHit hit) {
  const vf weight = hit.filter_weight;
  if (EK_HAS_albedo) film_set_3(film, SLOT_albedo, live, path, scale3(hit.albedo, weight));
  if (EK_HAS_normal) film_set_3(film, SLOT_normal, live, path, scale3(hit.n_shade, weight));
  if (EK_HAS_geometric_normal) film_set_3(film, SLOT_geometric_normal, live, path, scale3(hit.n_geom, weight));
  const vf depth = EK_HAS_orthographic ? hit.t + frame->camera_origin.w : hit.t;
  // Places farther away than the film can add are shown as far as it can: a layer takes no light
  // from the picture.
  if (EK_HAS_depth) film_set(film, SLOT_depth, live, path, fixed_clamped(depth));
  if (EK_HAS_position) {
    const v3 p = add3(hit.p, splat3(frame->origin));
    film_set_3(film, SLOT_position, live, path, V3(fixed_clamped(p.x), fixed_clamped(p.y), fixed_clamped(p.z)));
  }
  if (EK_HAS_texcoord) {
    film_set(film, SLOT_texcoord, live, path, hit.uv_u);
    film_set(film, SLOT_texcoord + 1, live, path, hit.uv_v);
  }
  if (EK_HAS_hit_count) film_set(film, SLOT_hit_count, live, path, (vf)(1.0f));
  if (EK_HAS_coverage) film_set(film, SLOT_coverage, live, path, weight);
  // The mattes hold the bits of integers, with which nothing computes; paths that hit nothing keep
  // 0.
  if (EK_HAS_matte_object) film_set(film, SLOT_matte_object, live, path, AS_F(hit.node + 1u));
  if (EK_HAS_matte_material) film_set(film, SLOT_matte_material, live, path, AS_F(hit.material + 1u));
  if (EK_HAS_id | EK_HAS_material_id) {
    const vi first = (frame->sample_begin | frame->sample_high) == 0 ? live & (path < frame->pixel_count) : (vi)(0);
    if (EK_HAS_id) film_set(film, SLOT_id, first, path, TO_F(AS_I(hit.node + 1u)));
    if (EK_HAS_material_id) film_set(film, SLOT_material_id, first, path, TO_F(AS_I(hit.material + 1u)));
  }
}

#endif
