// SPDX-License-Identifier: Apache-2.0
// A shape as light sampling sees it.
#ifndef EK_LIGHT_SHAPE_VIEW_H
#define EK_LIGHT_SHAPE_VIEW_H
#include "lanes/warp.h"
#include "shapes/shape.h"

// A shape as seen from a point.
typedef struct {
  ShapeLanes shape;
  v3 from;     // the point, own space
  v3 slack;    // a point nearer to a face than this counts as inside, since rounding may put a
               // point of the shape on either side
  v3 part_m2;  // world areas of the parts
} ShapeView;

typedef struct {
  v3 p;
  vf part;
} ShapeChoice;

// Density per sr of the direction from view.from to p.
// density  of choosing p, per area;  out: the normal at p, of any length
EK_FN vf density_sr_from_area(ShapeView view, v3 p, v3 out, vf density) {
  const v3 d = sub3(p, view.from);
  const vf across = abs_f(dot3(out, d)), distance2 = dot3(d, d);
  const vf per_sr = div_f((density * distance2) * sqrt_f(distance2 * dot3(out, out)), across);
  return across > 0.0f ? per_sr : (vf)(0.0f);
}

// u, which lies in [begin, begin + share), rescaled to [0, 1).
EK_FN vf rest_of(vf u, vf begin, vf share) { return max_f(min_f(div_f(u - begin, share), (vf)(1.0f - 0x1p-24f)), (vf)(0.0f)); }

#endif
