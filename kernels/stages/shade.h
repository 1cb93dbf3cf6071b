// SPDX-License-Identifier: Apache-2.0
// Stage `shade`.   From: paths of this depth that hit something.
//                  To: the paths of the next depth, and pending shadow rays.
// Shades a vector of hits at a time, in steps that stand in stages/shade/, a file each: load the
// hit, find its material, add its emission, sample lights, scatter, and let roulette decide which
// paths go on. CPU devices pack the survivors in place; GPU devices leave that to stage compact,
// and sample lights last: what only the next path needs is stored by then and takes no registers.
#ifndef EK_STAGE_SHADE_H
#define EK_STAGE_SHADE_H
#include "surface/dispersion.h"
#include "film/first_hit.h"
#include "film/motion_vector.h"
#include "stages/raycast.h"
#include "stages/shade/direct_light.h"
#include "stages/shade/emission.h"
#include "stages/shade/guide.h"
#include "stages/shade/hit.h"
#include "stages/shade/light_ratio.h"
#include "stages/shade/material.h"
#include "stages/shade/scatter.h"
#if !EK_CHUNKED
#include "stages/shade/registers.h"
#endif

/// Writes the layers of the film that show what camera rays hit.
EK_FN void shade_first_hit(const ShadeContext* c, const PathHit* hit, const ShadingPoint* point) {
  const FirstHit first = {.filter_weight = EK_HAS_pixel_filter ? hit->path.beta.x : (vf)(1.0f),
                          .albedo = point->material.base_color,
                          .n_shade = point->n_shade,
                          .n_geom = point->n_geom,
                          .p = point->p,
                          .t = hit->t,
                          .uv_u = hit->attributes.uv0_u,
                          .uv_v = hit->attributes.uv0_v,
                          .node = hit->corners.node,
                          .material = hit->corners.material};
  film_first_hit(c->stage.frame, c->stage.film, hit->live, hit->path.path, first);
#if EK_HAS_motion
  SeenMotion seen = {hit->live, hit->path.path, first.filter_weight, point->p, point->p, 1.0f};
  follow_triangle(c->scene, hit->triangle, hit->u, hit->v, &seen);
  film_motion(c->stage.frame, c->scene, c->stage.film, &seen);
#endif
}

/// Mask of the lanes whose path may have another edge. Null interfaces do not count towards
/// max_depth.
EK_FN vi shade_may_go_on(const ShadeContext* c, const MediumInterface* interface) {
  const uint max_depth = c->stage.frame->max_depth;
  if (!EK_USES_NULL_INTERFACES) return max_depth != 0 && c->depth >= max_depth ? (vi)(0) : (vi)(-1);
  return interface->skips_depth |
         (max_depth == 0 ? (vi)(-1) : (vu)(c->depth) - interface->null_interface_count < (vu)(max_depth));
}

/// Density with which light sampling would have chosen a path's direction towards the constant
/// environment, per sr.
EK_FN vf next_environment_pdf(const ShadeContext* c, const ShadingPoint* point, const ScatteredPath* next) {
  const vf pdf = environment_pdf_sr(c->stage.frame->environment.w, next->wi.z, point->both_sides);
#if EK_USES_GUIDE
  return pdf * guide_density(point->material.guide, next->wi);
#else
  return pdf;
#endif
}

