// SPDX-License-Identifier: Apache-2.0
// Shape kind `cylinder`: about the Y axis from y = -1 to 1, of radius a + b y, the larger of which
// is 1; a cone where one is 0. Part 0 is the side, 1 the disc at y = -1, 2 that at +1.
#ifndef EK_SHAPE_CYLINDER_H
#define EK_SHAPE_CYLINDER_H
#include "shapes/box.h"

// The interval of the line within a radius a + b y, >= 0, of the Y axis.
EK_FN void cone_span(v3 o, v3 d, vf a, vf b, vi* hit, vf* in, vf* out) {
  const vf size = dot3(d, d), radius = a + b * o.y, infinite = EK_INFINITY;
  // From afar the quadratic loses its digits, so it is solved from the point of the line next to
  // the origin.
  const vf shift = dot3(o, o) > 4.0f ? div_f(-dot3(o, d), size) : (vf)(0.0f);
  const v3 from = add3(o, scale3(d, shift));
  const vf from_radius = shift == 0.0f ? radius : a + b * from.y;
  const vf grows = b * d.y;
  vf quadratic = (d.x * d.x + d.z * d.z) - grows * grows;
  const vf least = size * 0x1p-60f;
  quadratic = abs_f(quadratic) < least ? least : quadratic;
  const vf b_half = -((from.x * d.x + from.z * d.z) - grows * from_radius);
  const vf rest = (from.x * from.x + from.z * from.z) - from_radius * from_radius;
  const vf discriminant = b_half * b_half - quadratic * rest;
  const vf root = sqrt_f(max_f(discriminant, (vf)(0.0f)));
  const vf q = b_half < 0.0f ? b_half - root : b_half + root;
  const vf z0 = div_f(rest, q), z1 = div_f(q, quadratic);
  const vf first = shift + min_f(z0, z1), last = shift + max_f(z0, z1);
  // A line steeper than the cone is within it up to one root, or from the other on; the rest is in
  // the cone's mirror image.
  const vi steep = quadratic < 0.0f;
  *hit = steep | (discriminant > 0.0f);
  *in = steep ? (grows > 0.0f ? last : -infinite) : first;
  *out = steep ? (grows > 0.0f ? infinite : first) : last;
}

// The same between y = low and high.
EK_FN void frustum_span(v3 o, v3 d, vf a, vf b, vf low, vf high, ShapeSpan* span) {
  vf in, out;
  cone_span(o, d, a, b, &span->hit, &in, &out);
  const vf least = slab_least(d);
  const vf r = div_f(1.0f, abs_f(d.y) < least ? copysign_f(least, d.y) : d.y);
  const vf at_low = (low - o.y) * r, at_high = (high - o.y) * r;
  const vi falls = r < 0.0f;
  const vf enter = falls ? at_high : at_low, leave = falls ? at_low : at_high;
  span->in = max_f(in, enter);
  span->out = min_f(out, leave);
  span->hit = span->hit & (span->in <= span->out);
  span->in_part = enter > in ? (falls ? (vf)(2.0f) : (vf)(1.0f)) : (vf)(0.0f);
  span->out_part = leave < out ? (falls ? (vf)(1.0f) : (vf)(2.0f)) : (vf)(0.0f);
}

EK_FN ShapeSpan cylinder_span(ShapeLanes s, v3 o, v3 d) {
  ShapeSpan span;
  frustum_span(o, d, s.a, s.b, (vf)(-1.0f), (vf)(1.0f), &span);
  return span;
}

// The point of the side at `y`, in the direction of `near` from the Y axis.
EK_FN ShapePoint cone_point(v3 near, vf a, vf b, vf y) {
  const vf distance = sqrt_f(near.x * near.x + near.z * near.z), radius = max_f(a + b * y, (vf)(0.0f));
  const vi off_axis = distance > 0.0f;
  const vf x = off_axis ? div_f(near.x, distance) : (vf)(1.0f), z = off_axis ? div_f(near.z, distance) : (vf)(0.0f);
  ShapePoint point;
  point.p = V3(radius * x, y, radius * z);
  point.out = V3(x, -b, z);
  point.right = east_of(point.out);
  point.u = EK_HAS_uv ? 0.5f + atan2_turns(x, z) : (vf)(0.0f);
  point.v = point.clearance = (vf)(0.0f);
  return point;
}

// The side shows a texture as a sphere does. The discs show it in the square around them, with +X
// to the right.
EK_FN ShapePoint cylinder_point(ShapeLanes s, v3 near, vf part, v3 slack) {
  const vf zero = (vf)(0.0f), one = (vf)(1.0f);
  // A point keeps off a tip as off an edge, up to where the radius is `slack`, so that it stays on
  // the side.
  const vf tip = div_f(min_f(slack.x + slack.z, one) - s.a, s.b);  // of no use where s.b is 0
  const vf off_tip = s.b > 0.0f ? max_f(near.y, tip) : s.b < 0.0f ? min_f(near.y, tip) : near.y;
  ShapePoint side = cone_point(near, s.a, s.b, shape_clamp(off_tip, slack.y));
  side.v = 0.5f - 0.5f * side.p.y;
  // A disc that is narrower than `slack` is replaced by the section inwards that is wide enough, as
  // far as there is one. Rays that enter begin inside of that section, and rays that leave begin
  // beyond the disc.
  const vf y = part == 2.0f ? one : -one;
  const vf distance = sqrt_f(near.x * near.x + near.z * near.z), round = slack.x + slack.z;
  const vi narrow = (s.a + s.b * y < round) & (s.b * y < 0.0f);
  const vf section = narrow ? max_f(min_f(tip, one), -one) : y;
  // Where the cone narrows inwards, a point must still be inside after it goes in by slack.y.
  const vf widest = max_f((s.a + s.b * section) - (round + max_f(s.b * y, zero) * slack.y), zero);
  const vf shrink = distance > widest ? div_f(widest, distance) : one;
  ShapePoint disc;
  disc.p = V3(near.x * shrink, section, near.z * shrink);
  disc.clearance = abs_f(y - section);
  disc.out = V3(zero, y, zero);
  disc.right = V3(one, zero, zero);
  disc.u = 0.5f + 0.5f * disc.p.x;
  disc.v = 0.5f + 0.5f * (y * disc.p.z);
  return select_point(part == 0.0f, side, disc);
}

#endif
