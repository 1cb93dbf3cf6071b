// SPDX-License-Identifier: Apache-2.0
// Rays against shapes. As a triangle does, a shape accepts t only inside the interval of its own
// box (ray.h), so that every structure gives the same hits; its id is its record's in the array of
// triangles, behind all of those.
#ifndef EK_SHAPE_HIT_H
#define EK_SHAPE_HIT_H
#include "shapes/shape.h"
#include "traverse/ray.h"

typedef struct {
  vi hit;
  vf t, part;
  vf gave_up;  // with EK_HAS_implicit the t at which the search for a surface was given up, or infinity
} ShapeHit;

#if EK_HAS_opacity
// The lanes whose ray passes root `number`, counted from its origin.
EK_FN vi shape_alpha_test_rejects(SceneData scene, vu id, vu shape, ShapePoint point, uint number, OpacityKey key) {
  const vf zero = (vf)(0.0f), one = (vf)(1.0f);
  const HitAttributes at = {V3(zero, zero, zero), point.u, point.v, point.u, point.v, V3(zero, zero, zero), one, one, one, one, one};
  const vu material = load_word_u(Triangle, scene.triangles, id, material);
  const vf opacity = material_opacity(scene, load_material(scene.materials, material), at);
  return opacity_number(key, shape_opacity_surface(shape, number)) >= opacity;
}
#endif

// The interval of each ray in a shape's box, by the rule of ray.h.
typedef struct {
  vf begin, end;
} ShapeInterval;

EK_FN ShapeInterval shape_interval(const RayLanes* ray, v3 lo, v3 hi) {
  const vi falls_x = ray->rcp_d.x < 0.0f, falls_y = ray->rcp_d.y < 0.0f, falls_z = ray->rcp_d.z < 0.0f;
  const vf begin_x = ((falls_x ? hi.x : lo.x) - ray->o_near.x) * ray->rcp_d.x, end_x = ((falls_x ? lo.x : hi.x) - ray->o_far.x) * ray->rcp_d.x;
  const vf begin_y = ((falls_y ? hi.y : lo.y) - ray->o_near.y) * ray->rcp_d.y, end_y = ((falls_y ? lo.y : hi.y) - ray->o_far.y) * ray->rcp_d.y;
  const vf begin_z = ((falls_z ? hi.z : lo.z) - ray->o_near.z) * ray->rcp_d.z, end_z = ((falls_z ? lo.z : hi.z) - ray->o_far.z) * ray->rcp_d.z;
  const ShapeInterval within = {max_f(max_f(begin_x, begin_y), max_f(begin_z, (vf)(0.0f))), min_f(min_f(end_x, end_y), end_z)};
  return within;
}

// The same interval, to the bit, from the numbers of the triangle test. lo, hi: in the axes of that
// test. It sets o_near.x and o_far.x of `ray`, from which shape_hit_within takes how far the two
// are apart.
EK_FN ShapeInterval shape_interval_permuted(RayLanes* ray, v3 lo, v3 hi) {
  const vf farthest = max_f(max_f(abs_f(ray->p_o.x), abs_f(ray->p_o.y)), abs_f(ray->p_o.z));
  const vf pad = ray_pad(ray->extent, farthest);
  const vf along = ray->p_rcp_d.z < 0.0f ? -pad : pad;
  ray->o_near.x = ray->p_o.z + along;
  ray->o_far.x = ray->p_o.z - along;
  const vi falls_x = ray->p_rcp_d.x < 0.0f, falls_y = ray->p_rcp_d.y < 0.0f, falls_z = ray->p_rcp_d.z < 0.0f;
  const vf begin_x = ((falls_x ? hi.x : lo.x) - ray->p_near_x) * ray->p_rcp_d.x, end_x = ((falls_x ? lo.x : hi.x) - ray->p_far_x) * ray->p_rcp_d.x;
  const vf begin_y = ((falls_y ? hi.y : lo.y) - ray->p_near_y) * ray->p_rcp_d.y, end_y = ((falls_y ? lo.y : hi.y) - ray->p_far_y) * ray->p_rcp_d.y;
  const vf begin_z = ((falls_z ? hi.z : lo.z) - ray->o_near.x) * ray->p_rcp_d.z, end_z = ((falls_z ? lo.z : hi.z) - ray->o_far.x) * ray->p_rcp_d.z;
  const ShapeInterval within = {max_f(max_f(begin_x, begin_y), max_f(begin_z, (vf)(0.0f))), min_f(min_f(end_x, end_y), end_z)};
  return within;
}

