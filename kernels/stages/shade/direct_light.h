// SPDX-License-Identifier: Apache-2.0
// Step of stage `shade`: next-event estimation. Samples lights for each shading point, and leaves a
// shadow ray for each sample that could bring light; the ray carries what arrives if nothing is in
// the way.
#ifndef EK_SHADE_DIRECT_LIGHT_H
#define EK_SHADE_DIRECT_LIGHT_H
#include "lights/emission.h"
#include "lights/moving_light.h"
#include "stages/shade/shading_frame.h"
#include "surface/alpha.h"
#if EK_HAS_shape & EK_HAS_shape_light
#include "lights/shape_light.h"
#endif

// The tree of lights is walked for two vectors of points at a time: each waits for its nodes and
// its arithmetic while the other goes on.
#define EK_LIGHTS_IN_PAIRS (EK_CHUNKED & EK_HAS_next_event & EK_HAS_light_tree)

/// The shadow rays of a chunk so far.
typedef struct {
  uint shadow_count;       // on chunks
  ShadingPoint points[2];  // with EK_LIGHTS_IN_PAIRS: the first one may wait for the second
  uint point_count;
} DirectLight;

/// The sampled light as it arrives at a shading point.
EK_FN LightSample direct_light_sample(const ShadeContext* c, const ShadingPoint* point, PickedLight picked,
                                      LightWords words) {
  const LightViewer viewer = {.basis = point->basis,
                              .both_sides = point->both_sides,
#if EK_HAS_moving_light
                              .time = point->time,
#endif
#if EK_USES_GUIDE
                              .guide = point->material.guide
#endif
  };
  LightSample light = light_sample(c->stage.frame, c->lights, picked, viewer, words);
#if EK_HAS_moving_surface
  light = moved_light_sample(c->scene, light, point->time);
#endif
#if EK_HAS_light_paths
  light.pdf_of_point = (vf)(1.0f);
#endif
#if EK_HAS_shape & EK_HAS_shape_light
  light = shape_light_sample(c->scene, light, point->p);
#endif
  light.radiance = light_emission(c->scene, light);
  return light;
}

#if EK_HAS_light_paths
#include "lights/light_path.h"

/// The share of a sample's light that camera paths bring: at glossy targets light paths bring the
/// rest.
/// light  index; sample: of it; shadow: the ray to it
EK_FN vf sampled_light_share(const ShadeContext* c, const ShadingPoint* point, vu light, const LightSample* sample,
                             const LightRay* shadow) {
  if (!EK_GLOSSY_TARGETS) return (vf)(1.0f);
  vi shared = point->live & is_shared_ratio(point->sampled_light_ratio);
  if (!ANY(shared)) return (vf)(1.0f);
  // Glossy targets are glossy (is_glossy), and from the viewer's side their normals are not bent
  // (sampled_light_ratio).
  if (EK_USES_SHADING_NORMAL & point->needs_attributes)
    shared = shared & is_unbent_from(point->n_shade, point->n_geom, shadow->wi, (vi)(-1));
  const v3 dir = neg3(shadow->wi), way = sub3(sample->p, point->p);
  const vf distance2 = dot3(way, way), sr = shared_lobe_sr(point->material.ggx_alpha, abs_f(dot3(point->n_geom, dir)));
  vf density = (vf)(0.0f);
  if (EK_HAS_area) {
    const vf start_m2 = start_pdf_m2(c->lights, light, sample->pdf_of_point);
    const vf emitted = mean_emission_density(c->lights, light, start_m2, sample->n, dir);
    const vf pdf_sr = pdf_sr_from_m2(start_m2, sample->n, dir, sqrt_f(distance2));
    density = (sample->is_distant | sample->is_punctual) ? density : density_beside_sampling(emitted, pdf_sr, sr);
  }
  if (EK_HAS_point | EK_HAS_spot) {
    const vf pdf_m2 = div_f(mean_target_pdf_sr(c->lights, light), distance2);
    density = sample->is_punctual ? density_beside_sampling_of_point(pdf_m2, sr) : density;
  }
  if (EK_HAS_directional) {
    const vf pdf_m2 = (vf)(mean_parallel_pdf_m2(c->lights));
    density = (sample->is_distant & sample->is_delta) ? density_beside_sampling_of_point(pdf_m2, sr) : density;
  }
#if EK_HAS_environment_map
  const vf emitted = mean_environment_density(c->stage.frame, c->lights, sample->pdf);
  density = (sample->is_distant & !sample->is_delta) ? density_beside_sampling(emitted, sample->pdf, sr) : density;
#endif
  shared = shared & (gather_f(c->lights.light_paths.emission_pdf, light) > 0.0f);
  return shared ? camera_share(point->sampled_light_ratio, density) : (vf)(1.0f);
}
#endif

