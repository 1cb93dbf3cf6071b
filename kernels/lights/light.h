// SPDX-License-Identifier: Apache-2.0
// Light sampling: emissive triangles, the environment, and lights without extent, chosen through an alias table. All
// densities include the probability of that choice, and every density of a light that rays can meet can be asked for
// without sampling.
#ifndef EK_LIGHT_H
#define EK_LIGHT_H
#include "lights/environment_map.h"
#include "lights/light_choice.h"
#include "lights/punctual.h"
#include "lights/light_samples.h"
#include "lights/light_tree.h"
#include "surface/surface.h"
#include "lanes/warp.h"

// Kinds of lights: Light.kind.
enum {
#define EK_LIGHT(name, bit) LIGHT_##name = bit,
#include "shared/features.def"
};

// The arrays that lights are sampled from; without a map its two are dummies.
typedef struct {
  global const Light* lights;
  global const LightBucket* light_buckets;
  global const float4* environment_texels;  // radiance; w: density of light sampling, per sr
  global const LightBucket* environment_buckets;
#if EK_HAS_light_tree
  global const LightNode* light_nodes;
#endif
} LightData;

// The same as arguments of a kernel; they are bound by these names.
#if EK_HAS_light_tree
#define EK_TREE_ARGUMENTS , global const LightNode *light_nodes
#define EK_TREE_DATA , light_nodes
#else
#define EK_TREE_ARGUMENTS
#define EK_TREE_DATA
#endif
#define EK_LIGHT_ARGUMENTS                                                                                             \
  global const Light *lights, global const LightBucket *light_buckets, global const float4 *environment_texels,       \
      global const LightBucket *environment_buckets EK_TREE_ARGUMENTS
#define EK_LIGHT_DATA {lights, light_buckets, environment_texels, environment_buckets EK_TREE_DATA}

/// Weight of a strategy of density a against another of density b [Veach 1995, the power heuristic with exponent 2].
/// In [0, 1], and the two weights add to 1, whatever the densities are: huge, both zero, infinite.
EK_FN vf power_heuristic(vf a, vf b) {
  vf ratio = b / a;
  ratio = ratio == ratio ? ratio : (vf)(1.0f);  // 0 / 0, inf / inf: no preference
  return 1.0f / (1.0f + ratio * ratio);
}

/// Density per sr, seen from the ray's origin, of a density per m^2 at the point where the unit direction dir meets a
/// surface of normal n_geom at distance t; 0 edge on.
EK_FN vf pdf_sr_from_m2(vf pdf_m2, v3 n_geom, v3 dir, vf t) {
  const vf cos_light = abs_f(dot3(n_geom, dir));
  return cos_light > 0.0f ? (pdf_m2 * (t * t)) / cos_light : (vf)(0.0f);
}

/// Density with which light_sample chooses the point of an emissive triangle that a ray met, as seen from its origin.
/// light_pdf_m2  of the triangle (load_triangle); dir: unit; t: distance
EK_FN vf light_pdf_sr_of_hit(vf light_pdf_m2, v3 n_geom, v3 dir, vf t) {
  return pdf_sr_from_m2(light_pdf_m2, n_geom, dir, t);
}

/// Density with which light_sample chooses a direction towards the constant environment.
/// probability  of choosing the environment (Frame.environment.w)
/// cos_n        of the direction with the z of the basis that light_sample was given (wi.z of the BSDF sample, if its
///              basis was the same; the miss of a scattered ray needs it)
/// both_sides   mask, as light_sample was given it
EK_FN vf environment_pdf_sr(float probability, vf cos_n, vi both_sides) {
  const vf one_side = max_f(cos_n, (vf)(0.0f)) * (EK_INV_PI * probability);
  if (!EK_HAS_transmission) return one_side;
  return both_sides ? abs_f(cos_n) * (EK_INV_PI * 0.5f * probability) : one_side;
}

/// Whether a light of normal n_geom emits towards a viewer who looks along dir: from its front, or from both sides.
EK_FN vi emits_towards(v3 n_geom, vi double_sided, v3 dir) {
  return double_sided | (dot3(n_geom, dir) < 0.0f);
}

// The random words of one light sample.
typedef struct {
  vu a, b;  // light, and the point on it
  vu c, d;  // texel of the map and place in it; unset without a map
  uint which;  // light, of EK_HAS_each_light
} LightWords;

// Of how many samples the estimate of a vertex is the mean. The lights that are each sampled add up instead.
#define EK_LIGHT_MEAN (EK_HAS_each_light ? 1.0f : (float)EK_LIGHT_SAMPLES)

