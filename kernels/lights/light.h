// SPDX-License-Identifier: Apache-2.0
// Sampling of lights: emissive surfaces, the environment, and lights without extent, chosen by an
// alias table or by the light tree. All densities include the probability of that choice. The
// density of any light that rays can meet is available without sampling.
#ifndef EK_LIGHT_H
#define EK_LIGHT_H
#include "bsdf/lobe_traits.h"
#include "lanes/basis.h"
#include "lanes/warp.h"
#include "guide/guide.h"
#include "lights/alias_table.h"
#include "lights/density.h"
#include "lights/environment_map.h"
#include "lights/light_samples.h"
#include "lights/light_tree.h"
#include "lights/photon_map.h"
#include "lights/punctual.h"
#include "surface/surface.h"
#if EK_HAS_light_paths
#include "lights/light_path_data.h"
#endif

// Kinds of lights: Light.kind.
enum {
#define EK_LIGHT(name, bit) LIGHT_##name = bit,
#include "shared/features.def"
};

// The arrays that lights are sampled from. Without an environment map its two are dummies.
typedef struct {
  global const Light* lights;
  global const AliasEntry* light_alias_table;
  global const float4* environment_texels;  // radiance; w: density of light sampling, per sr
  global const AliasEntry* environment_alias_table;
#if EK_HAS_light_tree
  global const LightNode* light_nodes;
#endif
#if EK_HAS_moving_light
  global const Light* light_poses;
#endif
#if EK_HAS_light_paths
  LightPathData light_paths;
#endif
#if EK_HAS_merging
  PhotonMap photon_map;
#endif
#if EK_USES_GUIDE
  GuideData guide;
#endif
} LightData;

// The same as arguments of a kernel, which are bound by these names.
#if EK_HAS_light_tree
#define EK_TREE_ARGUMENTS , global const LightNode *light_nodes
#define EK_TREE_DATA , light_nodes
#else
#define EK_TREE_ARGUMENTS
#define EK_TREE_DATA
#endif
#if !EK_HAS_light_paths
#define EK_LIGHT_PATH_ARGUMENTS
#define EK_LIGHT_PATH_DATA
#endif
#define EK_LIGHT_ARGUMENTS                                                                                             \
  global const Light *lights, global const AliasEntry *light_alias_table, global const float4 *environment_texels,       \
      global const AliasEntry *environment_alias_table EK_TREE_ARGUMENTS EK_LIGHT_POSE_ARGUMENTS EK_LIGHT_PATH_ARGUMENTS EK_PHOTON_ARGUMENTS EK_GUIDE_ARGUMENTS
#define EK_LIGHT_DATA {lights, light_alias_table, environment_texels, environment_alias_table EK_TREE_DATA EK_LIGHT_POSE_DATA EK_LIGHT_PATH_DATA EK_PHOTON_DATA EK_GUIDE_DATA}

// True if light may count from below a shading point's z.
#define EK_USES_BOTH_SIDES (has_lobe_with(EK_TRAIT_TRANSMITS) | EK_HAS_clearcoat_normal)

/// Density with which light_sample chooses a direction towards the constant environment.
/// probability  of choosing the environment (Frame.environment.w)
/// cos_n        cosine of the direction with the z of light_sample's basis: wi.z of a BSDF sample
///              in the same basis
/// both_sides   mask, as for light_sample
EK_FN vf environment_pdf_sr(float probability, vf cos_n, vi both_sides) {
  const vf one_side = max_f(cos_n, (vf)(0.0f)) * (EK_INV_PI * probability);
  if (!EK_USES_BOTH_SIDES) return one_side;
  return both_sides ? abs_f(cos_n) * (EK_INV_PI * 0.5f * probability) : one_side;
}

/// Mask of the lights of normal n_geom that emit towards a viewer who looks along dir.
EK_FN vi emits_towards(v3 n_geom, vi double_sided, v3 dir) {
  return double_sided | (dot3(n_geom, dir) < 0.0f);
}

