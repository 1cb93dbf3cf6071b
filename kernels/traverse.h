// SPDX-License-Identifier: Apache-2.0
// Rays against the scene, in lanes. EK_LAYOUT_bvh8, EK_LAYOUT_bvh2, EK_LAYOUT_none: which tree this program was built for
// (one of them 1); EK_STACK_SIZE: entries that its deepest path can leave waiting. All give the same bits (ray.h).
#ifndef EK_TRAVERSE_H
#define EK_TRAVERSE_H
#include "traverse_bvh2.h"
#include "traverse_bvh8.h"
#include "traverse_none.h"

typedef struct {
  vf t, u, v;   // t in lengths of the direction, +inf where nothing was hit; weights of corners b and c
  vu triangle;  // EK_NO_HIT where nothing was hit
} HitLanes;

EK_FN int traverse_one(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  if (EK_LAYOUT_bvh8) return traverse_bvh8(geometry, ray, any_hit, hit);
  if (EK_LAYOUT_bvh2) return traverse_bvh2(geometry, ray, any_hit, hit);
  return traverse_none(geometry, ray, any_hit, hit);
}

// The closest hit with t > 0 of each ray in the first `count` lanes; the other lanes' results mean nothing. coherent: the rays
// are neighbours, as camera rays are, and tracing them together may pay; it does not change the hits.
EK_FN HitLanes closest_hit(constant Frame* frame, Geometry geometry, v3 origin, v3 dir, uint count, int coherent) {
  RayTable rays;
  ray_store(&rays, ray_lanes(frame, origin, dir));
  float t[EK_WIDTH] __attribute__((aligned(4 * EK_WIDTH))), u[EK_WIDTH] __attribute__((aligned(4 * EK_WIDTH))),
      v[EK_WIDTH] __attribute__((aligned(4 * EK_WIDTH)));
  uint triangle[EK_WIDTH] __attribute__((aligned(4 * EK_WIDTH)));
  for (uint lane = 0; lane < count; ++lane) {
    const RayOne ray = ray_pick(&rays, lane);
    Hit hit = no_hit(INFINITY);
    traverse_one(geometry, &ray, 0, &hit);
    t[lane] = hit.t;
    u[lane] = hit.u;
    v[lane] = hit.v;
    triangle[lane] = hit.triangle;
  }
  HitLanes hits = {*(vf*)t, *(vf*)u, *(vf*)v, *(vu*)triangle};
  return hits;
}

// Whether anything lies in 0 < t < t_max on each ray in the first `count` lanes.
EK_FN vi occluded(constant Frame* frame, Geometry geometry, v3 origin, v3 dir, vf t_max, uint count, int coherent) {
  RayTable rays;
  ray_store(&rays, ray_lanes(frame, origin, dir));
  float end[EK_WIDTH] __attribute__((aligned(4 * EK_WIDTH)));
  uint found[EK_WIDTH] __attribute__((aligned(4 * EK_WIDTH)));
  *(vf*)end = t_max;
  *(vu*)found = (vu)(0u);
  for (uint lane = 0; lane < count; ++lane) {
    const RayOne ray = ray_pick(&rays, lane);
    Hit hit = no_hit(end[lane]);
    found[lane] = (uint)traverse_one(geometry, &ray, 1, &hit);
  }
  return *(vu*)found != (vu)(0u);
}

#endif
