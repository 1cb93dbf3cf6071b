// SPDX-License-Identifier: Apache-2.0
// Shape kind `capsule`: the convex hull of two spheres on the Y axis, at y = a of radius b and at y
// = -a of radius c, the larger of which is 1. Part 0 is the side, 1 the lower sphere, 2 the upper
// one.
#ifndef EK_SHAPE_CAPSULE_H
#define EK_SHAPE_CAPSULE_H
#include "shapes/cylinder.h"
#include "shapes/sphere.h"

// The side, a cone that touches both spheres. `tilt` is the y of its unit normal; it is beyond -1
// or 1 where one sphere contains the other.
typedef struct {
  vf tilt, flat;     // flat: the length of the normal's rest
  vf a, b;           // radius a + b y
  vf low, high;      // y of the circles where it touches them
  vi there;
} CapsuleSide;

EK_FN CapsuleSide capsule_side(ShapeLanes s) {
  CapsuleSide side;
  side.tilt = div_f(s.c - s.b, 2.0f * s.a);
  side.there = abs_f(side.tilt) < 0.99999f;
  side.tilt = side.there ? side.tilt : (vf)(0.0f);
  side.flat = sqrt_f((1.0f - side.tilt) * (1.0f + side.tilt));
  side.a = div_f(0.5f * (s.b + s.c), side.flat);
  side.b = div_f(-side.tilt, side.flat);
  side.low = s.c * side.tilt - s.a;
  side.high = s.b * side.tilt + s.a;
  return side;
}

// Joins a part to the whole. All three parts are convex, and so is their union: its span reaches
// from the first entry to the last exit.
EK_FN void capsule_join(ShapeSpan* whole, vi hit, vf in, vf out, vf part) {
  const vi first = hit & (!whole->hit | (in < whole->in)), last = hit & (!whole->hit | (out > whole->out));
  whole->in = first ? in : whole->in;
  whole->in_part = first ? part : whole->in_part;
  whole->out = last ? out : whole->out;
  whole->out_part = last ? part : whole->out_part;
  whole->hit = whole->hit | hit;
}

EK_FN void capsule_join_sphere(ShapeSpan* whole, v3 o, v3 d, vf y, vf radius, vf part) {
  const vf r = div_f(1.0f, radius);
  const ShapeSpan ball = unit_sphere_span(scale3(V3(o.x, o.y - y, o.z), r), scale3(d, r));
  capsule_join(whole, ball.hit & (radius > 0.0f), ball.in, ball.out, part);
}

EK_FN ShapeSpan capsule_span(ShapeLanes s, v3 o, v3 d) {
  const CapsuleSide side = capsule_side(s);
  ShapeSpan span;
  frustum_span(o, d, side.a, side.b, side.low, side.high, &span);
  span.hit = span.hit & side.there;
  span.in_part = span.out_part = (vf)(0.0f);  // its discs are inside the spheres
  capsule_join_sphere(&span, o, d, -s.a, s.c, (vf)(1.0f));
  capsule_join_sphere(&span, o, d, s.a, s.b, (vf)(2.0f));
  return span;
}

EK_FN ShapePoint capsule_point(ShapeLanes s, v3 near, vf part, v3 slack) {
  const CapsuleSide side = capsule_side(s);
  const vf y = max_f(min_f(near.y, side.high), side.low);
  const ShapePoint wall = cone_point(near, side.a, side.b, y);
  const vi upper = part == 2.0f;
  const vf center = upper ? s.a : -s.a, radius = upper ? s.b : s.c;
  ShapePoint ball;
  // A point that is rather far off may lie beside the sphere's cap: it is moved to the circle where
  // the cap ends.
  const v3 toward = normalize3(V3(near.x, near.y - center, near.z));
  const vi beside = side.there & (upper ? toward.y < side.tilt : toward.y > side.tilt);
  const vf round = sqrt_f(toward.x * toward.x + toward.z * toward.z);
  const vf shrink = round > 0.0f ? div_f(side.flat, round) : (vf)(0.0f);
  ball.out = select3(beside, V3(toward.x * shrink, side.tilt, toward.z * shrink), toward);
  ball.right = east_of(ball.out);
  ball.clearance = (vf)(0.0f);
  ball.p = scale3(ball.out, radius);
  ball.p.y = ball.p.y + center;
  ball.u = EK_HAS_uv ? 0.5f + atan2_turns(near.x, near.z) : (vf)(0.0f);
  ShapePoint point = select_point(part == 0.0f, wall, ball);
  const vf top = s.a + s.b, bottom = s.a + s.c;
  point.v = div_f(top - point.p.y, top + bottom);
  return point;
}

#endif
