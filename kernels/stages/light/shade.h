// SPDX-License-Identifier: Apache-2.0
// Stage `light_shade`.   From: light paths of this depth that hit something.
//                        To: the light paths of the next depth, and pending shadow rays to the
//                        camera.
// The steps are those of stage `shade`, for paths that carry light instead of looking for it. A
// light path ends unless its first surface is a target: a specular one with delta scattering, or a
// glossy one. From the second surface on, a shadow ray joins it to the camera and carries what
// arrives there.
//
// A BSDF sample carries radiance, and its wo is towards the viewer. A light path carries power, so
// its weight is that of the adjoint BSDF [Veach 1997, section 5.3]: the ratio of cosines corrects
// for shading normals there, and eta^2 undoes the scaling of radiance at refraction [section
// 5.2]. Where the scattering is not delta, the BSDF is evaluated anew as a viewer in the new
// direction sees the surface, with the normals that such a viewer has, so the result holds for any
// material, reciprocal or not.
#ifndef EK_STAGE_LIGHT_SHADE_H
#define EK_STAGE_LIGHT_SHADE_H
#include "film/filter.h"
#include "film/splat.h"
#include "stages/light/photon.h"
#include "stages/shade.h"

#if EK_HAS_light_paths
/// The medium that a direction from a hit leads into. front: mask, on the front side
EK_FN vu medium_on_side(const PathHit* hit, const MediumInterface* interface, vi front) {
  const vi is_side_of_light = (front & hit->front) | (!front & !hit->front);
  return is_side_of_light ? interface->medium : interface->transmitted_medium;
}

/// The hit of a light path as a viewer sees it.
/// to_viewer  world, unit
EK_FN PathHit seen_from(const PathHit* hit, const MediumInterface* interface, v3 to_viewer) {
  PathHit seen = *hit;
  seen.path.dir = neg3(to_viewer);
  seen.front = dot3(hit->surface.n_geom, to_viewer) > 0.0f;
  if (EK_USES_MEDIUM) seen.path.medium = medium_on_side(hit, interface, seen.front);
  return seen;
}

/// BSDF and cosines of light that comes along a light path and goes on to a viewer: what the
/// throughput of the path is multiplied by, over the density of to_viewer per sr. Delta scattering
/// is left out.
/// channel     random number that chooses the colour in glass with dispersion, as at the hit itself
/// faces_away  is set to that of the point as the viewer sees it
EK_FN v3 scattered_towards(const ShadeContext* c, const PathHit* hit, const ShadingPoint* point, v3 to_viewer, vf channel,
                           vi* faces_away) {
  const PathHit seen = seen_from(hit, &point->interface, to_viewer);
  MediumInterface interface;
  const HitMaterial material = shade_material(c, &seen, &interface);
  ShadingPoint view = shading_point(c, &seen, &material, &interface);
  *faces_away = view.faces_away;
  if (EK_HAS_dispersion) {
    v3 carried = point->beta;
    disperse(material, seen.front, channel, &view.material, &carried);
  }
  shading_frame(c, &seen, &material, &view);
#if EK_USES_GUIDE
  view.material.guide = point->material.guide;
#endif
  const v3 to_light = neg3(hit->path.dir), wi = to_local(view.basis, to_light);
  const v3 f = bsdf_evaluate(view.material, view.wo, wi).f;
  const vf cos_light = abs_f(dot3(hit->surface.n_geom, to_light)), cos_viewer = abs_f(dot3(hit->surface.n_geom, to_viewer));
  vi possible = is_on_geometric_side(&view, wi, dot3(to_light, view.n_geom)) & (cos_light > 0.0f);
  if (EK_USES_NULL_INTERFACES) possible = possible & !interface.is_null;
  return scale3(f, possible ? div_f(cos_viewer, cos_light) : (vf)(0.0f));
}

/// The pixel that a splat belongs to.
typedef struct {
  vi inside;  // mask: it is in the film's window
  vu pixel;   // x | y << 16
  vf weight;  // the pixel's filter over the probability of this choice
} SplatPlace;

