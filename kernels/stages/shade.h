// SPDX-License-Identifier: Apache-2.0
// Stage `shade`.   From: paths of this depth that hit something.   To: the paths of the next depth, pending shadow rays.
// Finds the material, adds emission, samples a light (the shadow ray carries what arrives if nothing is in the way), scatters, and lets roulette
// decide. CPU devices pack survivors in place; GPU devices leave that to compact.cl.
#ifndef EK_STAGE_SHADE_H
#define EK_STAGE_SHADE_H
#include "surface/alpha.h"
#include "bsdf/dispersion.h"
#include "film/film_layers.h"
#include "stages/hit_classes.h"
#include "surface/instance_surface.h"
#include "lights/emission.h"
#include "surface/material.h"
#include "surface/medium.h"
#include "stages/raycast.h"
#include "lanes/sampler.h"
#include "surface/shading_normal.h"
#if EK_HAS_shape
#include "shapes/shape_surface.h"
#endif
#if EK_HAS_shape & EK_HAS_shape_light
#include "lights/shape_light.h"
#endif
#include "stages/wavefront.h"

// Reflected light stays on the viewer's side of the surface itself, transmitted light leaves it: else walls would leak.
// cos_geom  of the direction with n_geom
EK_FN vi agrees(v3 wi, vf cos_geom) {
  const vi reflected = (wi.z > 0.0f) & (cos_geom > 0.0f);
  if (!EK_HAS_transmission) return reflected;
  return reflected | ((wi.z < 0.0f) & (cos_geom < 0.0f));
}

// terminator_factor of reflected light, as far as the material wants it; plain: mask of hits that are flat; wi: local and world.
EK_FN vf fade(MaterialLanes material, vi plain, v3 wi, v3 wi_world, v3 n_geom, v3 n_shade) {
  const vf factor = terminator_factor(dot3(wi_world, n_geom), wi.z, dot3(n_geom, n_shade));
  const vf share = terminator_share(material);
  return ((wi.z > 0.0f) & !plain) ? (1.0f - share) + share * factor : (vf)(1.0f);
}

#define ROULETTE_GAIN 3.0f        // survival over throughput: paths that carry more than a third go on
#define ROULETTE_ALWAYS_DEPTH 8u  // from here on every path may end: else those between perfect mirrors never do

// What sampling a light wants to know of a hit.
typedef struct {
  vi live, plain, both_sides, hidden;
  int detailed;
  vu triangle, path, key, index, medium, beyond, crossed;
  v3 beta, p, p_error, n_geom, n_shade, wo;
  Basis basis;
  MaterialLanes material;
  LitPoint lit;
} LitHit;