/// The state of a path that goes on.
EK_FN PathState shade_next_path(const ShadeContext* c, const ShadingPoint* point, const ScatteredPath* next) {
  const vu skipped = point->interface.skips_depth ? (vu)(1u) : (vu)(0u);
  const PathState path = {
      .path = point->path,
      .key = point->key,
      .index = point->index,
#if EK_HAS_moving_surface | EK_HAS_moving_light
      .time = point->time,
#endif
      .origin = offset_ray_origin(point->p, point->p_error, point->n_geom, next->dir),
      .dir = next->dir,
      .beta = next->beta,
      .pdf = next->pdf,
      .pdf_environment = next_environment_pdf(c, point, next),
      .packed_normal = point->light_context.packed_normal,
#if EK_USES_GUIDE
      .expected = point->expected,
#endif
#if EK_HAS_path_log
      .plain_pdf = plain_pdf(point, next),
#endif
#if EK_HAS_light_paths
      .light_ratio = next->light_ratio,
      .source_group = (vu)(0u),
#endif
      .medium = next->medium,
      .null_interface_count = point->interface.null_interface_count + skipped,
      .hit_triangle = EK_HAS_instance ? (vu)(EK_NO_HIT) : point->triangle};
  return path;
}

EK_FN_ONCE Survivors stage_shade(StageContext stage, SceneData scene, LightData light_data, uint count, uint depth) {
  const ShadeContext context = {stage, scene, light_data, depth};
  const ShadeContext* c = &context;
  const int roulette_decides = depth + 1u >= stage.frame->roulette_depth;
  DirectLight direct;
  direct.shadow_count = direct.point_count = 0;
  Survivors survivors = {0, 0};
  HitWalk walk = hit_walk(count);
  while (hit_walk_next(&walk, scene, stage.state, stage.queue)) {
    const PathHit hit = hit_load(c, walk.slot, walk.lanes);
    MediumInterface interface;
    const HitMaterial material = shade_material(c, &hit, &interface);
    ShadingPoint point = shading_point(c, &hit, &material, &interface);
#if EK_HAS_path_log
    log_vertex_begin(c, &hit);
#endif
    if (depth == 1) shade_first_hit(c, &hit, &point);
    if (EK_HAS_area) add_emission(c, &hit, &material, &point, walk.slot);
    if (EK_HAS_unlit) add_unlit(c, &hit, &material, &point);
    if (EK_HAS_dispersion) {
      vf unused, channel;
      sample_2d(point.key, point.index, DIM_TIME_DISPERSION, &unused, &channel);
      disperse(material, hit.front, channel, &point.material, &point.beta);
    }
    if (EK_HAS_raycast) point.material = raycast_material(point.material);
    point.live = point.live & shade_may_go_on(c, &interface);
    shading_frame(c, &hit, &material, &point);
#if EK_USES_GUIDE
    guide_point(c, &hit, &point);
#endif
#if EK_HAS_light_paths
    begin_sharing(c, &hit, &material, &point);
#endif
#if EK_CHUNKED
    const uint pending = EK_HAS_next_event ? direct_light_add(c, &direct, &point, walk.slot) : 0u;
#endif
    ScatteredPath next = scatter(c, &hit, &point);
#if EK_HAS_light_paths
    next.light_ratio = next_light_ratio(c, &hit, &material, &point, &next);
#endif
    vf survival = roulette_decides ? throughput_survival(c, &hit, &point, &next) : (vf)(1.0f);
#if EK_USES_GUIDE
    survival = guided_survival(c, &point, survival);
#endif
    if (roulette_decides | EK_USES_GUIDE) roulette(c, &point, survival, &next);
#if EK_HAS_path_log
    log_vertex_end(c, &hit, &point, &next);
#endif
    // On chunks whole vectors may be written, as [slot, slot + width) has been read already.
    const Packing keep = packing(next.survives);
    path_store_next(stage.state, EK_CHUNKED ? survivors.paths : walk.slot, keep, shade_next_path(c, &point, &next));
#if !EK_CHUNKED
    const uint pending = EK_HAS_next_event ? direct_light_last(c, &direct, point, walk.slot) : 0u;
#endif
    if (!EK_CHUNKED) state_set_vu(stage.state, FIELD_next, walk.slot, (vu)(mask_bits(next.survives) | pending << 1));
    survivors.paths += keep.count;
  }
  survivors.shadow_rays = direct_light_finish(c, &direct);
  return survivors;
}

#endif