// The random words of one light sample.
typedef struct {
  vu a, b;     // for the light, and the point on it
  vu c, d;     // for the texel of the environment map, and the point in it; unset without a map
  uint which;  // EK_HAS_each_light: index of the light
} LightWords;

// What the sum over a vertex's samples is divided by. With EK_HAS_each_light each sample is of
// another light, and the sum is the estimate.
#define EK_LIGHT_MEAN (EK_HAS_each_light ? 1.0f : (float)EK_LIGHT_SAMPLES)

/// which  sample of the vertex, below EK_LIGHT_SAMPLES
EK_FN LightWords light_words(vu key, vu index, uint depth, uint which) {
  LightWords words;
  words.which = which;
  if (EK_HAS_each_light) {
    // Each light has its own scramble, so their samples are independent.
    key = key + which * EK_LIGHT_SAMPLE_KEY;
  } else if (EK_LIGHT_SAMPLES > 1) {
    // The samples of a vertex are consecutive in one sequence, so that they are stratified over the
    // lights.
    key = key + mul_hi(index, (vu)(EK_LIGHT_SAMPLES)) * EK_LIGHT_SAMPLE_KEY;
    index = index * (uint)EK_LIGHT_SAMPLES + which;
  }
  sample_2d_bits(key, index, bounce_dimension(depth, DIM_LIGHT), &words.a, &words.b);
  if (EK_HAS_environment_map) sample_2d_bits(key, index, bounce_dimension(depth, DIM_ENVIRONMENT), &words.c, &words.d);
  return words;
}

// A sampled light, before a shading point sees it (LightRay). Its kind gives members their units:
//   kind               radiance       pdf                            place
//   triangle           W / (sr m^2)   1 / m^2                        p, p_error, n
//   shape              W / (sr m^2)   probability of selection;      shape_light_sample finds
//                                     then 1 / sr                    p, p_error, n
//   environment, map   W / (sr m^2)   1 / sr                         wi: towards it
//   point              W / sr         probability of selection       p
//   spot               W / sr         probability of selection       p; wi: back along its axis
//   directional        W / m^2        probability of selection       wi: towards it
typedef struct {
  vi is_distant;     // environment, map, directional
  vi is_punctual;    // point, spot
  vi is_shape;
  vi is_delta;       // point, spot, directional: no scattered ray can meet the light
  v3 p, p_error, n;  // world: point, bound of its error, normal of the front
  v3 wi;             // world, unit
  v3 radiance;       // of a surface that on its front
  vi double_sided;
  vf pdf;
  vu group;          // light group
  vu triangle;       // of an area light,
  vf b1, b2;         // and the weights of its second and third corner
  vf u, v;           // shape: random numbers for the point, [0,1)^2
  vf cone_cos, cone_scale, range2;  // punctual: see spot_falloff, punctual_falloff
#if EK_HAS_light_paths
  vf pdf_of_point;  // of surfaces, as start_pdf_m2 takes it
#endif
} LightSample;

/// A shading point as a light is sampled for it.
typedef struct {
  Basis basis;    // z on the side of wo
  vi both_sides;  // mask: light from below the basis counts too
#if EK_HAS_moving_light
  vf time;        // share of the shutter's time that has passed
#endif
#if EK_USES_GUIDE
  GuideCell guide;
#endif
} LightViewer;

/// A chosen light, and the probability with which the tree chose it; 1 where the tree did not
/// choose.
typedef struct {
  AliasSample choice;
  vf probability;
} PickedLight;

/// A shading point that wants a light.
typedef struct {
  LightSampleContext context;
  vi wanted;  // mask: lanes whose sample counts
  LightWords words;
} LightQuery;

// With a tree, entry 0 of the alias table stands for the tree, and the other entries for the lights
// that are not in it: their records are behind those of the tree.
#if EK_HAS_light_tree
// The walk through the tree for the lanes for which the table chose the tree.
EK_FN TreeSearch search_of(constant Frame* frame, LightQuery query, AliasSample choice) {
  const vu more = hash_bits(query.words.b);
  // If the tree is the only entry it has the whole word, else the 24 bits that the table left.
  const vu word = frame->light_count == 1u ? query.words.a : (AS_U(TO_I(choice.u * 0x1p24f)) << 8) | (more >> 24);
  return tree_search(frame->tree_light_count, frame->light_scale, query.context, (choice.index == 0u) & query.wanted, word, more);
}

