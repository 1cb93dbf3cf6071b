// SPDX-License-Identifier: Apache-2.0
// Shape kind `box`: from -1 to 1 on each axis. The part of a face is twice the axis that it lies
// across, plus 1 for the face at +1.
#ifndef EK_SHAPE_BOX_H
#define EK_SHAPE_BOX_H
#include "shapes/span.h"

// The interval between two planes at -1 and 1. A direction along them counts as one that meets them
// very far away, on the side of its sign.
EK_FN void slab_span(vf o, vf d, vf least, vf* in, vf* out) {
  const vf r = div_f(1.0f, abs_f(d) < least ? copysign_f(least, d) : d);
  const vf low = (-1.0f - o) * r, high = (1.0f - o) * r;
  *in = r < 0.0f ? high : low;
  *out = r < 0.0f ? low : high;
}
EK_FN vf slab_least(v3 d) { return max_component(abs3(d)) * 0x1p-60f; }

EK_FN ShapeSpan box_span(ShapeLanes s, v3 o, v3 d) {
  const vf least = slab_least(d);
  v3 in, out;
  slab_span(o.x, d.x, least, &in.x, &out.x);
  slab_span(o.y, d.y, least, &in.y, &out.y);
  slab_span(o.z, d.z, least, &in.z, &out.z);
  const vf minus_x = copysign_f((vf)(0.5f), d.x), minus_y = copysign_f((vf)(0.5f), d.y), minus_z = copysign_f((vf)(0.5f), d.z);
  ShapeSpan span;
  span.in = max_component(in);
  span.out = min_f(min_f(out.x, out.y), out.z);
  span.hit = span.in <= span.out;
  span.in_part = span.in == in.x ? 0.5f - minus_x : span.in == in.y ? 2.5f - minus_y : 4.5f - minus_z;
  span.out_part = span.out == out.x ? 0.5f + minus_x : span.out == out.y ? 2.5f + minus_y : 4.5f + minus_z;
  return span;
}

// Each face shows the whole of a texture: upright on the sides; with +X to the right on the top,
// seen from above, and on the bottom, seen from below.
EK_FN ShapePoint box_point(ShapeLanes s, v3 near, vf part, v3 slack) {
  const vf zero = (vf)(0.0f), one = (vf)(1.0f);
  const vi across_x = part < 2.0f, across_z = part > 3.0f, across_y = !(across_x | across_z);
  const vf side = ((part == 1.0f) | (part == 3.0f) | (part == 5.0f)) ? one : -one;
  ShapePoint point;
  const v3 inside = V3(shape_clamp(near.x, slack.x), shape_clamp(near.y, slack.y), shape_clamp(near.z, slack.z));
  point.p = V3(across_x ? side : inside.x, across_y ? side : inside.y, across_z ? side : inside.z);
  point.out = V3(across_x ? side : zero, across_y ? side : zero, across_z ? side : zero);
  point.clearance = zero;
  point.right = V3(across_x ? zero : across_y ? one : side, zero, across_x ? -side : zero);
  const vf right = across_x ? -side * point.p.z : across_y ? point.p.x : side * point.p.x;
  const vf down = across_y ? side * point.p.z : -point.p.y;
  point.u = 0.5f + 0.5f * right;
  point.v = 0.5f + 0.5f * down;
  return point;
}

#endif
