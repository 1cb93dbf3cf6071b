// SPDX-License-Identifier: Apache-2.0
// The arguments and results of traversals, and the test of one ray against one triangle or shape.
#ifndef EK_HIT_H
#define EK_HIT_H
#include "traverse/gpu/ray_memory.h"
#include "lanes/simd.h"
#include "surface/motion.h"
#include "traverse/traverse_instance.h"

#define EK_SHAPE 1
#include "traverse/triangle.h"
#define EK_SHAPE 0
#include "traverse/triangle.h"
#if defined(EK_TRIANGLE_TEST)
#include "traverse/classical_triangle.h"
#endif
#if EK_HAS_shape
#include "traverse/shape_hit.h"
#endif

#define EK_ONE_RAY 1
#include "traverse/closest_hit.h"
#define EK_ONE_RAY 0
#include "traverse/closest_hit.h"

// A tree, laid out as the header of its layout says, and the scene. Without opacity a traversal
// reads of the scene only triangles and, with the features that need them, shapes, instances, poses
// and diagnostics (EK_GEOMETRY_ARGUMENTS).
typedef struct {
  global const uint* nodes;
  global const uint* leaves;
  SceneData scene;
#if EK_RAY_IN_LOCAL_MEMORY
  RayMemory ray_memory;  // of this work-item
#endif
#if EK_HAS_moving_surface
  int over_time;  // the tree is that of the triangles that move (motion_tree.h)
#endif
} Geometry;

#if EK_HAS_moving_surface
#define EK_OVER_TIME(geometry) ((geometry).over_time)
#define EK_NOT_OVER_TIME , 0
#else
#define EK_OVER_TIME(geometry) 0
#define EK_NOT_OVER_TIME
#endif

// The same as arguments of a kernel.
#if EK_HAS_opacity
#define EK_GEOMETRY_ARGUMENTS global const uint *accel_nodes, global const uint *accel_leaves, EK_SCENE_ARGUMENTS
#define EK_GEOMETRY {accel_nodes, accel_leaves, EK_SCENE_DATA EK_OWN_RAY_MEMORY EK_NOT_OVER_TIME}
#else
#define EK_GEOMETRY_ARGUMENTS \
  global const uint *accel_nodes, global const uint *accel_leaves, global const Triangle *triangles EK_SHAPE_ARGUMENTS
#define EK_GEOMETRY {accel_nodes, accel_leaves, {.triangles = triangles EK_SHAPE_DATA} EK_OWN_RAY_MEMORY EK_NOT_OVER_TIME}
#endif

// The hits of EK_ROWS rays. A field that the program does not need has room for one vector.
#define EK_ROWS_IF(feature) ((feature) ? EK_ROWS : EK_WIDTH)
typedef struct {
  float t[EK_ROWS] EK_ROWS_ALIGNED, u[EK_ROWS] EK_ROWS_ALIGNED, v[EK_ROWS] EK_ROWS_ALIGNED;
  uint triangle[EK_ROWS] EK_ROWS_ALIGNED;
  uint instance[EK_ROWS_IF(EK_HAS_instance)] EK_ROWS_ALIGNED;
  float gave_up[EK_ROWS_IF(EK_HAS_implicit)] EK_ROWS_ALIGNED;
  uint gave_up_surface[EK_ROWS_IF(EK_HAS_implicit)] EK_ROWS_ALIGNED;
} HitTable;

// The hit of a row, as far as is_closer() needs it. t: where the row's ray ends so far
EK_FN Hit table_hit(const HitTable* hits, uint row, float t) {
  Hit hit = no_hit(t);
  hit.triangle = hits->triangle[row];
  if (EK_HAS_instance) hit.instance = hits->instance[row];
  return hit;
}

// Culling [glTF 2.0, section 3.9.5]: camera rays, which are rays of depth 1, pass the backs of
// single-sided surfaces as if these were not there; no other ray does. It is part of the search
// for the closest hit so that nothing behind it knows of it: the film's layers, depths and random
// numbers are those of a scene without the culled face, and a face that coincides with its turned
// copy shows the side that is the front. A candidate's flags are loaded only where its back is hit.

EK_FN void cull_backs(Geometry* geometry, int camera_rays) {
#if EK_HAS_culling
  geometry->scene.culled = camera_rays ? EK_TRIANGLE_SINGLE_SIDED : 0u;
#endif
}