// Of each lane: a sample of the light that was picked for it, as a pending shadow ray.
// k      which of the vertex's samples
// place  of the chunk's next shadow rays; without chunks, of the path
// returns how many there are; without chunks, bit 1 + k if there is one
EK_FN uint shade_light(constant Frame* frame, SceneData scene, LightData light_data, global uint* state, LitHit at, PickedLight picked,
                       LightWords words, uint depth, uint k, uint place) {
  LightSample light = light_sample(frame, light_data, picked, at.basis, at.both_sides, words);
#if EK_HAS_shape & EK_HAS_shape_light
  light = shape_light_sample(scene, light, at.p);
#endif
  light.radiance = light_emission(scene, light);
  LightPath shadow = light_path(light, at.p, at.p_error, at.n_geom);
  if (EK_HAS_clearcoat & EK_HAS_area) shadow.radiance = scale3(shadow.radiance, light_coat(scene, light, shadow.wi));
  const v3 wi = to_local(at.basis, shadow.wi);
  const BsdfValue bsdf = bsdf_evaluate(at.material, at.wo, wi);
  v3 f = bsdf.f;
  if ((EK_HAS_vertex_normal | EK_HAS_normal_texture) & at.detailed)
    f = scale3(f, fade(at.material, at.plain, wi, shadow.wi, at.n_geom, at.n_shade));
  vf weight = (vf)(1.0f);
  if (EK_HAS_bsdf_emission) {
    weight = power_heuristic(shadow.pdf * EK_LIGHT_MEAN, bsdf.pdf);
    weight = light.is_delta ? (vf)(1.0f) : weight;
  }
  v3 arriving = scale3(mul3(mul3(at.beta, f), shadow.radiance), weight / (shadow.pdf * EK_LIGHT_MEAN));
  if (EK_HAS_absorption) {
    const vu towards = wi.z < 0.0f ? at.beyond : at.medium;
    const vf distance = shadow.t_max < EK_INFINITY ? sqrt(dot3(shadow.dir, shadow.dir)) : EK_INFINITY;
    arriving = mul3(arriving, transmittance(medium_absorption(scene, towards), distance));
  }
  vi pending = at.live & agrees(wi, dot3(shadow.wi, at.n_geom)) & (shadow.pdf > 0.0f) & (max_component(f) > 0.0f) &
               (max_component(shadow.radiance) > 0.0f);
  if (EK_HAS_nested_media) pending = pending & !at.hidden;
  if (EK_HAS_each_light) pending = k < frame->light_count ? pending : (vi)(0);

#if EK_CHUNKED
  const Packing cast = packing(pending);
#define EK_KEEP_SHADOW(field, x) state_set_u(state, field, place, packed(cast, x))
#else
#define EK_KEEP_SHADOW(field, x) state_set_u(state, field, place + k * EK_CHUNK, x)
#endif
#define EK_KEEP_SHADOW_3(field, a)                               \
  EK_KEEP_SHADOW(field, AS_U((a).x));                            \
  EK_KEEP_SHADOW(field + EK_LIGHT_SAMPLES, AS_U((a).y));         \
  EK_KEEP_SHADOW(field + 2 * EK_LIGHT_SAMPLES, AS_U((a).z))
  EK_KEEP_SHADOW(FIELD_shadow_path, at.path);
  if (EK_HAS_opacity) {
    const OpacityKey decisions = opacity_key(at.key + k * 0x632be5abu, at.index, depth, 1u);
    EK_KEEP_SHADOW(FIELD_shadow_key, decisions.key);
    EK_KEEP_SHADOW(FIELD_shadow_index, decisions.index);
  }
  EK_KEEP_SHADOW_3(FIELD_shadow_origin_x, shadow.origin);
  EK_KEEP_SHADOW_3(FIELD_shadow_dir_x, shadow.dir);
  EK_KEEP_SHADOW(FIELD_shadow_t, AS_U(shadow.t_max));
  if (!EK_HAS_instance) EK_KEEP_SHADOW(FIELD_shadow_left, at.triangle);
  if (EK_HAS_area & !EK_HAS_instance) EK_KEEP_SHADOW(FIELD_shadow_goal, shadow.goal);
  EK_KEEP_SHADOW_3(FIELD_shadow_r, arriving);
  if (EK_HAS_light_group) EK_KEEP_SHADOW(FIELD_shadow_group, light.group);
  if (EK_HAS_nested_media & EK_HAS_scattered) EK_KEEP_SHADOW(FIELD_shadow_crossed, at.crossed);
#if EK_CHUNKED
  return cast.count;
#else
  return (pending ? 2u : 0u) << k;
#endif
}

#define EK_LIT_IN_PAIRS (EK_CHUNKED & EK_HAS_next_event & EK_HAS_light_tree)
#if EK_LIT_IN_PAIRS
// The light samples of two vectors of hits, whose lights are picked together. returns how many shadow rays there are
EK_FN_ONCE uint shade_lights(constant Frame* frame, SceneData scene, LightData light_data, global uint* state, const LitHit* hits,
                             uint depth, uint shadow_count) {
  for (uint k = 0; k < EK_LIGHT_SAMPLES; ++k) {
    LightWords words[2];
    PickedLight picked[2];
    for (uint i = 0; i < 2; ++i) words[i] = light_words(hits[i].key, hits[i].index, depth, k);
    pick_two_lights(frame, light_data, hits[0].lit, hits[0].live, words[0], hits[1].lit, hits[1].live, words[1], picked);
#pragma unroll 1
    for (uint i = 0; i < 2; ++i)
      shadow_count += shade_light(frame, scene, light_data, state, hits[i], picked[i], words[i], depth, k, shadow_count);
  }
  return shadow_count;
}
#endif

