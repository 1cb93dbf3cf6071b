// SPDX-License-Identifier: Apache-2.0
// Shapes: surfaces that are not triangles. Each kind has a header <name>.h, which works in the
// shape's own space, where it has a standard size, and provides
//   <name>_span   the interval of a line that is inside
//   <name>_point  the point of the surface next to a given point, with the direction outwards and
//                 the texture coordinates there. It keeps a distance of `slack` to edges, because
//                 its error could put it beyond the surface that begins there.
// and has a line in each of the two functions below. A kind that is no convex solid adds its roots
// to shape_root's (implicit.h).
#ifndef EK_SHAPE_H
#define EK_SHAPE_H
#include "shapes/box.h"
#include "shapes/capsule.h"
#include "shapes/cylinder.h"
#include "shapes/plane.h"
#include "shapes/sphere.h"

// Kinds of shapes: ShapeRecord.kind.
enum {
#define EK_SHAPE_KIND(name, bit) SHAPE_##name = bit,
#include "shared/features.def"
};

// The first root of the ray o + z d with z > after.
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
                    enters ? span.in_part : span.out_part, enters};
  return root;
}

/// The point of the surface next to `near`, a point in own space that may be some way off. part:
/// the part that was hit
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