// The lanes of `back` whose triangle has flags that are culled.
EK_FN vi culls_lanes(Geometry geometry, vi back, vu flags) {
  return back & ((flags & (vu)(EK_CULLED(geometry.scene))) != 0u);
}

// 1 if one ray passes a triangle that it would hit: by culling or by the alpha test.
EK_FN int passes_one(Geometry geometry, const RayOne* ray, uint triangle, TriangleHit_one found, const int any_hit) {
  if (EK_CULLS(any_hit)) {
    const uint culled = found.back ? EK_CULLED(geometry.scene) : 0u;
    if (culled != 0u && (geometry.scene.triangles[triangle].flags & culled) != 0u) return 1;
  }
  if (!EK_HAS_opacity || !is_alpha_tested(geometry.scene, triangle)) return 0;
  return ANY(alpha_test_rejects(geometry.scene, (vu)(triangle), (vf)(found.u), (vf)(found.v), ray_key(ray)));
}

// 1 where a ray's end is known once it has been through the tree of what stands still.
#define EK_REPORTS_AT_ONCE (EK_HAS_implicit & !EK_HAS_moving_surface)

// Counts a ray that ends at t and whose search was given up at or before t. Every traversal
// searches all surfaces whose boxes begin at or before the final end of the ray, and no search
// depends on what others found nearer. So the count depends on the rays alone: not on the order of
// traversal, nor on how much of a surface behind the hit was searched in vain.
EK_FN void report_given_up(Geometry geometry, float gave_up, uint surface, float t) {
  if (!(gave_up < INFINITY) || !(gave_up <= t)) return;
  atomic_add(&geometry.scene.diagnostics->given_up, 1u);
  atomic_or(&geometry.scene.diagnostics->given_up_surfaces, 1u << min(surface, 31u));
}

EK_FN RayBoxes ray_boxes(Geometry geometry, const RayOne* ray) {
#if EK_RAY_IN_LOCAL_MEMORY
  return ray_memory_boxes(geometry.ray_memory);
#else
  const RayBoxes boxes = {ray->rcp_d, ray->o_near, ray->o_far};
  return boxes;
#endif
}

// The ray with its words for triangles.
EK_FN RayOne ray_for_triangle(Geometry geometry, const RayOne* ray) {
#if EK_RAY_IN_LOCAL_MEMORY
  RayOne test = ray_memory_test(geometry.ray_memory);
#if EK_HAS_opacity
  test.key = ray->key;
  test.index = ray->index;
#endif
#if EK_HAS_moving_surface
  test.step = ray->step;
  test.share = ray->share;
#endif
  return test;
#else
  return *ray;
#endif
}

// 1 if the ray is known not to meet the triangle (RayEnds).
EK_FN int is_end(const RayOne* ray, uint triangle, const int any_hit) {
  const int is_target = triangle == ray_target(ray);
  return (triangle == ray->origin_prim) | (any_hit & !EK_HAS_instance & is_target);
}

#if EK_HAS_shape
// The same as try_triangle, for the record of a shape.
EK_FN int try_shape(Geometry geometry, const RayOne* given, uint id, const int any_hit, Hit* hit) {
  global const float* p = (global const float*)(geometry.scene.triangles + id);
  const RayBoxes boxes = ray_boxes(geometry, given);
  const RayOne test = ray_for_triangle(geometry, given), *ray = &test;
  RayLanes lanes;
  lanes.rcp_d.x = (vf)(boxes.rcp_d.x); lanes.rcp_d.y = (vf)(boxes.rcp_d.y); lanes.rcp_d.z = (vf)(boxes.rcp_d.z);
  lanes.o_near.x = (vf)(boxes.o_near.x); lanes.o_near.y = (vf)(boxes.o_near.y); lanes.o_near.z = (vf)(boxes.o_near.z);
  lanes.o_far.x = (vf)(boxes.o_far.x); lanes.o_far.y = (vf)(boxes.o_far.y); lanes.o_far.z = (vf)(boxes.o_far.z);
  lanes.p_o.x = (vf)(ray->p_o.x); lanes.p_o.y = (vf)(ray->p_o.y); lanes.p_o.z = (vf)(ray->p_o.z);
  lanes.sx = (vf)(ray->sx); lanes.sy = (vf)(ray->sy); lanes.p_rcp_d.z = (vf)(ray->p_rcp_d.z);
  lanes.axis = (vf)((float)(ray->axis_z / 8u));
  lanes.key = ray_key(ray);
  const ShapeHit found = shape_hit(geometry.scene, &lanes, LANE_INDEX == (vu)(0u), (vu)(id), (vu)(as_uint(p[12])), V3((vf)(p[0]), (vf)(p[1]), (vf)(p[2])),
                                   V3((vf)(p[3]), (vf)(p[4]), (vf)(p[5])), (vf)(hit->t));
  if (EK_HAS_implicit)
    keep_given_up(((const float*)&found.gave_up)[0], as_uint(p[12]), &hit->gave_up, &hit->gave_up_surface);
  const float t = ((const float*)&found.t)[0];
  if (!ANY(found.hit)) return 0;
  if (any_hit) return t < hit->t;
  if (is_closer(hit, t, id, INSTANCE_SHAPE)) {
    hit->instance = INSTANCE_SHAPE;
    hit->t = t;
    hit->u = ((const float*)&found.part)[0];
    hit->v = 0.0f;
    hit->triangle = id;
  }
  return 0;
}
#endif

