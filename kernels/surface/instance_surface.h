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
  vi is_instanced;  // mask: the hit is on such a mesh
  InstanceTransform to_world;
  vf facing;
  vu node;
} HitInstance;

/// The instance of a hit. number: Hit's `instance` (traverse/hit.h), counted from 1; 0 for others
EK_FN HitInstance hit_instance(SceneData scene, vu number) {
  HitInstance instance;
  instance.is_instanced = AS_I(number) > 0;
  const vu i = instance.is_instanced ? number - 1u : (vu)(0u);
  const InstanceInverseLanes rest = load_instance_inverse(scene.instances, i);
  instance.to_world = instance_transform(load_instance_matrix(scene.instances, i));
  instance.facing = rest.facing;
  instance.node = rest.node;
  return instance;
}

EK_FN TriangleLanes instance_triangle(HitInstance instance, TriangleLanes t) {
  t.p0 = select3(instance.is_instanced, instance_point(instance.to_world, t.p0), t.p0);
  t.p1 = select3(instance.is_instanced, instance_point(instance.to_world, t.p1), t.p1);
  t.p2 = select3(instance.is_instanced, instance_point(instance.to_world, t.p2), t.p2);
  t.n = select3(instance.is_instanced, accurate_triangle_normal(t.p0, t.p1, t.p2), t.n);
  t.node = instance.is_instanced ? instance.node : t.node;
  return t;
}

/// The attributes with normal and tangent in the world: those of the corners are transformed, then
/// interpolated.
EK_FN HitAttributes instance_attributes(SceneData scene, HitInstance instance, vu triangle, vf u, vf v, HitAttributes at) {
  if (EK_HAS_vertex_normal) {
    const TriangleNormalsLanes r = load_triangle_normals(scene.triangle_normals, triangle);
    const v3 mean = interpolate3(instance_normal(instance.to_world, instance.facing, r.n0),
                                 instance_normal(instance.to_world, instance.facing, r.n1),
                                 instance_normal(instance.to_world, instance.facing, r.n2), u, v);
    at.normal = select3(instance.is_instanced, mean, at.normal);
  }
  if (EK_HAS_tangent) {
    const TriangleTangentsLanes r = load_triangle_tangents(scene.triangle_tangents, triangle);
    const v3 mean = interpolate3(unit_or_zero(instance_direction(instance.to_world, r.t0)),
                                 unit_or_zero(instance_direction(instance.to_world, r.t1)),
                                 unit_or_zero(instance_direction(instance.to_world, r.t2)), u, v);
    at.tangent = select3(instance.is_instanced, mean, at.tangent);
  }
  return at;
}
#endif

#endif
