// SPDX-License-Identifier: Apache-2.0
// Where a ray meets a shape: the point, moved onto the surface, how far off it may be, and the normal.
#ifndef EK_SHAPE_SURFACE_H
#define EK_SHAPE_SURFACE_H
#include "attributes.h"
#include "shape.h"
#include "surface.h"

/// Puts what is of a triangle in `surface` right for the lanes that met a shape; returns the point in own space, for shape_attributes.
/// corners  the record that was met; part: the hit's u; origin, dir, t: of the ray
// The bound of the error. In own space the point is on the surface but for some roundings, and goes through two products of a
// matrix and its inverse until a ray that starts there is tested: with L the matrix, W its inverse and g the gradient, what
// the test makes of its height is off by at most 16 u |g| |L| |W| |p|, u = 2^-24 (of the factors 9 to 15 were counted, by kind), and
// a metre along the normal is a height of |L^T g|. The last sum in world space rounds by u |p|.
EK_FN ShapePoint shape_surface(SceneData scene, TriangleLanes corners, vf part, v3 origin, v3 dir, vf t, Surface* surface) {
  const vi is_shape = corners.p2.x != corners.p2.x;
  const vu index = is_shape ? AS_U(corners.n.x) : (vu)(0u);
  const ShapeLanes s = load_shape(scene.shapes, index);
  const Rec w = rec16(scene.shapes, 2u * index + 1u);
  v3 near = shape_vector(s, add3(sub3(origin, s.center), scale3(dir, t)));
  // From a million radii away t may be no better than the shape is large: then the side that is seen will do.
  const v3 seen = shape_vector(s, neg3(dir));
  near = select3(max_component(abs3(near)) > 0x1p-20f, near, scale3(seen, (vf)(1.0f) / max_component(abs3(seen))));
  const v3 row_x = V3(w.w0, w.w1, w.w2), row_y = V3(w.w3, w.w4, w.w5), row_z = V3(w.w6, w.w7, w.w8);
  // What errors of the point and of rays that leave it, some roundings more, are along the axes of own space.
  const v3 ones = V3((vf)(1.0f), (vf)(1.0f), (vf)(1.0f));
  const v3 reach = V3(0x1p-18f * dot3(abs3(row_x), ones) + 0x1p-21f * abs_f(s.center.x),
                      0x1p-18f * dot3(abs3(row_y), ones) + 0x1p-21f * abs_f(s.center.y),
                      0x1p-18f * dot3(abs3(row_z), ones) + 0x1p-21f * abs_f(s.center.z));
  const v3 slack = V3(dot3(abs3(s.x), reach), dot3(abs3(s.y), reach), dot3(abs3(s.z), reach));
#if EK_HAS_implicit
  ShapePoint point = shape_point(s, near, part, slack);
  const vi is_implicit = is_shape & (s.kind == (uint)SHAPE_implicit);
  vf clearance = (vf)(0.0f);
  if (ANY(is_implicit)) point = implicit_shape_point(s, w, is_implicit, origin, dir, part, point, &clearance);
#else
  const ShapePoint point = shape_point(s, near, part, slack);
#endif
  const v3 from_center = V3(dot3(row_x, point.p), dot3(row_y, point.p), dot3(row_z, point.p));
  const v3 own = abs3(point.p), out = abs3(point.out);
  const v3 size = V3(dot3(abs3(row_x), own), dot3(abs3(row_y), own), dot3(abs3(row_z), own));
  const vf height = (out.x * dot3(abs3(s.x), size) + out.y * dot3(abs3(s.y), size)) + out.z * dot3(abs3(s.z), size);
  const v3 normal = add3(add3(scale3(s.x, point.out.x), scale3(s.y, point.out.y)), scale3(s.z, point.out.z));
  const vf per_metre = sqrt(dot3(normal, normal));
  const v3 n = scale3(normal, (vf)(1.0f) / per_metre);
  const v3 p = add3(s.center, from_center);
  const v3 p_error = add3(scale3(abs3(p), (vf)(0x1p-24f)), scale3(abs3(n), 0x1p-20f * (height / per_metre)));
#if EK_HAS_implicit
  const v3 error = add3(p_error, scale3(abs3(n), clearance / per_metre));
#else
  const v3 error = p_error;
#endif
  surface->p = select3(is_shape, p, surface->p);
  surface->p_error = select3(is_shape, error, surface->p_error);
  surface->n_geom = select3(is_shape, n, surface->n_geom);
  return point;
}

/// The same for what a triangle's corners say: a shape has texture coordinates of its own, for either set, and no more.
EK_FN HitAttributes shape_attributes(TriangleLanes corners, ShapePoint point, HitAttributes at) {
  const vi is_shape = corners.p2.x != corners.p2.x;
  at.uv0_u = is_shape ? point.u : at.uv0_u;
  at.uv0_v = is_shape ? point.v : at.uv0_v;
  at.uv1_u = is_shape ? point.u : at.uv1_u;
  at.uv1_v = is_shape ? point.v : at.uv1_v;
  return at;
}

#endif