// Tests one triangle of the record array; returns 1 if that settles an any-hit query.
EK_FN int try_triangle(Geometry geometry, const RayOne* given, uint triangle, const int any_hit, Hit* hit) {
  EK_COUNT_TEST(hit);
  global const float* p = (global const float*)(geometry.scene.triangles + triangle);
#if EK_HAS_shape
  // NaN marks a shape (records.def).
  if (p[6] != p[6]) return try_shape(geometry, given, triangle, any_hit, hit);
#endif
  const RayOne test = ray_for_triangle(geometry, given), *ray = &test;
  if (is_end(ray, triangle, any_hit)) return 0;
  const uint z = ray->axis_z / 8u, x = ray->axis_x / 8u, y = 3u - z - x;
  Corners_one corners;
  corners.ax = p[x]; corners.ay = p[y]; corners.az = p[z];
  corners.bx = p[3 + x]; corners.by = p[3 + y]; corners.bz = p[3 + z];
  corners.cx = p[6 + x]; corners.cy = p[6 + y]; corners.cz = p[6 + z];
  const uint instance = ray_instance(ray);
  if (EK_HAS_instance && instance != 0u) {
#define INSTANCE_CORNER(axis, at) instance_corner(geometry.scene.instances, instance, axis, p[at], p[at + 1], p[at + 2])
    corners.ax = INSTANCE_CORNER(x, 0); corners.ay = INSTANCE_CORNER(y, 0); corners.az = INSTANCE_CORNER(z, 0);
    corners.bx = INSTANCE_CORNER(x, 3); corners.by = INSTANCE_CORNER(y, 3); corners.bz = INSTANCE_CORNER(z, 3);
    corners.cx = INSTANCE_CORNER(x, 6); corners.cy = INSTANCE_CORNER(y, 6); corners.cz = INSTANCE_CORNER(z, 6);
#undef INSTANCE_CORNER
  }
#if EK_HAS_moving_surface
  const uint pose = EK_OVER_TIME(geometry) | EK_LAYOUT_none ? geometry.scene.motion[geometry.scene.motion[1] + triangle] : 0u;
  if (pose != 0u) {
    global const float* before = (global const float*)(geometry.scene.pose_triangles + (pose - 1u + ray->step));
    global const float* after = before + sizeof(Triangle) / 4;
#define MOVED_CORNER(at) moved_one(before[at], after[at], ray->share)
    corners.ax = MOVED_CORNER(x); corners.ay = MOVED_CORNER(y); corners.az = MOVED_CORNER(z);
    corners.bx = MOVED_CORNER(3u + x); corners.by = MOVED_CORNER(3u + y); corners.bz = MOVED_CORNER(3u + z);
    corners.cx = MOVED_CORNER(6u + x); corners.cy = MOVED_CORNER(6u + y); corners.cz = MOVED_CORNER(6u + z);
#undef MOVED_CORNER
  }
#endif
#if defined(EK_TRIANGLE_TEST)
  const TriangleHit_one found = triangle_hit_classical(ray, corners);
#else
  const TriangleHit_one found = triangle_hit_one(ray, corners);
#endif
  if (any_hit) return (found.hit & (found.t < hit->t)) && !passes_one(geometry, ray, triangle, found, 1);
  if ((found.hit & is_closer(hit, found.t, triangle, instance)) && !passes_one(geometry, ray, triangle, found, 0)) {
    hit->t = found.t;
    hit->u = found.u;
    hit->v = found.v;
    hit->triangle = triangle;
    hit->instance = instance;
  }
  return 0;
}

#endif