/// which  sample of the vertex, below EK_LIGHT_SAMPLES
EK_FN LightWords light_words(vu key, vu index, uint depth, uint which) {
  LightWords words;
  words.which = which;
  if (EK_HAS_each_light) {
    key = key + which * 0x632be5abu;  // lights are strangers to each other
  } else if (EK_LIGHT_SAMPLES > 1) {
    // The samples of a vertex stand beside each other in one sequence, so that they share out the lights between them.
    key = key + mul_hi(index, (vu)(EK_LIGHT_SAMPLES)) * 0x632be5abu;
    index = index * (uint)EK_LIGHT_SAMPLES + which;
  }
  sample_2d_bits(key, index, bounce_dimension(depth, DIM_LIGHT), &words.a, &words.b);
  if (EK_HAS_environment_map) sample_2d_bits(key, index, bounce_dimension(depth, DIM_ENVIRONMENT), &words.c, &words.d);
  return words;
}

typedef struct {
  vi is_distant;     // environment, map, directional: light from a direction wi
  vi is_punctual;    // point, spot: light from a point that has no surface
  vi is_shape;       // shape_light_sample (lights/shape_light.h) has yet to find its point; then pdf is per sr
  vi is_delta;       // no scattered ray can meet it: pdf is the probability of selection
  v3 p, p_error, n;  // of a triangle: world point, bound of its error, unit normal of the front; p of a punctual one
  v3 wi;             // of distant ones: world, unit; of a spot: back along its axis
  v3 radiance;       // W / (sr m^2), of a triangle that of its front; punctual: intensity, W / sr; directional: W / m^2
  vi double_sided;
  vf pdf;            // per m^2 for a triangle, per sr for the environment
  vu group;          // light group
  vu triangle;       // of an area light, and the weights of its second and third corner
  vf b1, b2;
  vf u, v;    // of a shape: place on it, [0,1)^2
  vf cone_cos, cone_scale, range2;  // of punctual ones: see spot_falloff, punctual_falloff
} LightSample;

/// A light that was chosen, and with what probability among those that are chosen by the tree.
typedef struct {
  LightChoice choice;
  vf probability;
} PickedLight;

// Entry 0 of the table is the tree, if there is one; lights that have no place stand behind its own.
#if EK_HAS_light_tree
// Where the table leaves it to the tree.
EK_FN TreeSearch search_of(constant Frame* frame, LitPoint lit, vi wanted, LightWords words, LightChoice choice) {
  const vu more = hash_bits(words.b);
  // With nothing beside the tree the whole word is its own, else the 24 bits that are left of it.
  const vu word = frame->light_count == 1u ? words.a : (AS_U(TO_I(choice.u * 0x1p24f)) << 8) | (more >> 24);
  return tree_search(frame->tree_light_count, frame->light_scale, lit, (choice.light == 0u) & wanted, word, more);
}

EK_FN PickedLight picked_by(constant Frame* frame, TreeSearch search, LightChoice choice) {
  const TreeChoice leaf = tree_search_end(search);
  const vi in_tree = choice.light == 0u;
  choice.light = in_tree ? leaf.light : choice.light + (frame->tree_light_count - 1u);
  choice.u = in_tree ? leaf.u : choice.u;
  const PickedLight picked = {choice, in_tree ? leaf.probability : (vf)(1.0f)};
  return picked;
}

/// pick_light for two at a time: each waits for its nodes and its arithmetic while the other goes on.
EK_FN void pick_two_lights(constant Frame* frame, LightData data, LitPoint lit_a, vi wanted_a, LightWords words_a, LitPoint lit_b,
                           vi wanted_b, LightWords words_b, PickedLight* picked) {
  const LightChoice a = choose_light(data.light_buckets, frame->light_count, words_a.a, words_a.b),
                    b = choose_light(data.light_buckets, frame->light_count, words_b.a, words_b.b);
  TreeSearch of_a = search_of(frame, lit_a, wanted_a, words_a, a), of_b = search_of(frame, lit_b, wanted_b, words_b, b);
  while (ANY(of_a.walk.open | of_b.walk.open)) {
    tree_search_step(data.light_nodes, &of_a);
    tree_search_step(data.light_nodes, &of_b);
  }
  picked[0] = picked_by(frame, of_a, a);
  picked[1] = picked_by(frame, of_b, b);
}
#endif

