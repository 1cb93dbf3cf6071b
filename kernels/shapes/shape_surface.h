// SPDX-License-Identifier: Apache-2.0
// The point where a ray meets a shape, moved onto the surface, with its error bound and the normal.
#ifndef EK_SHAPE_SURFACE_H
#define EK_SHAPE_SURFACE_H
#include "surface/attributes.h"
#include "shapes/shape.h"
#include "surface/surface.h"

// The errors of a point and of rays that leave it, and some roundings more, along the axes of own
// space. own: bounds of its coordinates there
EK_FN v3 shape_slack(ShapeLanes s, ShapeWorldLanes world, v3 own) {
  const v3 reach = V3(0x1p-18f * dot3(abs3(world.x), own) + 0x1p-21f * abs_f(s.center.x),
                      0x1p-18f * dot3(abs3(world.y), own) + 0x1p-21f * abs_f(s.center.y),
                      0x1p-18f * dot3(abs3(world.z), own) + 0x1p-21f * abs_f(s.center.z));
  return V3(dot3(abs3(s.x), reach), dot3(abs3(s.y), reach), dot3(abs3(s.z), reach));
}

/// A point of a shape in the world.
// The bound of the error. In own space the point is on the surface but for some roundings, and it
// goes through two products of a matrix and its inverse before a ray that starts there is tested.
// Let L be the matrix, W its inverse, g the gradient and u = 2^-24. The height that the test
// computes is off by at most 16 u |g| |L| |W| |p| (a count by kind gave factors from 9 to 15), and
// a metre along the normal is a height of |L^T g|. The last sum in world space rounds by u |p|.
EK_FN Surface shape_world_surface(ShapeLanes s, ShapeWorldLanes world, ShapePoint point) {
  const v3 from_center = V3(dot3(world.x, point.p), dot3(world.y, point.p), dot3(world.z, point.p));
  const v3 own = abs3(point.p), out = abs3(point.out);
  const v3 size = V3(dot3(abs3(world.x), own), dot3(abs3(world.y), own), dot3(abs3(world.z), own));
  const vf height = (out.x * dot3(abs3(s.x), size) + out.y * dot3(abs3(s.y), size)) + out.z * dot3(abs3(s.z), size);
  const v3 normal = add3(add3(scale3(s.x, point.out.x), scale3(s.y, point.out.y)), scale3(s.z, point.out.z));
  const vf per_metre = sqrt_f(dot3(normal, normal));
  const v3 n = scale3(normal, div_f((vf)(1.0f), per_metre));
  const v3 p = add3(s.center, from_center);
  const v3 p_error = add3(scale3(abs3(p), (vf)(0x1p-24f)), scale3(abs3(n), 0x1p-20f * div_f(height, per_metre)));
  const int may_be_off = EK_HAS_implicit | EK_HAS_cylinder;  // of the kinds that set a clearance
  const Surface surface = {p, may_be_off ? add3(p_error, scale3(abs3(n), div_f(point.clearance, per_metre))) : p_error, n};
  return surface;
}

/// Corrects `surface`, computed as of a triangle, in the lanes that met a shape; returns the point
/// in own space, for shape_attributes.
/// corners  the record that was met; part: the hit's u; origin, dir, t: of the ray
EK_FN ShapePoint shape_surface(SceneData scene, TriangleLanes corners, vf part, v3 origin, v3 dir, vf t, Surface* surface) {
  const vi is_shape = is_shape_record(corners);
  const vu index = is_shape ? AS_U(corners.n.x) : (vu)(0u);
  const ShapeLanes s = load_shape(scene.shapes, index);
  const ShapeWorldLanes world = load_shape_world(scene.shapes, index);
  v3 near = shape_vector(s, add3(sub3(origin, s.center), scale3(dir, t)));
  // From a million radii away the error of t may be as large as the shape; then the point of the
  // side that is seen is taken.
  const v3 seen = shape_vector(s, neg3(dir));
  near = select3(max_component(abs3(near)) > 0x1p-20f, near, scale3(seen, div_f((vf)(1.0f), max_component(abs3(seen)))));
  const v3 slack = shape_slack(s, world, V3((vf)(1.0f), (vf)(1.0f), (vf)(1.0f)));
#if EK_HAS_implicit
  ShapePoint point = shape_point(s, near, part, slack);
  const vi is_implicit = is_shape & (s.kind == (uint)SHAPE_implicit);
  if (ANY(is_implicit)) point = implicit_shape_point(s, world, is_implicit, origin, dir, part, point);
#else
  const ShapePoint point = shape_point(s, near, part, slack);
#endif
  const Surface of_shape = shape_world_surface(s, world, point);
  surface->p = select3(is_shape, of_shape.p, surface->p);
  surface->p_error = select3(is_shape, of_shape.p_error, surface->p_error);
  surface->n_geom = select3(is_shape, of_shape.n_geom, surface->n_geom);
  return point;
}

/// Does the same for attributes: a shape has texture coordinates of its own, for either set, and a
/// tangent along them.
/// n_geom  of shape_surface()
// In own space `right`, upwards in the texture and `out` are right-handed. A node that mirrors
// reverses `out`, but not directions along the surface.
EK_FN HitAttributes shape_attributes(SceneData scene, TriangleLanes corners, ShapePoint point, v3 n_geom, HitAttributes at) {
  const vi is_shape = is_shape_record(corners);
  if (EK_HAS_tangent) {
    const ShapeWorldLanes world = load_shape_world(scene.shapes, is_shape ? AS_U(corners.n.x) : (vu)(0u));
    const v3 up = cross3(point.out, point.right), right = point.right;
    const v3 along = V3(dot3(world.x, right), dot3(world.y, right), dot3(world.z, right));
    const v3 upward = V3(dot3(world.x, up), dot3(world.y, up), dot3(world.z, up));
    const vf length2 = dot3(along, along);
    const v3 tangent = scale3(along, length2 > 0.0f ? div_f((vf)(1.0f), sqrt_f(length2)) : (vf)(0.0f));
    at.tangent = select3(is_shape, tangent, at.tangent);
    at.bitangent_sign = is_shape ? (dot3(cross3(n_geom, tangent), upward) < 0.0f ? (vf)(-1.0f) : (vf)(1.0f)) : at.bitangent_sign;
  }
  at.uv0_u = is_shape ? point.u : at.uv0_u;
  at.uv0_v = is_shape ? point.v : at.uv0_v;
  at.uv1_u = is_shape ? point.u : at.uv1_u;
  at.uv1_v = is_shape ? point.v : at.uv1_v;
  return at;
}

#endif
