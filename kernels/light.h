// SPDX-License-Identifier: Apache-2.0
// Light sampling: emissive triangles and the constant environment, chosen through an alias table. All densities include
// the probability of that choice, and every density that light_sample uses can be asked for without sampling.
#ifndef EK_LIGHT_H
#define EK_LIGHT_H
#include "sampler.h"
#include "surface.h"
#include "warp.h"

// Kinds of lights: Light.kind.
enum {
#define EK_LIGHT(name, bit) LIGHT_##name = bit,
#include "shared/features.def"
};

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

/// Density with which light_sample chooses a direction towards the environment.
/// probability  of choosing the environment (Frame.environment.w)
/// cos_n        of the direction with the z of the basis that light_sample was given (wi.z of the BSDF sample, if its
///              basis was the same; the miss of a scattered ray needs it)
EK_FN vf environment_pdf_sr(float probability, vf cos_n) {
  return max_f(cos_n, (vf)(0.0f)) * (EK_INV_PI * probability);
}

/// Whether a light of normal n_geom emits towards a viewer who looks along dir: from its front, or from both sides.
EK_FN vi emits_towards(v3 n_geom, vi double_sided, v3 dir) {
  return double_sided | (dot3(n_geom, dir) < 0.0f);
}

typedef struct {
  vu light;
  vf u, v;  // what is left of the sample, [0,1)^2
} LightChoice;

/// Chooses a light by the alias table, and gives back the random words for reuse.
/// a, b  pair of sample_2d_bits
// The bucket takes the leading part of `a`, so that strata of `a` are strata of lights; the rest, rescaled, is again
// uniform within the light. With n buckets it has 2^32 / n values only, fewer for an unlikely light: the low bits of
// `b`, which v does not use, fill the gaps between them, so that it is even to within the share of one value.
EK_FN LightChoice choose_light(global const LightBucket* buckets, uint light_count, vu a, vu b) {
  const vu bucket = mul_hi(a, (vu)(light_count));
  const vu rest = a * light_count;
  global const uint* words = (global const uint*)buckets;
  const vu threshold = gather_u(words, bucket * 4u);
  const vu alias = gather_u(words, bucket * 4u + 1u);
  const vf scale_own = AS_F(gather_u(words, bucket * 4u + 2u));
  const vf scale_alias = AS_F(gather_u(words, bucket * 4u + 3u));
  const vi own = rest < threshold;
  const vf place = TO_F(own ? rest : rest - threshold) + TO_F(mul_hi(b << 24, (vu)(light_count)));
  vf u = place * ((own ? scale_own : scale_alias) * 0x1p-32f);
  u = u < 1.0f ? u : u - 1.0f;  // the last value's gap reaches over the end: it fills the first one's
  LightChoice c = {own ? bucket : alias, min_f(u, (vf)(1.0f - 0x1p-24f)), to_unit_float(b)};
  return c;
}

typedef struct {
  vi is_environment;
  v3 p, p_error, n;  // of a triangle: world point, bound of its error, unit normal of the front
  vu triangle;       // index; 0 for other lights
  vf u, v;           // weights of its second and third corner
  v3 wi;             // of the environment: world, unit
  v3 radiance;       // W / (sr m^2); for a triangle that of its front
  vi double_sided;
  vi is_delta;       // no scattered ray can meet it
  vf pdf;            // per m^2 for a triangle, per sr for the environment
} LightSample;

/// Samples a light.
/// environment  radiance; w: probability of choosing it (Frame)
/// basis        of the shading point, z on the side of wo
/// a, b         pair of sample_2d_bits(DIM_LIGHT)
// The environment is sampled by the cosine about z: for a constant radiance that is the whole integrand of a diffuse
// surface but the visibility, so an open sky costs no noise at all. Of a uniform sphere half would be lost below the
// surface. Lobes that transmit will want the other side as well.
EK_FN LightSample light_sample(global const Light* lights, global const LightBucket* buckets, uint light_count,
                               float4 environment, Basis basis, vu a, vu b) {
  const LightChoice choice = choose_light(buckets, light_count, a, b);
  const Rec r = rec16(lights, choice.light);
  LightSample s;
  s.is_environment = (vi)(0);
  s.is_delta = (vi)(0);
  if (EK_HAS_environment) s.is_environment = AS_U(r.we) == (uint)LIGHT_environment;
  vf b1, b2;
  warp_triangle(choice.u, choice.v, &b1, &b2);
  const v3 p0 = V3(r.w0, r.w1, r.w2), p1 = V3(r.w3, r.w4, r.w5), p2 = V3(r.w6, r.w7, r.w8);
  s.p = triangle_point(p0, p1, p2, b1, b2, &s.p_error);
  s.n = triangle_normal(p0, p1, p2);
  s.triangle = AS_U(r.wf);
  s.u = b1;
  s.v = b2;
  s.wi = neg3(s.n);
  s.radiance = V3(r.w9, r.wa, r.wb);
  s.pdf = r.wc;
  s.double_sided = AS_U(r.wd) != 0u;
  if (EK_HAS_environment && ANY(s.is_environment)) {
    const v3 wi_local = warp_cosine_hemisphere(choice.u, choice.v);
    s.wi = to_world(basis, wi_local);
    s.radiance = select3(s.is_environment, splat3(environment), s.radiance);
    s.pdf = s.is_environment ? environment_pdf_sr(environment.w, wi_local.z) : s.pdf;
  }
  return s;
}

// A sampled light as the shading point sees it, and the shadow ray towards it.
typedef struct {
  v3 wi;        // world, unit
  vf pdf;       // per sr; 0: nothing arrives (edge on, the back of a one-sided light, no distance)
  v3 origin;    // shadow ray: off the surface
  v3 dir;       // not unit: the light is at t = 1
  vf t_max;     // a little less than 1, or infinity towards the environment
} LightPath;

/// p, p_error, n_geom  of the shading point
// The shadow ray must not meet the light itself. The target is moved off the light's plane by the error of the point on
// it; the ray's own rounding, some 2^-21 of its length over the cosine at the light, is taken off t_max, without scale.
EK_FN LightPath light_path(LightSample s, v3 p, v3 p_error, v3 n_geom) {
  const v3 to_light = sub3(s.p, p);
  const vf distance = sqrt(dot3(to_light, to_light));
  const v3 wi_area = scale3(to_light, (vf)(1.0f) / distance);
  LightPath path;
  path.wi = select3(s.is_environment, s.wi, wi_area);
  const vi visible = (distance > 0.0f) & emits_towards(s.n, s.double_sided, wi_area);
  const vf pdf_area = visible ? pdf_sr_from_m2(s.pdf, s.n, wi_area, distance) : (vf)(0.0f);
  path.pdf = s.is_environment ? s.pdf : pdf_area;
  path.origin = offset_ray_origin(p, p_error, n_geom, path.wi);
  const v3 target = offset_ray_origin(s.p, s.p_error, s.n, neg3(wi_area));
  path.dir = select3(s.is_environment, s.wi, sub3(target, path.origin));
  const vf margin = min_f(0x1p-17f / abs_f(dot3(s.n, wi_area)), (vf)(0x1p-8f));
  path.t_max = s.is_environment ? EK_INFINITY : 1.0f - margin;
  return path;
}

#endif
