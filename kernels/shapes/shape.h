// SPDX-License-Identifier: Apache-2.0
// Shapes: surfaces that are not triangles. Each kind is a file shape_<name>.h in the shape's own space, where it has a standard
// size, with
//   <name>_span   where a ray goes in and out
//   <name>_point  a point near the surface moved onto it, but not within `slack` of an edge, where its error could put it
//                 beyond the surface that begins there; which way is out there, and where a texture is looked up
// and a line in each of the two functions below. A kind that is no convex solid gives its roots to shape_root itself.
#ifndef EK_SHAPE_H
#define EK_SHAPE_H
#include "lanes/math.h"
#include "surface/scene_data.h"

// Kinds of shapes: ShapeRecord.kind.
enum {
#define EK_SHAPE_KIND(name, bit) SHAPE_##name = bit,
#include "shared/features.def"
};

EK_FN v3 shape_vector(ShapeLanes s, v3 world) { return V3(dot3(s.x, world), dot3(s.y, world), dot3(s.z, world)); }

// The line o + z d is inside for `in` < z < `out`, wherever it begins. part: of the surface, a small whole number.
typedef struct {
  vi hit;
  vf in, out;
  vf in_part, out_part;
} ShapeSpan;

// The surface near a point. p: on it, to some roundings; out: any length; u, v: texture coordinates; right: along the surface, where u
// grows and v stays, zero at a pole; seen from outside v grows a quarter of a turn clockwise from there. clearance: how far p may be
// off the surface, along `out` in own space, beside roundings.
typedef struct {
  v3 p, out, right;
  vf u, v, clearance;
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

// `right` where u goes round the Y axis.
EK_FN v3 east_of(v3 p) { return V3(p.z, (vf)(0.0f), -p.x); }

// x within -most and most, by a margin.
EK_FN vf shape_clamp_to(vf most, vf x, vf slack) {
  const vf limit = max_f(most - slack, (vf)(0.0f));
  return max_f(min_f(x, limit), -limit);
}
EK_FN vf shape_clamp(vf x, vf slack) { return shape_clamp_to((vf)(1.0f), x, slack); }

#include "shapes/sphere.h"
#include "shapes/box.h"
#include "shapes/plane.h"
#include "shapes/cylinder.h"
#include "shapes/capsule.h"

// Where the ray o + z d, in the shape's own space, first meets it with z > after.
typedef struct {
  vi hit;
  vf z, part;
} ShapeRoot;

EK_FN ShapeRoot shape_root(ShapeLanes s, v3 o, v3 d, vf after) {
  const vf zero = (vf)(0.0f);
  ShapeSpan span = {(vi)(0), zero, zero, zero, zero};
#define EK_SPAN(name)                                                          \
  if (EK_HAS_##name) {                                                         \
    const vi is_kind = s.kind == (uint)SHAPE_##name;                           \
    if (ANY(is_kind)) span = select_span(is_kind, name##_span(s, o, d), span); \
  }
  EK_SPAN(sphere)
  EK_SPAN(box)
  EK_SPAN(plane)
  EK_SPAN(cylinder)
  EK_SPAN(capsule)
#undef EK_SPAN
  const vi enters = span.in > after;
  ShapeRoot root = {span.hit & (enters | (span.out > after)), enters ? span.in : span.out,
                    enters ? span.in_part : span.out_part};
  return root;
}

/// near  own space, some way off the surface
EK_FN ShapePoint shape_point(ShapeLanes s, v3 near, vf part, v3 slack) {
  const vf zero = (vf)(0.0f);
  ShapePoint point = {V3(zero, zero, zero), V3(zero, zero, zero), V3(zero, zero, zero), zero, zero, zero};
#define EK_POINT(name)                                                                 \
  if (EK_HAS_##name) {                                                                 \
    const vi is_kind = s.kind == (uint)SHAPE_##name;                                   \
    if (ANY(is_kind)) point = select_point(is_kind, name##_point(s, near, part, slack), point); \
  }
  EK_POINT(sphere)
  EK_POINT(box)
  EK_POINT(plane)
  EK_POINT(cylinder)
  EK_POINT(capsule)
#undef EK_POINT
  return point;
}

#if EK_HAS_implicit
#include "shapes/implicit.h"
#endif

#endif