/// Chooses a pixel whose filter reaches a place on the film.
EK_FN SplatPlace splat_place(const ShadeContext* c, global const float* filter_table, const ShadingPoint* point,
                             const CameraView* view) {
  vf x = view->x, y = view->y;
  SplatPlace place;
  place.weight = (vf)(1.0f);
  if (EK_HAS_pixel_filter) {
    vf u, v;
    sample_2d(point->key, point->index, bounce_dimension(c->depth, DIM_ENVIRONMENT), &u, &v);
    // Pictures have at most 65536 pixels a side, and no filter reaches 1024 pixels. Places beyond,
    // which may be far off, are too large for filter_pixel.
    const vi near = (x > -1024.0f) & (x < 66560.0f) & (y > -1024.0f) & (y < 66560.0f);
    const vf along_x = filter_pixel(filter_table, near ? x : (vf)(0.0f), u, &x);
    const vf along_y = filter_pixel(filter_table, near ? y : (vf)(0.0f), v, &y);
    place.weight = near ? along_x * along_y : (vf)(0.0f);
  }
  const uint begin = c->stage.frame->crop_begin, end = c->stage.frame->crop_end;
  place.inside = (x >= (float)(begin & 0xffffu)) & (x < (float)(end & 0xffffu)) & (y >= (float)(begin >> 16)) &
                 (y < (float)(end >> 16));
  const vf zero = (vf)(0.0f);
  place.pixel = AS_U(TO_I(place.inside ? x : zero)) | AS_U(TO_I(place.inside ? y : zero)) << 16;
  return place;
}

/// Leaves a shadow ray to the camera for each lane whose light could arrive there.
/// slot  as of direct_light_cast. returns the mask of those lanes, as bits
EK_FN uint camera_cast(const ShadeContext* c, global const float* filter_table, const PathHit* hit, const ShadingPoint* point,
                       vf channel, uint slot) {
  constant Frame* frame = c->stage.frame;
  const CameraView view = camera_view(frame, point->p, point->key, point->index, c->depth);
  const SplatPlace splat = splat_place(c, filter_table, point, &view);
  const vi on_film = splat.inside & point->live & view.in_front;
  if (!ANY(on_film)) return 0u;
  const v3 to_camera = neg3(view.dir), n_geom = hit->surface.n_geom;
  vi unused;
  const v3 f = scattered_towards(c, hit, point, to_camera, channel, &unused);
  // Light of lamps that paths from the camera can meet is shared with them (light_ratio.h).
  const vf density = hit->path.light_ratio;
  const vf ratio = first_light_ratio(c, hit, point, view.dir, view.distance) * density;
  const vi is_shared = !starts_from_delta_light(density) & (ratio < 0x1p100f);
  const vf share = is_shared ? div_f(ratio, 1.0f + ratio) : (vf)(1.0f);
  const vu exponent = is_shared ? AS_U(ratio) >> 23 : (vu)(EK_SPLAT_RATIO_INFINITE);
  v3 arriving = scale3(mul3(point->beta, f), (film_density_m2(frame, view.dir, view.distance) * share) * splat.weight);
  const vi towards_front = dot3(n_geom, to_camera) > 0.0f;
  if (EK_HAS_absorption) {
    const vu medium = medium_on_side(hit, &point->interface, towards_front);
    arriving = mul3(arriving, transmittance(medium_absorption(c->scene, medium), view.distance));
  }
  vi seen = on_film;
  if (EK_HAS_culling) seen = seen & (towards_front | ((hit->corners.flags & (uint)EK_TRIANGLE_SINGLE_SIDED) == 0u));
  const vi pending = seen & (max_component(abs3(arriving)) > 0.0f);
  OpacityKey opacity = {(vu)(0u), (vu)(0u)};
  if (EK_HAS_opacity) opacity = opacity_key(point->key, point->index, c->depth, 1u);
  // The ray goes from the camera to the point, as the camera's rays do, so both are stopped by the
  // same surfaces. Its end is that of a shadow ray to a light (light_ray).
  const v3 target = offset_ray_origin(point->p, point->p_error, point->n_geom, to_camera);
  const vf margin = shadow_margin(abs_f(dot3(n_geom, view.dir)));
  const vu counted = (vu)(c->depth) - point->interface.null_interface_count;
  const vu scatterings = counted < EK_SPLAT_SCATTERINGS_MOST ? counted : (vu)(EK_SPLAT_SCATTERINGS_MOST);
  const vu pixel = (aim_flags(c->lights) & EK_AIM_NAMES_STARTS) != 0u
                       ? EK_SPLAT_NAMED_PIXEL(splat.pixel, light_path_start(hit->path.path))
                       : splat.pixel;
  const ShadowRay ray = {
    .destination = pixel,
    .opacity_key = opacity.key,
    .opacity_index = opacity.index,
    .origin = view.eye,
    .dir = sub3(target, view.eye),
    .t_max = 1.0f - margin,
    .origin_prim = (vu)(EK_NO_HIT),
    .target_prim = point->triangle,
    .radiance = arriving,
#if EK_HAS_light_group
    .light_group = hit->path.source_group,
#endif
    .record_info = EK_SPLAT_INFO(light_path_replicate(hit->path.path), scatterings, exponent)
  };
  shadow_store(c->stage.state, slot, packing(pending), ray);
  return mask_bits(pending);
}