EK_FN PickedLight picked_by(constant Frame* frame, TreeSearch search, AliasSample choice) {
  const TreeChoice leaf = tree_search_end(search);
  const vi in_tree = choice.index == 0u;
  choice.index = in_tree ? leaf.light : choice.index + (frame->tree_light_count - 1u);
  choice.u = in_tree ? leaf.u : choice.u;
  const PickedLight picked = {choice, in_tree ? leaf.probability : (vf)(1.0f)};
  return picked;
}

/// pick_light for two queries at once: each waits for its nodes and its arithmetic while the other
/// goes on.
EK_FN void pick_two_lights(constant Frame* frame, LightData data, const LightQuery* queries, PickedLight* picked) {
  const LightWords words_a = queries[0].words, words_b = queries[1].words;
  const AliasSample a = alias_table_sample(data.light_alias_table, frame->light_count, words_a.a, words_a.b),
                    b = alias_table_sample(data.light_alias_table, frame->light_count, words_b.a, words_b.b);
  TreeSearch of_a = search_of(frame, queries[0], a), of_b = search_of(frame, queries[1], b);
  while (ANY(of_a.walk.open | of_b.walk.open)) {
    tree_search_step(data.light_nodes, &of_a);
    tree_search_step(data.light_nodes, &of_b);
  }
  picked[0] = picked_by(frame, of_a, a);
  picked[1] = picked_by(frame, of_b, b);
}
#endif

EK_FN PickedLight pick_among_all(constant Frame* frame, LightData data, LightQuery query) {
  const AliasSample choice = alias_table_sample(data.light_alias_table, frame->light_count, query.words.a, query.words.b);
#if EK_HAS_light_tree
  TreeSearch search = search_of(frame, query, choice);
  while (ANY(search.walk.open)) tree_search_step(data.light_nodes, &search);
  return picked_by(frame, search, choice);
#else
  const PickedLight picked = {choice, (vf)(1.0f)};
  return picked;
#endif
}

// The choice of the only light, with the random words as alias_table_sample would leave them.
EK_FN AliasSample only_choice(LightWords words) {
  const vf u = word_to_float(words.a) * 0x1p-32f;
  const AliasSample c = {(vu)(0u), u < 1.0f ? u : u - 1.0f, to_unit_float(words.b)};
  return c;
}

EK_FN AliasSample own_choice(LightWords words, uint light_count) {
  AliasSample c = only_choice(words);
  c.index = (vu)(min(words.which, max(light_count, 1u) - 1u));
  return c;
}

// True if some light has a place.
#define EK_USES_NEAR_LIGHT (EK_HAS_area | EK_HAS_point | EK_HAS_spot)

/// Chooses a light.
EK_FN PickedLight pick_light(constant Frame* frame, LightData data, LightQuery query) {
  if (!EK_HAS_one_light & !EK_HAS_each_light) return pick_among_all(frame, data, query);
  const PickedLight picked = {EK_HAS_one_light ? only_choice(query.words) : own_choice(query.words, frame->light_count), (vf)(1.0f)};
  return picked;
}

// The constant environment is sampled by the cosine about z: for a constant radiance that is the
// whole integrand of a diffuse surface but for visibility, so an open sky has no variance at all.
// Half the samples of a uniform sphere would be lost below the surface.
EK_FN void sample_environment(constant Frame* frame, AliasSample choice, LightViewer viewer, vi is, LightSample* s) {
  const vi both_sides = viewer.both_sides;
  vf u = choice.u, v = choice.v;
  vi below = (vi)(0);
  if (EK_USES_BOTH_SIDES) {
    below = both_sides & (u >= 0.5f);
    u = both_sides ? 2.0f * (below ? u - 0.5f : u) : u;
  }
  vf over_cosine = (vf)(1.0f);
#if EK_USES_GUIDE
  over_cosine = guide_warp(viewer.guide, &u, &v);
#endif
  v3 wi_local = warp_cosine_hemisphere(u, v);
  wi_local.z = below ? -wi_local.z : wi_local.z;
  s->is_distant = is;
  s->wi = select3(is, to_world(viewer.basis, wi_local), s->wi);
  s->radiance = select3(is, splat3(frame->environment), s->radiance);
  s->pdf = is ? environment_pdf_sr(frame->environment.w, wi_local.z, both_sides) * over_cosine : s->pdf;
}

