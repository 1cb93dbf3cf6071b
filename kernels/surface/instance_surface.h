// SPDX-License-Identifier: Apache-2.0
// What shading is told of a hit on a mesh that is stored once: its triangle at the place that was hit.
#ifndef EK_INSTANCE_SURFACE_H
#define EK_INSTANCE_SURFACE_H
#include "surface/attributes.h"
#include "traverse/instance.h"
#include "surface/surface.h"

#if EK_HAS_instance
typedef struct {
  vi placed;  // the lane's hit is on such a mesh
  Placing to_world;
  vf facing;
  vu node;
} Place;

/// instance  of the hit (hit.h): the places are counted from 1
EK_FN Place hit_place(SceneData scene, vu instance) {
  Place place;
  place.placed = AS_I(instance) > 0;
  const vu i = place.placed ? instance - 1u : (vu)(0u);
  const Rec m = rec16(scene.instances, 2u * i), rest = rec16(scene.instances, 2u * i + 1u);
  const Placing to_world = {V3(m.w0, m.w1, m.w2), V3(m.w4, m.w5, m.w6), V3(m.w8, m.w9, m.wa), V3(m.w3, m.w7, m.wb)};
  place.to_world = to_world;
  place.facing = rest.wd;
  place.node = AS_U(rest.we);
  return place;
}

EK_FN TriangleLanes placed_triangle(Place place, TriangleLanes t) {
  t.p0 = select3(place.placed, placed_point(place.to_world, t.p0), t.p0);
  t.p1 = select3(place.placed, placed_point(place.to_world, t.p1), t.p1);
  t.p2 = select3(place.placed, placed_point(place.to_world, t.p2), t.p2);
  t.n = select3(place.placed, placed_triangle_normal(t.p0, t.p1, t.p2), t.n);
  t.node = place.placed ? place.node : t.node;
  return t;
}

/// Normal and tangent of hit_attributes() at the place: those of the corners are placed, then interpolated.
EK_FN HitAttributes placed_attributes(SceneData scene, Place place, vu triangle, vf u, vf v, HitAttributes at) {
#define EK_PLACED(placed, r)                                                                    \
  const v3 a = placed(V3(r.w0, r.w1, r.w2)), b = placed(V3(r.w3, r.w4, r.w5)), c = placed(V3(r.w6, r.w7, r.w8)); \
  const v3 mean = V3(interpolate(a.x, b.x, c.x, u, v), interpolate(a.y, b.y, c.y, u, v), interpolate(a.z, b.z, c.z, u, v));
#define EK_PLACED_NORMAL(n) placed_normal(place.to_world, place.facing, n)
#define EK_PLACED_TANGENT(t) unit_or_zero(placed_direction(place.to_world, t))
  if (EK_HAS_vertex_normal) {
    const Rec r = rec16(scene.triangle_normals, triangle);
    EK_PLACED(EK_PLACED_NORMAL, r)
    at.normal = select3(place.placed, mean, at.normal);
  }
  if (EK_HAS_tangent) {
    const Rec r = rec16(scene.triangle_tangents, triangle);
    EK_PLACED(EK_PLACED_TANGENT, r)
    at.tangent = select3(place.placed, mean, at.tangent);
  }
#undef EK_PLACED
#undef EK_PLACED_NORMAL
#undef EK_PLACED_TANGENT
  return at;
}
#endif

#endif
