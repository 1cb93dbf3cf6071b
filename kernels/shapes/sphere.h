// SPDX-License-Identifier: Apache-2.0
// Shape kind `sphere`: radius 1 about the origin.
#ifndef EK_SHAPE_SPHERE_H
#define EK_SHAPE_SPHERE_H
#include "shapes/span.h"

// source [Haines, Gunther, Akenine-Moller 2019, "Precision improvements for ray/sphere
// intersection", Ray Tracing Gems, chapter 7]: from afar the discriminant comes from the point of
// the line next to the centre. Near the sphere it comes from c, whose sign says on which side the
// ray begins; the error bound of points (shape_surface.h) keeps that sign right for rays that leave
// the surface. From inside, one root is positive whatever is rounded, so no ray escapes. From
// outside, a ray that leads away has no positive root.
EK_FN ShapeSpan unit_sphere_span(v3 o, v3 d) {
  const vf a = dot3(d, d), b = -dot3(o, d), c = dot3(o, o) - 1.0f;
  const v3 nearest = add3(o, scale3(d, div_f(b, a)));
  const vf from_afar = a * (1.0f - dot3(nearest, nearest));
  const vf discriminant = c < 1.0f ? b * b - a * c : from_afar;
  const vf root = sqrt_f(max_f(discriminant, (vf)(0.0f)));
  const vf q = b < 0.0f ? b - root : b + root;
  const vf z0 = div_f(c, q), z1 = div_f(q, a);
  ShapeSpan span;
  span.hit = discriminant > 0.0f;
  span.in = min_f(z0, z1);
  span.out = max_f(z0, z1);
  span.in_part = span.out_part = (vf)(0.0f);
  return span;
}
EK_FN ShapeSpan sphere_span(ShapeLanes s, v3 o, v3 d) { return unit_sphere_span(o, d); }

// Seen from outside, u grows to the east, with its middle at +Z; v grows from the pole at +Y to
// that at -Y.
EK_FN ShapePoint sphere_point(ShapeLanes s, v3 near, vf part, v3 slack) {
  ShapePoint point;
  point.p = normalize3(near);
  point.out = point.p;
  point.right = east_of(point.p);
  point.clearance = (vf)(0.0f);
  point.u = point.v = (vf)(0.0f);
  if (EK_HAS_uv) {
    const v3 p = point.p;
    point.u = 0.5f + atan2_turns(p.x, p.z);
    point.v = 2.0f * atan2_turns(sqrt_f(p.x * p.x + p.z * p.z), p.y);
  }
  return point;
}

#endif