EK_FN void sample_environment_map(constant Frame* frame, LightData data, LightWords words, vi is, LightSample* s) {
  MapValue value;
  const v3 wi =
      environment_map_sample(frame, data.environment_texels, data.environment_alias_table, words.c, words.d, &value);
  s->is_distant = s->is_distant | is;
  s->wi = select3(is, wi, s->wi);
  s->radiance = select3(is, value.radiance, s->radiance);
  s->pdf = is ? value.pdf : s->pdf;
}

EK_FN void sample_punctual(LightLanes r, LightSample* s) {
  s->is_punctual = (r.kind == (uint)LIGHT_point) | (r.kind == (uint)LIGHT_spot);
  s->is_delta = s->is_delta | s->is_punctual;
  s->p = select3(s->is_punctual, r.p0, s->p);
  s->wi = select3(s->is_punctual, r.p1, s->wi);
  s->cone_cos = r.p2.x;
  s->cone_scale = r.p2.y;
  s->range2 = r.p2.z;
}

/// Samples the light that was chosen.
EK_FN LightSample light_sample(constant Frame* frame, LightData data, PickedLight picked, LightViewer viewer,
                               LightWords words) {
  const AliasSample choice = picked.choice;
  LightLanes r = EK_HAS_one_light ? broadcast_light(data.lights) : load_light(data.lights, choice.index);
#if EK_HAS_moving_light
  const vi moves = (r.kind != (uint)LIGHT_area) & (r.kind != (uint)LIGHT_shape_light) & (r.triangle != 0u);
  r = moved_punctual(frame, data.light_poses, r, moves, viewer.time);
#endif
  LightSample s;
  s.is_distant = s.is_punctual = s.is_shape = s.is_delta = (vi)(0);
  warp_triangle(choice.u, choice.v, &s.b1, &s.b2);
  if (EK_HAS_quad_light) {
    const vi is_quad = (r.flags & EK_LIGHT_QUAD) != 0u;
    s.b1 = is_quad ? choice.u : s.b1;
    s.b2 = is_quad ? choice.v : s.b2;
  }
  if (EK_USES_NEAR_LIGHT) {
    s.p = triangle_point(r.p0, r.p1, r.p2, s.b1, s.b2, &s.p_error);
    s.n = triangle_normal(r.p0, r.p1, r.p2);
    s.wi = neg3(s.n);
  } else {
    s.p = s.p_error = s.n = s.wi = viewer.basis.z;
  }
  s.radiance = r.emission;
  s.pdf = EK_HAS_light_tree ? r.pdf_m2 * picked.probability : r.pdf_m2;
  s.double_sided = (r.flags & EK_LIGHT_DOUBLE_SIDED) != 0u;
  s.group = r.flags >> EK_LIGHT_GROUP_SHIFT;
  s.triangle = r.triangle;
  if (EK_HAS_shape_light) {
    s.is_shape = r.kind == (uint)LIGHT_shape_light;
    s.u = choice.u;
    s.v = choice.v;
  }
  if (EK_HAS_environment) {
    const vi is = r.kind == (uint)LIGHT_environment;
    if (ANY(is)) sample_environment(frame, choice, viewer, is, &s);
  }
  if (EK_HAS_environment_map) {
    const vi is = r.kind == (uint)LIGHT_environment_map;
    if (ANY(is)) sample_environment_map(frame, data, words, is, &s);
  }
  if (EK_HAS_directional) {
    const vi is = r.kind == (uint)LIGHT_directional;
    s.is_distant = s.is_distant | is;
    s.is_delta = s.is_delta | is;
    s.wi = select3(is, r.p1, s.wi);
  }
  if (EK_HAS_point | EK_HAS_spot) sample_punctual(r, &s);
  return s;
}

