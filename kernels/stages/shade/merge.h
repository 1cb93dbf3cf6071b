// SPDX-License-Identifier: Apache-2.0
// Step of stage `shade` where photons take part: vertex merging for what is seen through glass or
// in a mirror.
//
// Neither camera paths nor light paths find light that passes glass on both sides of a matte
// surface, if the lamp is small. So a camera path of which every scattering so far was delta
// gathers, at each surface that scatters otherwise, the photons within a radius [Jensen 1996]. The
// mean over the area in place of that at the point is biased; the radius shrinks from one
// generation of samples to the next (host/wavefront/photons/photon_map.h), so the picture converges
// [Knaus and Zwicker 2011].
#ifndef EK_SHADE_MERGE_H
#define EK_SHADE_MERGE_H
#include "lights/light_path.h"
#include "lights/light_ratio_word.h"
#include "lights/photon_map.h"
#include "stages/shade/shading_frame.h"

#if EK_HAS_merging
// Photons on surfaces that are turned further than this, or lie further off the plane, belong to
// other surfaces. Both limits are a choice: they keep what a surface that curves within the radius
// has, and leave out the other wall of a corner. As the radius shrinks they matter ever less.
#define EK_PHOTON_COSINE 0.5f
#define EK_PHOTON_HEIGHT2 0.25f  // square of the height over that of the radius

/// Mask of the surfaces of which all scattering is delta.
EK_FN vi is_purely_delta(const MaterialLanes* m) {
  if (EK_LAYERED) return (vi)(0);
  vi only = (vi)(0);
  if (has_lobe_with(EK_TRAIT_TRANSMITS))
    only = only | (has_trait(m->lobes, EK_TRAIT_TRANSMITS) & (m->transmission >= 1.0f));
  if (has_lobe_with(EK_TRAIT_METALLIC)) only = only | (has_trait(m->lobes, EK_TRAIT_METALLIC) & (m->metallic >= 1.0f));
  if (has_lobe_with(EK_TRAIT_METAL)) only = only | has_trait(m->lobes, EK_TRAIT_METAL);
  return only & is_smooth(*m);
}

/// Replicate of a path's sample.
EK_FN vu replicate_of(constant Frame* frame, vu path) {
  return ((vu)(frame->sample_begin) + sample_of_path(path, frame->pixel_count)) & ((1u << frame->replicate_bits) - 1u);
}

/// Mask of the photons near a point that belong to its surface.
/// first_word  of the photon
EK_FN vi is_photon_at(const ShadeContext* c, const ShadingPoint* point, vu first_word, vu info, vu replicate) {
  constant Frame* frame = c->stage.frame;
  const v3 way = sub3(photon_v3(c->lights.photon_map.photons, first_word), point->p);
  const vf height = dot3(way, point->n_geom), radius2 = (vf)(frame->photon_radius2);
  return (dot3(way, way) <= radius2) & (height * height <= EK_PHOTON_HEIGHT2 * radius2) & (EK_PHOTON_REPLICATE(info) == replicate);
}

/// Adds the light of the photons around each lane's point to its film slots.
EK_FN void add_merged_light(const ShadeContext* c, const PathHit* hit, const ShadingPoint* point) {
  constant Frame* frame = c->stage.frame;
  vi gathers = point->live & (hit->path.light_ratio == EK_SEEN_BY_DELTA) & !is_purely_delta(&point->material);
  if (EK_USES_NULL_INTERFACES) gathers = gathers & !point->interface.is_null;
  if (!ANY(gathers)) return;
  const PhotonMap map = c->lights.photon_map;
  const vu replicate = replicate_of(frame, point->path), bucket = photon_bucket(frame, point->p, replicate);
  const vu end = gathers ? gather_u(map.buckets, bucket + 1u) : (vu)(0u);
  const vu edges = (vu)(c->depth) - point->interface.null_interface_count;
  v3 sum = V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f));
  for (vu at = gathers ? gather_u(map.buckets, bucket) : (vu)(0u); ANY(at < end); at = at + 1u) {
    const vu first_word = gather_u(map.places, at < end ? at : (vu)(0u)) * (uint)PHOTON_WORDS;
    const vu info = gather_u(map.photons, first_word + (uint)PHOTON_info);
    vi near = (at < end) & is_photon_at(c, point, first_word, info, replicate);
    if (!ANY(near)) continue;
    const v3 normal = unpack_normal(gather_u(map.photons, first_word + (uint)PHOTON_normal));
    near = near & (abs_f(dot3(normal, point->n_geom)) > EK_PHOTON_COSINE);
    const vu photon_edges = EK_PHOTON_EDGES(info);
    if (frame->max_depth != 0u) near = near & (edges + photon_edges <= frame->max_depth);
    const v3 dir = photon_v3(map.photons, first_word + (uint)PHOTON_dir_x), wi = to_local(point->basis, dir);
    near = near & is_on_geometric_side(point, wi, dot3(dir, point->n_geom));
    const v3 f = bsdf_evaluate(point->material, point->wo, wi).f;
    const v3 power = photon_v3(map.photons, first_word + (uint)PHOTON_r);
    const v3 arriving = scale3(mul3(point->beta, mul3(f, power)), (vf)(frame->photon_weight));
    sum = select3(near, add3(sum, arriving), sum);
    if (EK_HAS_bounce_bins | EK_HAS_light_group) {
      // The photon's path had photon_edges - 1 surfaces before this one, which the depth of the
      // camera path does not count.
      const Contribution light = {.live = near,
                                  .path = point->path,
                                  .uncounted = point->interface.null_interface_count - (photon_edges - 1u),
                                  .group = EK_PHOTON_GROUP(info),
                                  .radiance = arriving};
      film_add_light_layers(c->stage.film, c->depth, light);
    }
  }
  film_add_3(c->stage.film, SLOT_r, gathers, point->path, sum);
}
#endif

#endif
