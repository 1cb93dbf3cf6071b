// SPDX-License-Identifier: Apache-2.0
// Hits on instanced meshes, which are stored once: the triangle and its attributes in the instance
// that was hit.
#ifndef EK_INSTANCE_SURFACE_H
#define EK_INSTANCE_SURFACE_H
#include "surface/attributes.h"
#include "surface/instance_record.h"
#include "surface/surface.h"

#if EK_HAS_instance
typedef struct {
  vi placed;  // the lane's hit is on such a mesh
  Placing to_world;
  vf facing;
  vu node;
} Place;

/// The instance of a hit. instance: as Hit's (traverse/hit.h), counted from 1; 0 for others
EK_FN Place hit_place(SceneData scene, vu instance) {
  Place place;
  place.placed = AS_I(instance) > 0;
  const vu i = place.placed ? instance - 1u : (vu)(0u);
  const InstanceInverseLanes rest = load_instance_inverse(scene.instances, i);
  place.to_world = instance_placing(load_instance_matrix(scene.instances, i));
  place.facing = rest.facing;
  place.node = rest.node;
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

/// The attributes with normal and tangent in the world: those of the corners are transformed, then
/// interpolated.
EK_FN HitAttributes placed_attributes(SceneData scene, Place place, vu triangle, vf u, vf v, HitAttributes at) {
  if (EK_HAS_vertex_normal) {
    const TriangleNormalsLanes r = load_triangle_normals(scene.triangle_normals, triangle);
    const v3 mean = interpolate3(placed_normal(place.to_world, place.facing, r.n0),
                                 placed_normal(place.to_world, place.facing, r.n1),
                                 placed_normal(place.to_world, place.facing, r.n2), u, v);
    at.normal = select3(place.placed, mean, at.normal);
  }
  if (EK_HAS_tangent) {
    const TriangleTangentsLanes r = load_triangle_tangents(scene.triangle_tangents, triangle);
    const v3 mean = interpolate3(unit_or_zero(placed_direction(place.to_world, r.t0)),
                                 unit_or_zero(placed_direction(place.to_world, r.t1)),
                                 unit_or_zero(placed_direction(place.to_world, r.t2)), u, v);
    at.tangent = select3(place.placed, mean, at.tangent);
  }
  return at;
}
#endif

#endif