// A sampled light as seen from the shading point, and the shadow ray towards it.
typedef struct {
  v3 wi;        // world, unit
  vf pdf;       // per sr; 0: nothing arrives (edge on, the back of a one-sided light, no distance);
                // of a delta light the probability of selection
  v3 radiance;  // that arrives; of a delta light the irradiance at normal incidence
  v3 origin;    // shadow ray: off the surface
  v3 dir;       // not unit: the light is at t = 1
  vf t_max;     // a little less than 1, or infinity towards distant lights
  vu target_prim;  // RayEnds: the triangle at which it ends
} LightRay;

/// The share of a shadow ray's length by which it stops before its end, so that it does not meet
/// the surface there: the ray's own rounding is some 2^-21 of its length over the cosine, whatever
/// the scene's scale is. At grazing incidence it grows no further, so that the ray still meets what
/// is near the light.
/// cosine  of the ray with the surface, >= 0
EK_FN vf shadow_margin(vf cosine) { return min_f(div_f(0x1p-17f, cosine), (vf)(0x1p-8f)); }

/// The shadow ray must not meet the light itself. So its target is moved off the light's plane by
/// the error of the point, and it ends before by shadow_margin. A light without extent may lie on a
/// surface, which must not block it either. p, p_error, n_geom  of the shading point
EK_FN LightRay light_ray(LightSample s, v3 p, v3 p_error, v3 n_geom) {
  if (!EK_USES_NEAR_LIGHT) {
    const LightRay far = {s.wi, s.pdf, s.radiance, offset_ray_origin(p, p_error, n_geom, s.wi), s.wi, EK_INFINITY, (vu)(EK_NO_HIT)};
    return far;
  }
  const v3 to_light = sub3(s.p, p);
  const vf distance2 = dot3(to_light, to_light);
  const vf distance = sqrt_f(distance2);
  const v3 wi_near = scale3(to_light, div_f((vf)(1.0f), distance));
  LightRay path;
  path.wi = select3(s.is_distant, s.wi, wi_near);
  const vi visible = (distance > 0.0f) & emits_towards(s.n, s.double_sided, wi_near);
  vf pdf_near = visible ? pdf_sr_from_m2(s.pdf, s.n, wi_near, distance) : (vf)(0.0f);
  if (EK_HAS_shape_light) pdf_near = (visible & s.is_shape) ? s.pdf : pdf_near;
  path.radiance = s.radiance;
  if (EK_HAS_point | EK_HAS_spot) {
    vf falloff = punctual_falloff(distance2, s.range2);
    if (EK_HAS_spot) falloff = falloff * spot_falloff(dot3(s.wi, wi_near), s.cone_cos, s.cone_scale);
    path.radiance = select3(s.is_punctual, scale3(s.radiance, falloff), path.radiance);
    const vf pdf_punctual = distance2 > 0x1p-100f ? s.pdf : (vf)(0.0f);  // 1 / d^2 is finite
    pdf_near = s.is_punctual ? pdf_punctual : pdf_near;
  }
  path.pdf = s.is_distant ? s.pdf : pdf_near;
  path.origin = offset_ray_origin(p, p_error, n_geom, path.wi);
  v3 target = offset_ray_origin(s.p, s.p_error, s.n, neg3(wi_near));
  vf margin = shadow_margin(abs_f(dot3(s.n, wi_near)));
  if (EK_HAS_point | EK_HAS_spot) {
    target = select3(s.is_punctual, s.p, target);
    margin = s.is_punctual ? (vf)(0x1p-17f) : margin;
  }
  path.dir = select3(s.is_distant, s.wi, sub3(target, path.origin));
  path.target_prim = (s.is_distant | s.is_punctual | s.is_shape) ? (vu)(EK_NO_HIT) : s.triangle;
  path.t_max = s.is_distant ? EK_INFINITY : 1.0f - margin;
  return path;
}

#endif