/// Samples the direction in which a light path goes on, and its throughput.
EK_FN ScatteredPath light_scatter(const ShadeContext* c, const PathHit* hit, const HitMaterial* material,
                                  const ShadingPoint* point, vf channel) {
  ScatteredPath next = scatter_direction(c, hit, point);
  const vi is_null = point->interface.is_null, is_delta = has_no_density(next.pdf);
  const v3 to_light = neg3(hit->path.dir);
  const vf geom_light = abs_f(dot3(point->n_geom, to_light)), geom_next = abs_f(dot3(point->n_geom, next.dir));
  const vf shade_light = abs_f(point->wo.z), shade_next = abs_f(next.wi.z);
  // Of delta scattering: the weight of the adjoint BSDF over that of the sample.
  vf adjoint = div_f(geom_next * shade_light, geom_light * shade_next);
  if (has_lobe_with(EK_TRAIT_TRANSMITS)) {
    const vi refracted = point->material.solid & (next.wi.z < 0.0f);
    adjoint = adjoint * (refracted ? point->material.eta * point->material.eta : (vf)(1.0f));
  }
  vf passed = (vf)(1.0f);
#if EK_HAS_open_solid
  // A viewer on the other side sees the radiance scaled. An opening bends no ray, so nothing undoes
  // that.
  passed = point->interface.is_opening ? div_f(passed, radiance_transmitted(point->material)) : passed;
#endif
  v3 weight = select3(is_null, V3(passed, passed, passed), scale3(next.beta, adjoint));
  if (ANY(next.survives & !is_delta)) {
    vi faces_away;
    const v3 f = scattered_towards(c, hit, point, next.dir, channel, &faces_away);
    weight = select3(is_delta, weight, scale3(f, div_f((vf)(1.0f), next.pdf)));
    next.survives = next.survives & (is_delta | !faces_away);  // see is_hidden_from_light_paths
  }
  next.beta = mul3(point->beta, weight);
  next.survives = next.survives & (max_component(abs3(next.beta)) > 0.0f);
  vi reversible = is_reversible(c, hit, material, point, &next), scatters = (vi)(-1);
  if (c->depth == 1) {
    reversible = reversible & is_target(c, hit, EK_MATERIAL_LIGHT_TARGET);
    scatters = is_unbent_glossy_target(c, hit, material, point);
    if (EK_USES_SHADING_NORMAL & point->needs_attributes)
      scatters = scatters & is_unbent_from(point->n_shade, point->n_geom, next.dir, (vi)(-1));
  }
  next.survives = next.survives & (is_delta ? reversible : scatters);
  return next;
}

/// Survival probability of a light path: the share of its light that this surface sends on.
/// Throughputs of light paths have no common scale, and with this rule roulette leaves them as they
/// are.
EK_FN vf light_survival(const ShadeContext* c, const ShadingPoint* point, const ScatteredPath* next) {
  const vf share = div_f(max_component(abs3(next->beta)), max_component(abs3(point->beta)));
  const vf survival = min_f(share, roulette_most(c->depth));
  return point->interface.skips_depth ? (vf)(1.0f) : survival;
}

