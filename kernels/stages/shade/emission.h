// SPDX-License-Identifier: Apache-2.0
// Step of stage `shade`: adds what the hit surfaces emit, and what unlit ones show, to the film
// slots.
#ifndef EK_SHADE_EMISSION_H
#define EK_SHADE_EMISSION_H
#include "stages/shade/light_ratio.h"
#if EK_HAS_shape & EK_HAS_shape_light
#include "lights/shape_light.h"
#endif

/// Density with which light sampling chooses the direction of a hit on an emissive surface [1/sr];
/// 0 for what is never sampled.
/// emits  mask of the lanes that need it
EK_FN vf emission_light_pdf_sr(const ShadeContext* c, const PathHit* hit, uint slot, vi emits) {
  vf pdf = pdf_sr_from_m2(hit->corners.light_pdf_m2, hit->surface.n_geom, hit->path.dir, hit->t);
#if EK_HAS_shape & EK_HAS_shape_light
  const vi is_shape = is_shape_record(hit->corners);
  if (ANY(emits & is_shape)) {
    const ShapeLightHit shape_hit = {.is_shape = is_shape, .at = hit->on_shape, .part = hit->u};
    const vf of_shape = shape_light_pdf_sr(c->scene, hit->corners, shape_hit, hit->path.origin, hit->path.dir);
    pdf = is_shape ? of_shape : pdf;
  }
#endif
#if EK_HAS_light_tree && EK_HAS_bsdf_emission
  const PathState path = path_load(c->stage.state, slot);  // again, because few vectors come here
  const LightSampleContext context = {path.origin, path.packed_normal};
  const vi weighted = emits & has_density(hit->path.pdf) & (pdf > 0.0f);
  const vu light = hit->corners.flags >> EK_TRIANGLE_LIGHT_SHIFT;
  pdf = pdf * light_tree_probability(c->lights.light_nodes, c->stage.frame->tree_light_count,
                                     c->stage.frame->light_scale, context, weighted, light);
#endif
  return pdf;
}

EK_FN Contribution emission_contribution(const PathHit* hit, const ShadingPoint* point, vi live, v3 radiance) {
  const Contribution light = {
      .live = live,
      .path = hit->path.path,
      .uncounted = point->interface.null_interface_count,
      .group = (hit->corners.flags >> EK_TRIANGLE_GROUP_SHIFT) & (EK_LIGHT_GROUPS_MOST - 1u),
      .radiance = radiance};
  return light;
}

/// Weight of the emission that a path meets against light sampling. pdf: as PathState.pdf
EK_FN vf emission_weight(const PathHit* hit, vf pdf, vf light_pdf) {
  const vf one = (vf)(1.0f);
  if (!EK_HAS_next_event) return one;
  // A light that is never sampled (pack_lights.cpp) counts in full either way.
  const vf scattered = EK_HAS_bsdf_emission ? power_heuristic(pdf, light_pdf)
                       : hit->corners.light_pdf_m2 > 0.0f ? (vf)(0.0f) : one;
  return has_no_density(pdf) ? one : scattered;
}

/// Adds the emission of the hits, weighted against light sampling where that could have found them.
EK_FN void add_emission(const ShadeContext* c, const PathHit* hit, const HitMaterial* material,
                        const ShadingPoint* point, uint slot) {
  const vi emits = hit->live & emits_towards(hit->surface.n_geom, material->double_sided, hit->path.dir) &
                   (max_component(material->emission) > 0.0f);
  if (!ANY(emits)) return;
  const vf light_pdf = EK_HAS_next_event ? emission_light_pdf_sr(c, hit, slot, emits) * EK_LIGHT_MEAN : (vf)(0.0f);
#if EK_HAS_light_paths
  const vf share = emission_share(c, hit, emits);
#else
  const vf share = (vf)(1.0f);
#endif
  const vf weight = emission_weight(hit, hit->path.pdf, light_pdf) * share;
#if EK_HAS_path_log
  const vf plain_weight = emission_weight(hit, hit->path.plain_pdf, light_pdf) * share * point->transmitted;
  log_set_f(c->stage.log, c->depth, LOG_emitted, emits, hit->path.path, luminance(material->emission) * plain_weight);
#endif
  const v3 radiance = scale3(mul3(point->beta, material->emission), weight);
  film_add_light(c->stage.film, c->depth - 1, emission_contribution(hit, point, emits, radiance));
}

/// Adds the colour of unlit surfaces, and ends their paths. The camera sees them, directly or
/// through mirrors and windows; they light nothing else.
EK_FN void add_unlit(const ShadeContext* c, const PathHit* hit, const HitMaterial* material, ShadingPoint* point) {
  const vi unlit = hit->live & material->unlit;
  if (ANY(unlit)) {
    const v3 radiance = mul3(point->beta, material->bsdf.base_color);
    const vi shown = unlit & has_no_density(hit->path.pdf);
    film_add_light(c->stage.film, c->depth - 1, emission_contribution(hit, point, shown, radiance));
  }
  point->live = point->live & !material->unlit;
}

#endif
