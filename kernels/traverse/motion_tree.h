// SPDX-License-Identifier: Apache-2.0
// The tree of the triangles that move (EK_HAS_moving_surface), which rays go through after that of
// the others. Which comes first changes no hit (closest_hit.h). Words of `motion_nodes`:
//   0-5   box around all these triangles at any time: lo x y z, hi x y z
//   6     1 if there is something that stands still
//   16-   nodes, as an index of which 0 is the root: of layout bvh8 or bvh16 over time
//         (wide/wide.h) if the other tree has that layout, else of bvh2 (gpu/bvh2.h)
// With --accel none there is no such tree: all triangles are in one list.
#ifndef EK_TRAVERSE_MOTION_TREE_H
#define EK_TRAVERSE_MOTION_TREE_H
#include "traverse/gpu/bvh2.h"
#include "traverse/wide/wide.h"

#if EK_HAS_moving_surface
/// The geometry without what moves, and what moves alone.
EK_FN Geometry still_geometry(Geometry geometry) {
  geometry.over_time = 0;
  return geometry;
}
EK_FN Geometry moving_geometry(Geometry geometry) {
  geometry.nodes = geometry.scene.motion_nodes + EK_MOTION_HEAD_WORDS;
  geometry.leaves = geometry.scene.motion_leaves;
  geometry.over_time = 1;
  return geometry;
}

/// 1 if the tree of what stands still has anything in it.
EK_FN int some_stands_still(Geometry geometry) { return EK_LAYOUT_none || geometry.scene.motion_nodes[6] != 0u; }

/// Returns where rays enter the box around all that moves, by the interval rule (ray.h). *end: is
/// set to where they leave it
EK_FN vf moving_interval(Geometry geometry, RayLanes ray, vf* end) {
  global const float* box = (global const float*)geometry.scene.motion_nodes;
  const vi falls_x = ray.rcp_d.x < 0.0f, falls_y = ray.rcp_d.y < 0.0f, falls_z = ray.rcp_d.z < 0.0f;
  const vf lo_x = (vf)(box[0]), lo_y = (vf)(box[1]), lo_z = (vf)(box[2]), hi_x = (vf)(box[3]), hi_y = (vf)(box[4]), hi_z = (vf)(box[5]);
  const vf near_x = ((falls_x ? hi_x : lo_x) - ray.o_near.x) * ray.rcp_d.x, far_x = ((falls_x ? lo_x : hi_x) - ray.o_far.x) * ray.rcp_d.x;
  const vf near_y = ((falls_y ? hi_y : lo_y) - ray.o_near.y) * ray.rcp_d.y, far_y = ((falls_y ? lo_y : hi_y) - ray.o_far.y) * ray.rcp_d.y;
  const vf near_z = ((falls_z ? hi_z : lo_z) - ray.o_near.z) * ray.rcp_d.z, far_z = ((falls_z ? lo_z : hi_z) - ray.o_far.z) * ray.rcp_d.z;
  *end = shape_min_lanes(shape_min_lanes(far_x, far_y), far_z);
  return shape_max_lanes(shape_max_lanes(shape_max_lanes(near_x, near_y), near_z), (vf)(0.0f));
}

/// Tests one ray against the triangles that move; returns 1 if an any-hit query found something.
EK_FN int traverse_moving(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  if (EK_LAYOUT_none) return 0;
  const Geometry moving = moving_geometry(geometry);
  if (EK_LAYOUT_bvh16 | EK_LAYOUT_bvh8) return traverse_wide(moving, ray, any_hit, hit);
  return traverse_bvh2(moving, ray, any_hit, hit);
}
#endif

#endif
