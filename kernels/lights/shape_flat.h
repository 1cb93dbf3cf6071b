// SPDX-License-Identifier: Apache-2.0
// Sampling of boxes and bounded planes by area: of a box the visible faces, or all from inside.
#ifndef EK_LIGHT_SHAPE_FLAT_H
#define EK_LIGHT_SHAPE_FLAT_H
#include "lights/shape_view.h"

// Visible areas of the faces at -1 and at +1 on each axis, up to a common factor. L is the matrix
// that takes the world to the shape's space (rows x, y, z of ShapeRecord): whatever it is, the
// faces across x have an area in proportion to the length of its row x.
typedef struct {
  v3 low, high;
  vf all;
} BoxFaces;

EK_FN BoxFaces box_faces(ShapeView view) {
  const ShapeLanes s = view.shape;
  const v3 area = V3(sqrt_f(dot3(s.x, s.x)), sqrt_f(dot3(s.y, s.y)), sqrt_f(dot3(s.z, s.z)));
  const v3 p = view.from, most = add3(V3((vf)(1.0f), (vf)(1.0f), (vf)(1.0f)), view.slack);
  const vi inside = (abs_f(p.x) <= most.x) & (abs_f(p.y) <= most.y) & (abs_f(p.z) <= most.z);
  const vf zero = (vf)(0.0f);
  BoxFaces faces;
  faces.low = V3((inside | (p.x < -most.x)) ? area.x : zero, (inside | (p.y < -most.y)) ? area.y : zero,
                 (inside | (p.z < -most.z)) ? area.z : zero);
  faces.high = V3((inside | (p.x > most.x)) ? area.x : zero, (inside | (p.y > most.y)) ? area.y : zero,
                  (inside | (p.z > most.z)) ? area.z : zero);
  faces.all = ((faces.low.x + faces.high.x) + (faces.low.y + faces.high.y)) + (faces.low.z + faces.high.z);
  return faces;
}

EK_FN ShapeChoice box_choose(ShapeView view, vf u, vf v) {
  const BoxFaces faces = box_faces(view);
  const vf share[6] = {faces.low.x, faces.high.x, faces.low.y, faces.high.y, faces.low.z, faces.high.z};
  const vf at = u * faces.all;
  vf begin = (vf)(0.0f), part = begin, first = begin, mine = begin;
  vi found = (vi)(0);
  for (uint i = 0; i < 6; ++i) {  // the last face with a share also takes what rounding leaves
    const vi here = (share[i] > 0.0f) & !found;
    part = here ? (vf)((float)i) : part;
    first = here ? begin : first;
    mine = here ? share[i] : mine;
    begin = begin + share[i];
    found = found | (here & (at < begin));
  }
  const vf a = 2.0f * rest_of(at, first, mine) - 1.0f, b = 2.0f * v - 1.0f;
  const vi across_x = part < 2.0f, across_z = part > 3.0f, across_y = !(across_x | across_z);
  const vf side = ((part == 1.0f) | (part == 3.0f) | (part == 5.0f)) ? (vf)(1.0f) : (vf)(-1.0f);
  const ShapeChoice choice = {V3(across_x ? side : a, across_y ? side : across_x ? a : b, across_z ? side : b), part};
  return choice;
}

EK_FN vf box_density(ShapeView view, ShapePoint at, vf part) {
  const BoxFaces faces = box_faces(view);
  const vi high = (part == 1.0f) | (part == 3.0f) | (part == 5.0f);
  const v3 share = select3(high, faces.high, faces.low);
  const vf mine = part < 2.0f ? share.x : part > 3.0f ? share.z : share.y;
  return density_sr_from_area(view, at.p, at.out, div_f(0.25f * mine, faces.all));
}

EK_FN ShapeChoice plane_choose(ShapeView view, vf u, vf v) {
  const ShapeChoice choice = {V3(2.0f * u - 1.0f, (vf)(0.0f), 2.0f * v - 1.0f), (vf)(0.0f)};
  return choice;
}

EK_FN vf plane_density(ShapeView view, ShapePoint at, vf part) {
  return density_sr_from_area(view, at.p, at.out, (vf)(0.25f));
}

#endif