EK_FN PickedLight pick_among_all(constant Frame* frame, LightData data, LitPoint lit, vi wanted, LightWords words) {
  const LightChoice choice = choose_light(data.light_buckets, frame->light_count, words.a, words.b);
#if EK_HAS_light_tree
  TreeSearch search = search_of(frame, lit, wanted, words, choice);
  while (ANY(search.walk.open)) tree_search_step(data.light_nodes, &search);
  return picked_by(frame, search, choice);
#else
  const PickedLight picked = {choice, (vf)(1.0f)};
  return picked;
#endif
}

// The words of the only light as choose_light would leave them.
EK_FN LightChoice only_choice(LightWords words) {
  const vf u = word_to_float(words.a) * 0x1p-32f;
  const LightChoice c = {(vu)(0u), u < 1.0f ? u : u - 1.0f, to_unit_float(words.b)};
  return c;
}

EK_FN LightChoice own_choice(LightWords words, uint light_count) {
  LightChoice c = only_choice(words);
  c.light = (vu)(min(words.which, max(light_count, 1u) - 1u));
  return c;
}

#define EK_HAS_near_light (EK_HAS_area | EK_HAS_point | EK_HAS_spot)  // some light has a place

/// Chooses a light.
/// lit     the shading point, as the tree knows it
/// wanted  mask: lanes whose sample counts
EK_FN PickedLight pick_light(constant Frame* frame, LightData data, LitPoint lit, vi wanted, LightWords words) {
  if (!EK_HAS_one_light & !EK_HAS_each_light) return pick_among_all(frame, data, lit, wanted, words);
  const PickedLight picked = {EK_HAS_one_light ? only_choice(words) : own_choice(words, frame->light_count), (vf)(1.0f)};
  return picked;
}

/// Samples the light that was chosen.
/// basis       of the shading point, z on the side of wo
/// both_sides  mask: light from below the surface counts too
// The constant environment is sampled by the cosine about z: for a constant radiance that is the whole integrand of a
// diffuse surface but the visibility, so an open sky costs no noise at all. Of a uniform sphere half would be lost below
// the surface.
EK_FN LightSample light_sample(constant Frame* frame, LightData data, PickedLight picked, Basis basis, vi both_sides,
                               LightWords words) {
  const LightChoice choice = picked.choice;
  const LightLanes r = EK_HAS_one_light ? broadcast_light(data.lights) : load_light(data.lights, choice.light);
  const vu kind = r.kind;
  LightSample s;
  s.is_distant = s.is_punctual = s.is_shape = s.is_delta = (vi)(0);
  warp_triangle(choice.u, choice.v, &s.b1, &s.b2);
  const v3 p0 = r.p0, p1 = r.p1, p2 = r.p2;
  if (EK_HAS_quad_light) {
    const vi is_quad = (r.flags & EK_LIGHT_QUAD) != 0u;
    s.b1 = is_quad ? choice.u : s.b1;
    s.b2 = is_quad ? choice.v : s.b2;
  }
  if (EK_HAS_near_light) {
    s.p = triangle_point(p0, p1, p2, s.b1, s.b2, &s.p_error);
    s.n = triangle_normal(p0, p1, p2);
    s.wi = neg3(s.n);
  } else {
    s.p = s.p_error = s.n = s.wi = basis.z;
  }
  s.radiance = r.emission;
  s.pdf = EK_HAS_light_tree ? r.pdf_m2 * picked.probability : r.pdf_m2;
  s.double_sided = (r.flags & EK_LIGHT_DOUBLE_SIDED) != 0u;
  s.group = r.flags >> EK_LIGHT_GROUP_SHIFT;
  s.triangle = r.triangle;
  if (EK_HAS_shape_light) {
    s.is_shape = kind == (uint)LIGHT_shape_light;
    s.u = choice.u;
    s.v = choice.v;
  }
  if (EK_HAS_environment) {
    const vi is = kind == (uint)LIGHT_environment;
    if (ANY(is)) {
      vf u = choice.u;
      vi below = (vi)(0);
      if (EK_HAS_transmission) {
        below = both_sides & (u >= 0.5f);
        u = both_sides ? 2.0f * (below ? u - 0.5f : u) : u;
      }
      v3 wi_local = warp_cosine_hemisphere(u, choice.v);
      wi_local.z = below ? -wi_local.z : wi_local.z;
      s.is_distant = is;
      s.wi = select3(is, to_world(basis, wi_local), s.wi);
      s.radiance = select3(is, splat3(frame->environment), s.radiance);
      s.pdf = is ? environment_pdf_sr(frame->environment.w, wi_local.z, both_sides) : s.pdf;
    }
  }
  if (EK_HAS_environment_map) {
    const vi is = kind == (uint)LIGHT_environment_map;
    if (ANY(is)) {
      MapValue value;
      const v3 wi =
          environment_map_sample(frame, data.environment_texels, data.environment_buckets, words.c, words.d, &value);
      s.is_distant = s.is_distant | is;
      s.wi = select3(is, wi, s.wi);
      s.radiance = select3(is, value.radiance, s.radiance);
      s.pdf = is ? value.pdf : s.pdf;
    }
  }
  if (EK_HAS_directional) {
    const vi is = kind == (uint)LIGHT_directional;
    s.is_distant = s.is_distant | is;
    s.is_delta = s.is_delta | is;
    s.wi = select3(is, p1, s.wi);
  }
  if (EK_HAS_point | EK_HAS_spot) {
    s.is_punctual = (kind == (uint)LIGHT_point) | (kind == (uint)LIGHT_spot);
    s.is_delta = s.is_delta | s.is_punctual;
    s.p = select3(s.is_punctual, p0, s.p);
    s.wi = select3(s.is_punctual, p1, s.wi);
    s.cone_cos = p2.x;
    s.cone_scale = p2.y;
    s.range2 = p2.z;
  }
  return s;
}

