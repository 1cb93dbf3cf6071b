// SPDX-License-Identifier: Apache-2.0
// What traversals take and give, for one ray.
#ifndef EK_HIT_H
#define EK_HIT_H
#include "traverse/ray.h"
#include "lanes/simd.h"
#include "traverse/traverse_instance.h"

#define EK_SHAPE 1
#include "traverse/triangle.h"
#define EK_SHAPE 0
#include "traverse/triangle.h"
#if defined(EK_TRIANGLE_TEST)
#include "shapes/classical.h"
#endif
#if EK_HAS_shape
#include "shapes/shape_hit.h"
#endif

// A tree, or the list of triangles that stands for it, laid out as its traverse_<layout>.h says; and the scene, of which all but
// the triangles are there for opacity alone.
typedef struct {
  global const uint* nodes;
  global const uint* leaves;
  SceneData scene;
} Geometry;

// The same as arguments of a kernel.
#if EK_HAS_opacity
#define EK_GEOMETRY_ARGUMENTS global const uint *accel_nodes, global const uint *accel_leaves, EK_SCENE_ARGUMENTS
#define EK_GEOMETRY {accel_nodes, accel_leaves, EK_SCENE_DATA}
#else
#define EK_GEOMETRY_ARGUMENTS \
  global const uint *accel_nodes, global const uint *accel_leaves, global const Triangle *triangles EK_SHAPE_ARGUMENTS
#define EK_GEOMETRY {accel_nodes, accel_leaves, {triangles, 0, 0, 0, 0, 0, 0, 0, 0 EK_SHAPE_DATA}}
#endif

// Closest hit so far; t is the segment's end while nothing was hit, and stays that for an any-hit query.
typedef struct {
  float t, u, v;
  uint triangle;
#if EK_HAS_instance
  uint instance;  // 0: the triangle is stored in the world; else 1 + its place, and the record is in its mesh's space
#endif
#if EK_HAS_implicit
  float gave_up;  // first t at which the search for a surface was given up; infinite: nowhere
  uint gave_up_surface;  // its number
#endif
#if defined(EK_COUNT) && EK_COUNT
  uint tests, steps;
#endif
} Hit;

// In a program that counts (EK_COUNT 1: `bench rays`), tests of triangles and steps through a structure; nothing in others.
#if defined(EK_COUNT) && EK_COUNT
#define EK_COUNT_TEST(hit) (++(hit)->tests)
#define EK_COUNT_STEP(hit) (++(hit)->steps)
#else
#define EK_COUNT_TEST(hit)
#define EK_COUNT_STEP(hit)
#endif

typedef struct {
  float t[EK_ROWS] EK_ROWS_ALIGNED, u[EK_ROWS] EK_ROWS_ALIGNED, v[EK_ROWS] EK_ROWS_ALIGNED;
  uint triangle[EK_ROWS] EK_ROWS_ALIGNED;
#if EK_HAS_instance
  uint instance[EK_ROWS] EK_ROWS_ALIGNED;
#endif
#if EK_HAS_implicit
  float gave_up[EK_ROWS] EK_ROWS_ALIGNED;
  uint gave_up_surface[EK_ROWS] EK_ROWS_ALIGNED;
#endif
} HitTable;

EK_FN Hit no_hit(float t_max) {
  Hit hit;
  hit.t = t_max;
  hit.u = hit.v = 0.0f;
  hit.triangle = EK_NO_HIT;
#if EK_HAS_instance
  hit.instance = EK_NO_HIT;
#endif
#if EK_HAS_implicit
  hit.gave_up = INFINITY;
  hit.gave_up_surface = EK_NO_HIT;
#endif
#if defined(EK_COUNT) && EK_COUNT
  hit.tests = hit.steps = 0u;
#endif
  return hit;
}

// The smallest t wins; among equals the smallest index, so that the order of traversal does not show. instance: as Hit's
EK_FN int is_closer(const Hit* hit, float t, uint triangle, uint instance) {
#if EK_HAS_instance
  return (t < hit->t) | ((t == hit->t) & is_before(instance, triangle, hit->instance, hit->triangle));
#else
  return (t < hit->t) | ((t == hit->t) & (triangle < hit->triangle));
#endif
}

// Whether one ray passes a triangle that it would hit.
EK_FN int passes_one(Geometry geometry, const RayOne* ray, uint triangle, float u, float v) {
  if (!EK_HAS_opacity || !is_alpha_tested(geometry.scene, triangle)) return 0;
  return ANY(alpha_test_rejects(geometry.scene, (vu)(triangle), (vf)(u), (vf)(v), ray_key(ray)));
}

#if EK_HAS_implicit
// Keeps the nearest place at which a ray's search was given up.
EK_FN void keep_given_up(float t, uint surface, float* nearest, uint* its_surface) {
  const int nearer = (t < *nearest) | ((t == *nearest) & (surface < *its_surface));
  *nearest = nearer ? t : *nearest;
  *its_surface = nearer ? surface : *its_surface;
}