/// The first place where each ray meets its shape and does not pass it. Reads p_o, sx, sy,
/// p_rcp_d.z, axis and key of the ray, and o_near.x and o_far.x for implicit surfaces. live: lanes
/// that count, all of whose intervals within the shape's box are not empty; id: the shape's record
/// in scene.triangles; until: hits behind that t are of no use
// In the shape's space, by the depth on the ray's longest axis: the direction (sx, sy, 1) is what
// triangles are tested with.
EK_FN ShapeHit shape_hit_within(SceneData scene, const RayLanes* ray, vi live, vu id, vu shape, ShapeLanes s, ShapeInterval within,
                                vf until) {
  const vi z_is_x = ray->axis == 0.0f, z_is_y = ray->axis == 1.0f;
  const vf sign = copysign_f((vf)(1.0f), ray->p_rcp_d.z);
  const v3 origin = unpermute3(V3(ray->p_o.x, ray->p_o.y, ray->p_o.z), z_is_x, z_is_y);
  const v3 dir = unpermute3(V3(ray->sx * sign, ray->sy * sign, sign), z_is_x, z_is_y);
  const v3 o = shape_vector(s, sub3(origin, s.center)), d = shape_vector(s, dir);

  ShapeHit found;
  found.hit = (vi)(0);
  found.t = found.part = (vf)(0.0f);
  vi open = live;
  found.gave_up = EK_INFINITY;
  vi culls = (vi)(0);  // the lanes whose ray passes backs (traverse/hit.h)
  if (EK_HAS_culling & (EK_CULLED(scene) != 0u))
    culls = live & ((load_word_u(Triangle, scene.triangles, id, flags) & (vu)(EK_CULLED(scene))) != 0u);
  vf after = (vf)(0.0f);
  for (uint number = 0;; ++number) {
    ShapeRoot root = shape_root(s, o, d, after);
#if EK_HAS_implicit
    const vi is_implicit = open & (s.kind == (uint)SHAPE_implicit);
    if (ANY(is_implicit)) {
      // The root is searched by depth. What t is clamped by lies within the pads, and counts twice.
      const vf until_z = div_f(until, abs_f(ray->p_rcp_d.z)) * (1.0f + 0x1p-10f) + abs_f(ray->o_near.x - ray->o_far.x);
      const ImplicitSearch search = {.shape = shape, .lanes = is_implicit, .culls = culls, .o = o, .d = d, .until = until_z};
      root = implicit_shape_root(scene, s, &search, root, &found.gave_up);
    }
#endif
    const vi met = open & root.hit;
    vi passed = (vi)(0);
#if EK_HAS_opacity
    passed = met & ((load_word_u(Triangle, scene.triangles, id, flags) & EK_TRIANGLE_ALPHA_TESTED) != 0u);
    if (ANY(passed)) {
      const ShapePoint point = shape_point(s, add3(o, scale3(d, root.z)), root.part, V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f)));
      passed = passed & shape_alpha_test_rejects(scene, id, shape, point, number, ray->key);
    }
#endif
    if (EK_HAS_culling) passed = passed | (met & culls & !root.front);
    const vi stops = met & !passed;
    found.hit = found.hit | stops;
    found.t = stops ? root.z : found.t;
    found.part = stops ? root.part : found.part;
    open = passed;
    after = root.z;
    if (!(EK_HAS_opacity | EK_HAS_culling) || !ANY(open)) break;
  }
  const vf t = found.t * abs_f(ray->p_rcp_d.z);
  // 0 instead of -0: the order of the axes decides which of them an interval ends in.
  found.t = min_f(max_f(t, within.begin), within.end) + 0.0f;
  found.gave_up = found.gave_up * abs_f(ray->p_rcp_d.z);
  return found;
}

/// As shape_hit_within, of rays of which it is not known whether they meet the box from lo to hi.
/// It also reads rcp_d, o_near and o_far of the ray.
EK_FN ShapeHit shape_hit(SceneData scene, const RayLanes* ray, vi live, vu id, vu shape, v3 lo, v3 hi, vf until) {
  const ShapeInterval within = shape_interval(ray, lo, hi);
  return shape_hit_within(scene, ray, live & (within.begin <= within.end), id, shape, load_shape(scene.shapes, shape), within,
                          until);
}

/// The same of one shape for all rays; of those that end before its box it is not asked.
/// t: where each ray ends
EK_FN ShapeHit shape_hit_one(SceneData scene, const RayLanes* ray, vi live, vf t, uint id, v3 lo, v3 hi) {
  const ShapeInterval within = shape_interval(ray, lo, hi);
  const vi meets = live & (within.begin <= min_f(within.end, t));
  ShapeHit none;
  none.hit = (vi)(0);
  none.t = none.part = (vf)(0.0f);
  none.gave_up = EK_INFINITY;
  if (!ANY(meets)) return none;
  const uint shape = as_uint(((global const float*)(scene.triangles + id))[12]);
  global const float* p = (global const float*)(scene.shapes + shape);
  const ShapeLanes s = {V3((vf)(p[0]), (vf)(p[1]), (vf)(p[2])), V3((vf)(p[3]), (vf)(p[4]), (vf)(p[5])),
                        V3((vf)(p[6]), (vf)(p[7]), (vf)(p[8])), V3((vf)(p[9]), (vf)(p[10]), (vf)(p[11])),
                        (vf)(p[12]), (vf)(p[13]), (vf)(p[14]), (vu)(as_uint(p[15]))};
  return shape_hit_within(scene, ray, meets, (vu)(id), (vu)(shape), s, within, t);
}

#endif
