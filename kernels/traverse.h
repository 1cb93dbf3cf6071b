// SPDX-License-Identifier: Apache-2.0
// Rays against the scene, in lanes. EK_LAYOUT_bvh8, EK_LAYOUT_bvh2, EK_LAYOUT_none: which tree this program was built for
// (one of them 1); EK_STACK_SIZE: entries that its deepest path can leave waiting. All give the same bits (ray.h).
#ifndef EK_TRAVERSE_H
#define EK_TRAVERSE_H
#include "traverse_batch.h"
#include "traverse_bvh2.h"
#include "traverse_bvh8.h"
#include "traverse_none.h"
#include "traverse_packet.h"

#define USE_BATCH (EK_LAYOUT_bvh8 & EK_HAS_BATCH & (EK_WIDTH > 1))

// Lanes that hold a ray whose every number is one; no other can hit anything, nor may it widen the bounds of a packet.
EK_FN vi packet_valid(RayLanes ray, vf t_max, uint count) {
  return (LANE_INDEX < (vu)(count)) & (t_max > 0.0f) & (ray.p_ox == ray.p_ox) & (ray.p_oy == ray.p_oy) &
         (ray.p_oz == ray.p_oz) & (ray.sx == ray.sx) & (ray.sy == ray.sy);
}

// Whether a packet is likely to pay. Rays that start together and were meant for the same light may yet go anywhere: those of
// a packet must agree on their longest axis, its sign, and on the slopes to it within a quarter.
EK_FN int use_packet(Geometry geometry, RayLanes ray, vi valid, int coherent) {
  if ((EK_LAYOUT_bvh8 == 0) | (EK_WIDTH == 1)) return 0;
  if (bvh8_is_small(geometry)) return 1;
  if (!coherent) return 0;
  const vf least = -EK_INFINITY, most = EK_INFINITY;
  const vf axis = ray.axis + (ray.p_rz < 0.0f ? (vf)(4.0f) : (vf)(0.0f));
  return lanes_max(valid ? axis : least) <= lanes_min(valid ? axis : most) &&
         lanes_max(valid ? ray.sx : least) - lanes_min(valid ? ray.sx : most) < 0.25f &&
         lanes_max(valid ? ray.sy : least) - lanes_min(valid ? ray.sy : most) < 0.25f;
}

EK_FN int traverse_one(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  if (EK_LAYOUT_bvh8) return traverse_bvh8(geometry, ray, any_hit, hit);
  if (EK_LAYOUT_bvh2) return traverse_bvh2(geometry, ray, any_hit, hit);
  return traverse_none(geometry, ray, any_hit, hit);
}

// The closest hit with t > 0 of each ray in the first `count` lanes; the other lanes' results mean nothing. coherent: the rays
// are neighbours, as camera rays are, and tracing them together may pay; it does not change the hits.
EK_FN HitLanes closest_hit(constant Frame* frame, Geometry geometry, v3 origin, v3 dir, uint count, int coherent) {
  const RayLanes ray = ray_lanes(frame, origin, dir);
  HitLanes hit = {EK_INFINITY, (vf)(0.0f), (vf)(0.0f), (vu)(EK_NO_HIT)};
  const vi valid = packet_valid(ray, hit.t, count);
  if (use_packet(geometry, ray, valid, coherent)) {
    hit.t = valid ? hit.t : (vf)(-1.0f);
    traverse_packet(geometry, &ray, valid, 0, &hit);
    hit.t = valid ? hit.t : EK_INFINITY;
  } else {
    RayTable rays;
    ray_store(&rays, ray);
    HitTable hits;
    *(vf*)hits.t = hit.t;
    *(vf*)hits.u = hit.u;
    *(vf*)hits.v = hit.v;
    *(vu*)hits.triangle = hit.triangle;
    if (USE_BATCH) {
      traverse_batch(geometry, &rays, count, 0, &hits);
    } else {
      for (uint lane = 0; lane < count; ++lane) {
        const RayOne one = ray_pick(&rays, lane);
        Hit found = no_hit(INFINITY);
        traverse_one(geometry, &one, 0, &found);
        hits.t[lane] = found.t;
        hits.u[lane] = found.u;
        hits.v[lane] = found.v;
        hits.triangle[lane] = found.triangle;
      }
    }
    hit.t = *(vf*)hits.t;
    hit.u = *(vf*)hits.u;
    hit.v = *(vf*)hits.v;
    hit.triangle = *(vu*)hits.triangle;
  }
  return hit;
}

// Whether anything lies in 0 < t < t_max on each ray in the first `count` lanes.
EK_FN vi occluded(constant Frame* frame, Geometry geometry, v3 origin, v3 dir, vf t_max, uint count, int coherent) {
  const RayLanes ray = ray_lanes(frame, origin, dir);
  vi blocked;
  const vi valid = packet_valid(ray, t_max, count);
  if (use_packet(geometry, ray, valid, coherent)) {
    HitLanes hit = {valid ? t_max : (vf)(-1.0f), (vf)(0.0f), (vf)(0.0f), (vu)(EK_NO_HIT)};
    traverse_packet(geometry, &ray, valid, 1, &hit);
    blocked = valid & (hit.t < 0.0f);
  } else {
    RayTable rays;
    ray_store(&rays, ray);
    HitTable hits;
    *(vf*)hits.t = t_max;
    *(vf*)hits.u = (vf)(0.0f);
    *(vf*)hits.v = (vf)(0.0f);
    *(vu*)hits.triangle = (vu)(EK_NO_HIT);
    if (USE_BATCH) {
      traverse_batch(geometry, &rays, count, 1, &hits);
    } else {
      for (uint lane = 0; lane < count; ++lane) {
        const RayOne one = ray_pick(&rays, lane);
        Hit found = no_hit(hits.t[lane]);
        if (traverse_one(geometry, &one, 1, &found)) hits.triangle[lane] = 0;
      }
    }
    blocked = *(vu*)hits.triangle != (vu)(EK_NO_HIT);
  }
  return blocked;
}

#endif