/// The share of a light's radiance that the medium on the way leaves. wi: towards the light, local
EK_FN v3 direct_light_transmittance(const ShadeContext* c, const ShadingPoint* point, LightRay shadow, v3 wi) {
  if (!EK_HAS_absorption) return V3((vf)(1.0f), (vf)(1.0f), (vf)(1.0f));
  const vi below = is_transmitted(point, wi, shadow.wi);
  const vu medium = below ? point->interface.transmitted_medium : point->interface.medium;
  const vf distance = shadow.t_max < EK_INFINITY ? sqrt_f(dot3(shadow.dir, shadow.dir)) : EK_INFINITY;
  return transmittance(medium_absorption(c->scene, medium), distance);
}

/// Samples the light that was picked for each lane, and stores a pending shadow ray for each lane
/// where that could bring light.
/// k      which of the vertex's samples
/// slot   on chunks, that of the chunk's next shadow rays, of which there are never more than
///        EK_LIGHT_SAMPLES for each hit before, so there is room for whole vectors; else the path's
/// returns the mask of those lanes, as bits
EK_FN uint direct_light_cast(const ShadeContext* c, const ShadingPoint* point, PickedLight picked, LightWords words,
                             uint k, uint slot) {
  const LightSample light = direct_light_sample(c, point, picked, words);
  LightRay shadow = light_ray(light, point->p, point->p_error, point->n_geom);
  if (EK_HAS_clearcoat & EK_HAS_area)
    shadow.radiance = scale3(shadow.radiance, light_coat(c->scene, light, shadow.wi));
  const v3 wi = to_local(point->basis, shadow.wi);
  const BsdfValue bsdf = bsdf_evaluate(point->material, point->wo, wi);
  const v3 f = bsdf.f;
  vf weight = (vf)(1.0f);
  if (EK_HAS_bsdf_emission) {
    weight = power_heuristic(shadow.pdf * EK_LIGHT_MEAN, bsdf.pdf);
    weight = light.is_delta ? (vf)(1.0f) : weight;
  }
#if EK_HAS_light_paths
  weight = weight * sampled_light_share(c, point, picked.choice.index, &light, &shadow);
#endif
  vi pending = point->live & is_on_geometric_side(point, wi, dot3(shadow.wi, point->n_geom)) & (shadow.pdf > 0.0f) &
               (max_component(f) > 0.0f) & (max_component(shadow.radiance) > 0.0f);
  if (EK_USES_NULL_INTERFACES) pending = pending & !point->interface.is_null;
  if (EK_HAS_each_light) pending = k < c->stage.frame->light_count ? pending : (vi)(0);

  const v3 transmitted = direct_light_transmittance(c, point, shadow, wi);
  v3 radiance = scale3(mul3(mul3(point->beta, f), shadow.radiance), div_f(weight, shadow.pdf * EK_LIGHT_MEAN));
  if (EK_HAS_absorption) radiance = mul3(radiance, transmitted);
  OpacityKey opacity = {(vu)(0u), (vu)(0u)};
  if (EK_HAS_opacity) opacity = opacity_key(point->key + k * EK_LIGHT_SAMPLE_KEY, point->index, c->depth, 1u);
  const ShadowRay ray = {.destination = point->path,
                         .opacity_key = opacity.key,
                         .opacity_index = opacity.index,
#if EK_HAS_moving_surface
                         .time = point->time,
#endif
                         .origin = shadow.origin,
                         .dir = shadow.dir,
                         .t_max = shadow.t_max,
                         .origin_prim = point->triangle,
                         .target_prim = shadow.target_prim,
                         .radiance = radiance,
#if EK_HAS_path_log
                         .logged = luminance(mul3(mul3(f, shadow.radiance), transmitted)) * div_f(weight, shadow.pdf) *
                                   point->transmitted,
#endif
                         .light_group = light.group,
                         .null_interface_count = point->interface.null_interface_count};
  shadow_store(c->stage.state, EK_CHUNKED ? slot : slot + k * EK_CHUNK, packing(pending), ray);
  return mask_bits(pending);
}

