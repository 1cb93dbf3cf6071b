// SPDX-License-Identifier: Apache-2.0
// Shape kind `plane`: the rectangle from -a to a on X and from -b to b on Z at y = 0; +Y is its
// front. a and b are 1, or so large that the plane seems to have no end.
#ifndef EK_SHAPE_PLANE_H
#define EK_SHAPE_PLANE_H
#include "shapes/span.h"

EK_FN ShapeSpan plane_span(ShapeLanes s, v3 o, v3 d) {
  const vf z = div_f(-o.y, d.y);
  ShapeSpan span;
  span.hit = (abs_f(o.x + z * d.x) <= s.a) & (abs_f(o.z + z * d.z) <= s.b);  // not where z is no number
  span.out = z;
  span.in = d.y < 0.0f ? z : -EK_INFINITY;  // from below a ray leaves what is behind the plane
  span.in_part = span.out_part = (vf)(0.0f);
  return span;
}

// From above the whole of a texture is seen, with +X to the right. On a plane without end it
// repeats.
EK_FN ShapePoint plane_point(ShapeLanes s, v3 near, vf part, v3 slack) {
  ShapePoint point;
  point.p = V3(shape_clamp_to(s.a, near.x, slack.x), (vf)(0.0f), shape_clamp_to(s.b, near.z, slack.z));
  point.out = V3((vf)(0.0f), (vf)(1.0f), (vf)(0.0f));
  point.right = V3((vf)(1.0f), (vf)(0.0f), (vf)(0.0f));
  point.clearance = (vf)(0.0f);
  point.u = 0.5f + 0.5f * point.p.x;
  point.v = 0.5f + 0.5f * point.p.z;
  return point;
}

#endif