// A sampled light as the shading point sees it, and the shadow ray towards it.
typedef struct {
  v3 wi;        // world, unit
  vf pdf;       // per sr; 0: nothing arrives (edge on, the back of a one-sided light, no distance)
  v3 radiance;  // that arrives; of a delta light the irradiance at normal incidence, and pdf the probability of selection
  v3 origin;    // shadow ray: off the surface
  v3 dir;       // not unit: the light is at t = 1
  vf t_max;     // a little less than 1, or infinity towards distant lights
  vu goal;      // RayEnds: the triangle that it goes to
} LightPath;

/// p, p_error, n_geom  of the shading point
// The shadow ray must not meet the light itself. The target is moved off the light's plane by the error of the point on
// it; the ray's own rounding, some 2^-21 of its length over the cosine at the light, is taken off t_max, without scale. A
// light without extent may be placed on a surface, which is not in its way either.
EK_FN LightPath light_path(LightSample s, v3 p, v3 p_error, v3 n_geom) {
  if (!EK_HAS_near_light) {
    const LightPath far = {s.wi, s.pdf, s.radiance, offset_ray_origin(p, p_error, n_geom, s.wi), s.wi, EK_INFINITY, (vu)(EK_NO_HIT)};
    return far;
  }
  const v3 to_light = sub3(s.p, p);
  const vf distance2 = dot3(to_light, to_light);
  const vf distance = sqrt(distance2);
  const v3 wi_near = scale3(to_light, (vf)(1.0f) / distance);
  LightPath path;
  path.wi = select3(s.is_distant, s.wi, wi_near);
  const vi visible = (distance > 0.0f) & emits_towards(s.n, s.double_sided, wi_near);
  vf pdf_near = visible ? pdf_sr_from_m2(s.pdf, s.n, wi_near, distance) : (vf)(0.0f);
  if (EK_HAS_shape_light) pdf_near = (visible & s.is_shape) ? s.pdf : pdf_near;
  path.radiance = s.radiance;
  if (EK_HAS_point | EK_HAS_spot) {
    vf falloff = punctual_falloff(distance2, s.range2);
    if (EK_HAS_spot) falloff = falloff * spot_falloff(dot3(s.wi, wi_near), s.cone_cos, s.cone_scale);
    path.radiance = select3(s.is_punctual, scale3(s.radiance, falloff), path.radiance);
    const vf pdf_punctual = distance2 > 0x1p-100f ? s.pdf : (vf)(0.0f);  // nearer there is no inverse square
    pdf_near = s.is_punctual ? pdf_punctual : pdf_near;
  }
  path.pdf = s.is_distant ? s.pdf : pdf_near;
  path.origin = offset_ray_origin(p, p_error, n_geom, path.wi);
  v3 target = offset_ray_origin(s.p, s.p_error, s.n, neg3(wi_near));
  vf margin = min_f(0x1p-17f / abs_f(dot3(s.n, wi_near)), (vf)(0x1p-8f));
  if (EK_HAS_point | EK_HAS_spot) {
    target = select3(s.is_punctual, s.p, target);
    margin = s.is_punctual ? (vf)(0x1p-17f) : margin;
  }
  path.dir = select3(s.is_distant, s.wi, sub3(target, path.origin));
  path.goal = (s.is_distant | s.is_punctual | s.is_shape) ? (vu)(EK_NO_HIT) : s.triangle;
  path.t_max = s.is_distant ? EK_INFINITY : 1.0f - margin;
  return path;
}

#endif