/// Light sample k of a vector of points.
EK_FN LightQuery direct_light_query(const ShadeContext* c, const ShadingPoint* point, uint k) {
  const LightQuery query = {.context = point->light_context,
                            .wanted = point->live,
                            .words = light_words(point->key, point->index, c->depth, k)};
  return query;
}

#if EK_LIGHTS_IN_PAIRS
/// The light samples of two vectors of points, whose lights are picked together. returns the number
/// of shadow rays
EK_FN_ONCE uint direct_light_pair(const ShadeContext* c, const ShadingPoint* points, uint shadow_count) {
  for (uint k = 0; k < EK_LIGHT_SAMPLES; ++k) {
    LightQuery queries[2];
    PickedLight picked[2];
    for (uint i = 0; i < 2; ++i) queries[i] = direct_light_query(c, points + i, k);
    pick_two_lights(c->stage.frame, c->lights, queries, picked);
#pragma unroll 1
    for (uint i = 0; i < 2; ++i)
      shadow_count += popcount(direct_light_cast(c, points + i, picked[i], queries[i].words, k, shadow_count));
  }
  return shadow_count;
}
#endif

/// Adds the shadow rays of a vector of points; with EK_LIGHTS_IN_PAIRS, maybe later.
/// slot  of the paths
/// returns, without chunks, bit k: shadow ray k of the path is pending
EK_FN uint direct_light_add(const ShadeContext* c, DirectLight* direct, const ShadingPoint* point, uint slot) {
#if EK_LIGHTS_IN_PAIRS
  direct->points[direct->point_count++] = *point;
  if (direct->point_count == 2) {
    direct->shadow_count = direct_light_pair(c, direct->points, direct->shadow_count);
    direct->point_count = 0;
  }
  return 0;
#else
  uint pending = 0;
  for (uint k = 0; k < EK_LIGHT_SAMPLES; ++k) {
    const LightQuery query = direct_light_query(c, point, k);
    const PickedLight picked = pick_light(c->stage.frame, c->lights, query);
    const uint cast = direct_light_cast(c, point, picked, query.words, k, EK_CHUNKED ? direct->shadow_count : slot);
    direct->shadow_count += popcount(cast);
    pending |= cast << k;
  }
  return pending;
#endif
}

/// Adds the shadow rays of the points that still wait. returns the number of shadow rays of the
/// chunk
EK_FN uint direct_light_finish(const ShadeContext* c, DirectLight* direct) {
#if EK_LIGHTS_IN_PAIRS
  if (direct->point_count == 1) {
    direct->points[1] = direct->points[0];
    direct->points[1].live = (vi)(0);
    direct->shadow_count = direct_light_pair(c, direct->points, direct->shadow_count);
  }
#endif
  return direct->shadow_count;
}

#endif
