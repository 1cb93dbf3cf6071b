// SPDX-License-Identifier: Apache-2.0
// The words that all kinds of shapes use: the interval that a line is inside, and a point of the
// surface.
#ifndef EK_SHAPE_SPAN_H
#define EK_SHAPE_SPAN_H
#include "lanes/math.h"
#include "surface/scene_data.h"

EK_FN v3 shape_vector(ShapeLanes s, v3 world) { return V3(dot3(s.x, world), dot3(s.y, world), dot3(s.z, world)); }

// The part of the line o + z d that is inside a shape: `in` < z < `out`, wherever the ray begins.
// in_part, out_part: the part of the surface at each end, a small whole number
typedef struct {
  vi hit;
  vf in, out;
  vf in_part, out_part;
} ShapeSpan;

// A point of a shape's surface.
typedef struct {
  v3 p;          // on the surface, to some roundings
  v3 out;        // outwards, of any length
  // Along the surface, where u grows and v stays; zero at a pole. From outside, v grows clockwise
  // of it by a quarter turn.
  v3 right;
  vf u, v;       // texture coordinates
  vf clearance;  // how far p may be off the surface, along `out` in own space, besides roundings
} ShapePoint;

EK_FN ShapeSpan select_span(vi m, ShapeSpan a, ShapeSpan b) {
  ShapeSpan s = {m ? a.hit : b.hit, m ? a.in : b.in, m ? a.out : b.out, m ? a.in_part : b.in_part, m ? a.out_part : b.out_part};
  return s;
}
EK_FN ShapePoint select_point(vi m, ShapePoint a, ShapePoint b) {
  ShapePoint s = {select3(m, a.p, b.p), select3(m, a.out, b.out), select3(m, a.right, b.right), m ? a.u : b.u, m ? a.v : b.v,
                  m ? a.clearance : b.clearance};
  return s;
}

// `right` of a shape whose u goes around the Y axis.
EK_FN v3 east_of(v3 p) { return V3(p.z, (vf)(0.0f), -p.x); }

// x clamped to [-most, most], less a margin.
EK_FN vf shape_clamp_to(vf most, vf x, vf slack) {
  const vf limit = max_f(most - slack, (vf)(0.0f));
  return max_f(min_f(x, limit), -limit);
}
EK_FN vf shape_clamp(vf x, vf slack) { return shape_clamp_to((vf)(1.0f), x, slack); }

// The point where a ray o + z d, in the shape's own space, meets its surface.
// front: mask: it is the front that the ray meets
typedef struct {
  vi hit;
  vf z, part;
  vi front;
} ShapeRoot;

#endif