/// PathState.light_ratio of a light path that goes on. Where its first surface is a glossy target,
/// camera paths find its light there by sampling lights, too, so the density is made that of
/// density_beside_sampling; otherwise it stays.
EK_FN vf emitted_light_ratio(const ShadeContext* c, const PathHit* hit, const ShadingPoint* point,
                             const ScatteredPath* next) {
  constant Frame* frame = c->stage.frame;
  const vf density = hit->path.light_ratio;
  const vi leaves_glossy_target = next->survives & has_density(next->pdf);
  if (!EK_GLOSSY_TARGETS || c->depth > 1 || !ANY(leaves_glossy_target)) return density;
  const v3 dir = hit->path.dir;
  const vi is_parallel = starts_parallel(density);
  const vf distance2 = is_parallel ? (vf)(1.0f) : hit->t * hit->t;
  const vf sr = shared_lobe_sr(point->material.ggx_alpha, abs_f(dot3(point->n_geom, dir)));
  vf of_way = marked_aim(density);
#if EK_HAS_environment_map
  of_way = is_parallel ? (vf)(frame->environment_emission * mean_parallel_pdf_m2(c->lights)) : of_way;
#endif
  const vf of_surface = density_beside_sampling(density, div_f(density * distance2, of_way), sr);
  const vf of_point = density_beside_sampling_of_point(div_f(-density, distance2), sr);
  return leaves_glossy_target ? (starts_from_delta_light(density) ? of_point : of_surface) : density;
}

EK_FN_ONCE Survivors stage_light_shade(StageContext stage, SceneData scene, LightData light_data, global const float* filter_table,
                                       uint count, uint depth) {
  const ShadeContext context = {stage, scene, light_data, depth};
  const ShadeContext* c = &context;
  Survivors survivors = {0, 0};
  HitWalk walk = hit_walk(count);
  while (hit_walk_next(&walk, scene, stage.state, stage.queue)) {
    const PathHit hit = hit_load(c, walk.slot, walk.lanes);
    MediumInterface interface;
    const HitMaterial material = shade_material(c, &hit, &interface);
    ShadingPoint point = shading_point(c, &hit, &material, &interface);
    vf channel = (vf)(0.0f);
    if (EK_HAS_dispersion) {
      vf unused;
      sample_2d(point.key, point.index, DIM_TIME_DISPERSION, &unused, &channel);
      disperse(material, hit.front, channel, &point.material, &point.beta);
    }
    point.live = point.live & shade_may_go_on(c, &interface);
    if (EK_HAS_unlit) point.live = point.live & !material.unlit;
    shading_frame(c, &hit, &material, &point);
#if EK_USES_GUIDE
    point.material.guide.cells = light_data.guide.cells;
    point.material.guide.cell = (vu)(EK_NO_CELL);
    point.expected = (vf)(0.0f);
#endif
    uint pending = 0u;
#if EK_HAS_merging
    if (depth > 1 && stage.frame->of_light_paths == EK_OF_PHOTONS)
      pending = photon_leave(c, &hit, &point, EK_CHUNKED ? survivors.shadow_rays : walk.slot);
    else
#endif
    if (depth > 1) pending = camera_cast(c, filter_table, &hit, &point, channel, EK_CHUNKED ? survivors.shadow_rays : walk.slot);
    survivors.shadow_rays += popcount(pending);
    ScatteredPath next = light_scatter(c, &hit, &material, &point, channel);
    if (depth + 1u >= stage.frame->roulette_depth) roulette(c, &point, light_survival(c, &point, &next), &next);
    next.light_ratio = emitted_light_ratio(c, &hit, &point, &next);
    PathState path = shade_next_path(c, &point, &next);
    path.source_group = hit.path.source_group;
    const Packing keep = packing(next.survives);
    path_store_next(stage.state, EK_CHUNKED ? survivors.paths : walk.slot, keep, path);
    if (!EK_CHUNKED)
      state_set_vu(stage.state, FIELD_next, walk.slot, (vu)(mask_bits(next.survives) | (pending != 0u ? 2u : 0u)));
    survivors.paths += keep.count;
  }
  return survivors;
}
#endif

#endif