// What a chunk has after shading; without chunks, 0.
typedef struct {
  uint next;    // paths of the next depth
  uint shadow;  // pending shadow rays
} Survivors;

EK_FN_ONCE Survivors stage_shade(constant Frame* frame, SceneData scene, LightData light_data, global uint* state,
                                 global float* film_slots, global const uint* queue, uint count, uint depth) {
  const uint film_stride = frame->film_stride;
  const int last = frame->max_depth != 0 && depth >= frame->max_depth;  // no edge may follow
  uint next_count = 0, shadow_count = 0;
#if EK_LIT_IN_PAIRS
  LitHit lit_hits[2];  // the first of which may wait for the second
  uint lit_count = 0;
#endif

  uint slot, lanes;
  EK_FOR_EACH_HIT(slot, lanes, scene, state, count, queue) {
    const vu hit = state_u(state, FIELD_hit_triangle, slot);
    vi live = (LANE_INDEX < (vu)(lanes)) & (hit != EK_NO_HIT);
    const vu triangle = live ? hit : (vu)(0u);
    const vu path = state_u(state, FIELD_path, slot), key = state_u(state, FIELD_key, slot),
             index = state_u(state, FIELD_index, slot);
    const v3 dir = state_3(state, FIELD_dir_x, slot);
    v3 beta = state_3(state, FIELD_beta_r, slot);
    const vf t = state_f(state, FIELD_hit_t, slot), u = state_f(state, FIELD_hit_u, slot),
             v = state_f(state, FIELD_hit_v, slot), scatter_pdf = state_f(state, FIELD_pdf, slot);

    TriangleLanes corners = load_triangle(scene.triangles, triangle);
#if EK_HAS_instance
    const Place place = hit_place(scene, live ? state_u(state, FIELD_hit_instance, slot) : (vu)(0u));
    corners = placed_triangle(place, corners);
#endif
    Surface surface = surface_at(corners, u, v, scale3(dir, t));
#if EK_HAS_shape
    const v3 origin = state_3(state, FIELD_origin_x, slot);
    const ShapePoint on_shape = shape_surface(scene, corners, u, origin, dir, t, &surface);
#endif
    const vi front = dot3(surface.n_geom, dir) < 0.0f;
    const vi plain = is_plain(corners.flags);
    const int detailed = (1 - EK_HAS_plain_hits) | EK_HAS_texture_place | (ANY(live & !plain) != 0);  // else: all are plain
    HitAttributes at = no_attributes();
    if (detailed) at = hit_attributes(scene, triangle, u, v);
#if EK_HAS_instance
    at = placed_attributes(scene, place, triangle, u, v, at);
#endif
#if EK_HAS_shape
    at = shape_attributes(scene, corners, on_shape, surface.n_geom, at);
#endif
    HitMaterial hit_surface = hit_material(scene, corners.material, at, front);
    vu medium = (vu)(0u), beyond = (vu)(0u);  // on this side of the surface, and on the other
    vi hidden = (vi)(0), unseen = (vi)(0);  // a boundary that does not show; and one that no more counts as an edge
    if (EK_HAS_MEDIUM) {
      medium = state_u(state, FIELD_medium, slot);
      beyond = medium_beyond(hit_surface, medium, corners.material, front);
    }
    vu crossed = (vu)(0u);
    if (EK_HAS_nested_media) {
      hidden = media_meet(scene, medium, beyond, front, &hit_surface);
      crossed = state_u(state, FIELD_crossed, slot);
      unseen = hidden & (crossed < EK_CROSSED_MOST);
    }
    if (EK_HAS_clearcoat)
      hit_surface.emission = scale3(hit_surface.emission, clearcoat_passes(hit_surface.bsdf.clearcoat, dot3(surface.n_geom, dir)));
    MaterialLanes material = hit_surface.bsdf;
    const v3 n_geom = select3(front, surface.n_geom, neg3(surface.n_geom));  // towards the viewer
    v3 n_shade = n_geom;
    if ((EK_HAS_vertex_normal | EK_HAS_normal_texture) & detailed) {
      n_shade = shading_normal(at, surface.n_geom);
      if (EK_HAS_normal_texture) n_shade = mapped_normal(scene, hit_surface.normal_texture, at, n_shade, surface.n_geom);
      n_shade = select3(front, n_shade, neg3(n_shade));
      vi glossy = material.lobes != (1u << LOBE_diffuse);
      if (EK_HAS_clearcoat) glossy = glossy | (material.clearcoat > 0.0f);
      n_shade = usable_normal(n_shade, n_geom, neg3(dir), glossy);
    }

    if (EK_HAS_absorption) beta = mul3(beta, transmittance(medium_absorption(scene, medium), t));

    if (depth == 1) {
      const FirstHit first = {material.base_color, n_shade, n_geom, surface.p, t, at.uv0_u, at.uv0_v, corners.node, corners.material};
      film_first_hit(frame, film_slots, live, path, EK_HAS_pixel_filter ? state_f(state, FIELD_beta_r, slot) : (vf)(1.0f), first);
    }

    const vu group = (corners.flags >> EK_TRIANGLE_GROUP_SHIFT) & (EK_LIGHT_GROUPS_MOST - 1u);
    if (EK_HAS_area) {
      const vi emits = live & emits_towards(surface.n_geom, hit_surface.double_sided, dir) &
                       (max_component(hit_surface.emission) > 0.0f);
      if (ANY(emits)) {
        vf weight = (vf)(1.0f);
        if (EK_HAS_next_event) {
          vf light_pdf = light_pdf_sr_of_hit(corners.light_pdf_m2, surface.n_geom, dir, t);
#if EK_HAS_shape & EK_HAS_shape_light
          const vi is_shape = corners.p2.x != corners.p2.x;
          if (ANY(emits & is_shape))
            light_pdf = is_shape ? shape_light_pdf_sr(scene, corners, is_shape, on_shape, u, origin, dir) : light_pdf;
#endif
#if EK_HAS_light_tree && EK_HAS_bsdf_emission
          const LitPoint lit = {state_3(state, FIELD_origin_x, slot), state_u(state, FIELD_facing, slot)};
          const vi weighted = emits & (scatter_pdf >= 0.0f) & (light_pdf > 0.0f);
          light_pdf = light_pdf * probability_in_tree(light_data.light_nodes, frame->tree_light_count, frame->light_scale, lit,
                                                      weighted, corners.flags >> EK_TRIANGLE_LIGHT_SHIFT);
#endif
          // A light that is never sampled (pack.cpp) counts in full either way.
          const vf scattered = EK_HAS_bsdf_emission ? power_heuristic(scatter_pdf, light_pdf * EK_LIGHT_MEAN)
                               : corners.light_pdf_m2 > 0.0f ? (vf)(0.0f) : (vf)(1.0f);
          weight = scatter_pdf < 0.0f ? weight : scattered;
        }
        film_add_light(film_slots, film_stride, emits, path, depth - 1, crossed, group, scale3(mul3(beta, hit_surface.emission), weight));
      }
    }

    if (EK_HAS_unlit) {
      // Seen by the camera, directly or through mirrors and windows; no light for anything else.
      const vi shown = live & hit_surface.unlit;
      if (ANY(shown))
        film_add_light(film_slots, film_stride, shown & (scatter_pdf < 0.0f), path, depth - 1, crossed, group,
                       mul3(beta, material.base_color));
      live = live & !hit_surface.unlit;
    }

    if (EK_HAS_dispersion) {
      vf unused, which;
      sample_2d(key, index, DIM_TIME, &unused, &which);
      disperse(hit_surface, front, which, &material, &beta);
    }

    if (EK_HAS_raycast) material = raycast_material(material);
    // What does not show ends no edge.
    if (EK_HAS_nested_media)
      live = live & (unseen | (frame->max_depth == 0 ? (vi)(-1) : (vu)(depth) - crossed < (vu)(frame->max_depth)));
    else
      live = last ? (vi)(0) : live;
    Basis basis = basis_around(n_shade);
    if (EK_HAS_anisotropy) basis = basis_along(basis, anisotropy_direction(hit_surface, at, surface.n_geom));
    const v3 wo = to_local(basis, neg3(dir));
    if (EK_HAS_clearcoat_normal) {
      v3 coat = mapped_normal(scene, hit_surface.clearcoat_normal_texture, at, shading_normal(at, surface.n_geom), surface.n_geom);
      coat = usable_normal(select3(front, coat, neg3(coat)), n_geom, neg3(dir), material.clearcoat > 0.0f);
      material.clearcoat_normal = to_local(basis, coat);
    }

    const vi both_sides = (material.lobes & (1u << LOBE_transmission)) != 0u;
#if !EK_CHUNKED
    uint pending_rays = 0;  // bit 1 + k: ray k, for compact.cl
#endif
    LitPoint lit = {surface.p, (vu)(0u)};
    if (EK_HAS_next_event) {
      if (EK_HAS_light_tree) {
        // Where reflected rays begin: the tree gives a light that such a ray meets the probability it has here, bit for bit.
        lit.p = offset_ray_origin(surface.p, surface.p_error, n_geom, n_geom);
        lit.facing = pack_facing(n_shade, both_sides);
      }
      // Of shadow rays there are never more than of hits before, times EK_LIGHT_SAMPLES: there is room for whole vectors.
      const LitHit lit_hit = {live, plain, both_sides, hidden, detailed, triangle, path, key, index, medium, beyond, crossed, beta,
                              surface.p, surface.p_error, n_geom, n_shade, wo, basis, material, lit};
#if EK_LIT_IN_PAIRS
      lit_hits[lit_count++] = lit_hit;
      if (lit_count == 2) {
        shadow_count = shade_lights(frame, scene, light_data, state, lit_hits, depth, shadow_count);
        lit_count = 0;
      }
#else
      for (uint k = 0; k < EK_LIGHT_SAMPLES; ++k) {
        const LightWords words = light_words(key, index, depth, k);
        const PickedLight picked = pick_light(frame, light_data, lit, live, words);
#if EK_CHUNKED
        shadow_count += shade_light(frame, scene, light_data, state, lit_hit, picked, words, depth, k, shadow_count);
#else
        pending_rays |= shade_light(frame, scene, light_data, state, lit_hit, picked, words, depth, k, slot);
#endif
      }
#endif
    }

    vf scatter_u, scatter_v, choice = (vf)(0.0f), roulette = (vf)(0.0f);
    sample_2d(key, index, bounce_dimension(depth, DIM_SCATTER), &scatter_u, &scatter_v);
    const int may_end = depth + 1u >= frame->roulette_depth;
    if (EK_HAS_metallic_roughness | EK_HAS_transmission | EK_HAS_phong | EK_HAS_measured | EK_LAYERED | EK_HAS_energy_compensation | may_end)  // Lambert's lobe has no choice
      sample_2d(key, index, bounce_dimension(depth, DIM_CHOICE), &choice, &roulette);
    BsdfSample scattered = bsdf_sample(material, wo, scatter_u, scatter_v, choice);
    v3 next_dir = to_world(basis, scattered.wi);
    if (EK_HAS_nested_media) {
      scattered = media_pass(hidden, scattered);
      next_dir = select3(hidden, dir, next_dir);
    }
    const vu next_medium = scattered.wi.z < 0.0f ? beyond : medium;
    v3 next_beta = mul3(beta, scattered.weight);
    if ((EK_HAS_vertex_normal | EK_HAS_normal_texture) & detailed)
      next_beta = scale3(next_beta, fade(material, plain, scattered.wi, next_dir, n_geom, n_shade));
    vi survives = live & (scattered.pdf > 0.0f) & (hidden | agrees(scattered.wi, dot3(next_dir, n_geom))) &
                  (max_component(abs3(next_beta)) > 0.0f);
    if (!(EK_HAS_bsdf_emission | EK_HAS_next_event)) survives = (vi)(0);
    if (EK_HAS_whitted) survives = survives & scattered.delta;
    if (EK_HAS_raycast) survives = survives & hidden;
    if (may_end) {
      vf worth = max_component(abs3(next_beta));
      // Else a third of the paths that enter glass would end there for nothing.
      if (EK_HAS_transmission)
        worth = worth * (EK_HAS_nested_media ? media_radiance_outside(scene, next_medium)
                                             : radiance_returned_outside(material, front, scattered.wi.z < 0.0f));
      // Ending paths that carry more adds more error than it saves rays (PERFORMANCE.md).
      vf survival = min_f(ROULETTE_GAIN * worth, (vf)(depth < ROULETTE_ALWAYS_DEPTH ? 1.0f : 0.95f));
      if (EK_HAS_fixed_roulette) survival = (vf)(frame->roulette);
      if (EK_HAS_nested_media) survival = unseen ? (vf)(1.0f) : survival;
      survives = survives & (roulette < survival);
      next_beta = scale3(next_beta, (vf)(1.0f) / survival);
    }
    const v3 next_origin = offset_ray_origin(surface.p, surface.p_error, n_geom, next_dir);

#if EK_CHUNKED
    // [slot, slot + width) has been read, and next_count <= slot: whole vectors may be written there.
    const Packing go = packing(survives);
#define EK_KEEP(field, x) state_set_u(state, field, next_count, packed(go, x))
#else
#define EK_KEEP(field, x) state_set_u(state, field, slot, x)
    state_set_u(state, FIELD_next, slot, (survives ? 1u : 0u) | pending_rays);
#endif
    EK_KEEP(FIELD_path, path);
    EK_KEEP(FIELD_key, key);
    EK_KEEP(FIELD_index, index);
    EK_KEEP(FIELD_origin_x, AS_U(next_origin.x));
    EK_KEEP(FIELD_origin_y, AS_U(next_origin.y));
    EK_KEEP(FIELD_origin_z, AS_U(next_origin.z));
    EK_KEEP(FIELD_dir_x, AS_U(next_dir.x));
    EK_KEEP(FIELD_dir_y, AS_U(next_dir.y));
    EK_KEEP(FIELD_dir_z, AS_U(next_dir.z));
    EK_KEEP(FIELD_beta_r, AS_U(next_beta.x));
    EK_KEEP(FIELD_beta_g, AS_U(next_beta.y));
    EK_KEEP(FIELD_beta_b, AS_U(next_beta.z));
    EK_KEEP(FIELD_hit_triangle, EK_HAS_instance ? (vu)(EK_NO_HIT) : triangle);
    EK_KEEP(FIELD_pdf, AS_U(scattered.delta ? (vf)(-1.0f) : scattered.pdf));
    if (EK_HAS_light_tree & EK_HAS_next_event & EK_HAS_bsdf_emission) EK_KEEP(FIELD_facing, lit.facing);
    if (EK_HAS_MEDIUM) EK_KEEP(FIELD_medium, next_medium);
    if (EK_HAS_nested_media) EK_KEEP(FIELD_crossed, crossed + (unseen ? (vu)(1u) : (vu)(0u)));
    if (EK_HAS_environment & EK_HAS_next_event & EK_HAS_bsdf_emission)
      EK_KEEP(FIELD_pdf_environment, AS_U(environment_pdf_sr(frame->environment.w, scattered.wi.z, both_sides)));
#if EK_CHUNKED
    next_count += go.count;
#endif
  }
#if EK_LIT_IN_PAIRS
  if (lit_count == 1) {
    lit_hits[1] = lit_hits[0];
    lit_hits[1].live = (vi)(0);
    shadow_count = shade_lights(frame, scene, light_data, state, lit_hits, depth, shadow_count);
  }
#endif
  const Survivors survivors = {next_count, shadow_count};
  return survivors;
}

#endif