// Counts a ray that ends at t, unless it was given up behind that. Every traversal searches the surfaces whose boxes begin at or before the
// end of a ray that reaches its end, and no search hangs on what others found nearer: so which rays count hangs on rays alone, not
// on the order of traversal, nor on how much of a surface behind the hit was searched for nothing.
EK_FN void report_given_up(Geometry geometry, float gave_up, uint surface, float t) {
  if (!(gave_up < INFINITY) || !(gave_up <= t)) return;
  atomic_add(&geometry.scene.diagnostics->given_up, 1u);
  atomic_or(&geometry.scene.diagnostics->given_up_surfaces, 1u << min(surface, 31u));
}
#endif

// Whether a triangle is one of the ray's ends.
EK_FN int is_end(const RayOne* ray, uint triangle, const int any_hit) {
#if !EK_HAS_instance
  if (any_hit && triangle == ray->goal) return 1;
#endif
  return triangle == ray->left;
}

#if EK_HAS_shape
// As try_triangle, of the record of a shape.
EK_FN int try_shape(Geometry geometry, const RayOne* ray, uint id, const int any_hit, Hit* hit) {
  global const float* p = (global const float*)(geometry.scene.triangles + id);
  RayLanes lanes;
  lanes.rx = (vf)(ray->rx); lanes.ry = (vf)(ray->ry); lanes.rz = (vf)(ray->rz);
  lanes.nx = (vf)(ray->nx); lanes.ny = (vf)(ray->ny); lanes.nz = (vf)(ray->nz);
  lanes.fx = (vf)(ray->fx); lanes.fy = (vf)(ray->fy); lanes.fz = (vf)(ray->fz);
  lanes.p_ox = (vf)(ray->p_ox); lanes.p_oy = (vf)(ray->p_oy); lanes.p_oz = (vf)(ray->p_oz);
  lanes.sx = (vf)(ray->sx); lanes.sy = (vf)(ray->sy); lanes.p_rz = (vf)(ray->p_rz);
  lanes.axis = (vf)((float)(ray->axis_z / 8u));
  lanes.key = ray_key(ray);
  const ShapeHit found = shape_hit(geometry.scene, &lanes, LANE_INDEX == (vu)(0u), (vu)(id), (vu)(as_uint(p[12])), V3((vf)(p[0]), (vf)(p[1]), (vf)(p[2])),
                                   V3((vf)(p[3]), (vf)(p[4]), (vf)(p[5])), (vf)(hit->t));
#if EK_HAS_implicit
  keep_given_up(((const float*)&found.gave_up)[0], as_uint(p[12]), &hit->gave_up, &hit->gave_up_surface);
#endif
  const float t = ((const float*)&found.t)[0];
  if (!ANY(found.hit)) return 0;
  if (any_hit) return t < hit->t;
  if (is_closer(hit, t, id, EK_NO_HIT)) {  // shapes are behind all triangles
#if EK_HAS_instance
    hit->instance = INSTANCE_SHAPE;
#endif
    hit->t = t;
    hit->u = ((const float*)&found.part)[0];
    hit->v = 0.0f;
    hit->triangle = id;
  }
  return 0;
}
#endif

// Tests one triangle of the record array. returns 1 if that settles an any-hit query.
EK_FN int try_triangle(Geometry geometry, const RayOne* ray, uint triangle, const int any_hit, Hit* hit) {
  EK_COUNT_TEST(hit);
  global const float* p = (global const float*)(geometry.scene.triangles + triangle);
#if EK_HAS_shape
  if (p[6] != p[6]) return try_shape(geometry, ray, triangle, any_hit, hit);
#endif
  if (is_end(ray, triangle, any_hit)) return 0;
  const uint z = ray->axis_z / 8u, x = ray->axis_x / 8u, y = 3u - z - x;
  Corners_one corners;
  corners.ax = p[x]; corners.ay = p[y]; corners.az = p[z];
  corners.bx = p[3 + x]; corners.by = p[3 + y]; corners.bz = p[3 + z];
  corners.cx = p[6 + x]; corners.cy = p[6 + y]; corners.cz = p[6 + z];
#if EK_HAS_instance
  const uint instance = ray->instance;
  if (instance != 0u) {
#define PLACED_CORNER(axis, at) placed_corner(geometry.scene.instances, instance, axis, p[at], p[at + 1], p[at + 2])
    corners.ax = PLACED_CORNER(x, 0); corners.ay = PLACED_CORNER(y, 0); corners.az = PLACED_CORNER(z, 0);
    corners.bx = PLACED_CORNER(x, 3); corners.by = PLACED_CORNER(y, 3); corners.bz = PLACED_CORNER(z, 3);
    corners.cx = PLACED_CORNER(x, 6); corners.cy = PLACED_CORNER(y, 6); corners.cz = PLACED_CORNER(z, 6);
#undef PLACED_CORNER
  }
#else
  const uint instance = 0u;
#endif
#if defined(EK_TRIANGLE_TEST)
  const TriangleHit_one found = triangle_hit_classical(ray, corners);
#else
  const TriangleHit_one found = triangle_hit_one(ray, corners);
#endif
  if (any_hit) return (found.hit & (found.t < hit->t)) && !passes_one(geometry, ray, triangle, found.u, found.v);
  if ((found.hit & is_closer(hit, found.t, triangle, instance)) && !passes_one(geometry, ray, triangle, found.u, found.v)) {
    hit->t = found.t;
    hit->u = found.u;
    hit->v = found.v;
    hit->triangle = triangle;
#if EK_HAS_instance
    hit->instance = instance;
#endif
  }
  return 0;
}

#endif
