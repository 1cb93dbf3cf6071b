// SPDX-License-Identifier: Apache-2.0
// Tracing of rays through the scene, in lanes. The host defines
//   EK_LAYOUT_<name> (shared/layouts.def), EK_LAYOUT_none  1 for the tree of this program, 0 for
//   the others
//   EK_STACK_SIZE   the most entries that a ray can leave on its stack
//   EK_SMALL_TREE   1 where packets are best for rays of any kind
//   EK_MEDIUM_TREE  1 where the tree is larger than a core's caches
//   EK_LARGE_TREE   1 where it is larger than all caches
// All trees give the same bits (ray.h).
#ifndef EK_TRAVERSE_H
#define EK_TRAVERSE_H
#include "traverse/wide/batch.h"
#include "traverse/gpu/bvh2.h"
#include "traverse/gpu/bvh4.h"
#include "traverse/gpu/cwbvh.h"
#include "traverse/motion_tree.h"
#include "traverse/classic/none.h"
#include "traverse/classic/space.h"
#include "traverse/wide/packet.h"
#include "traverse/wide/sorted.h"
#include "traverse/wide/wide.h"

#define USE_WIDE (EK_LAYOUT_bvh16 | EK_LAYOUT_bvh8)

// The lanes that hold a ray: from a finite origin in some direction. Others can hit nothing and
// must not be traced, because a NaN is within every box, even where a node has no child, and would
// widen the bounds of a packet. The padded origins of a ray are finite, and its reciprocals are
// finite and not 0, so it never meets the planes at infinity of a missing child.
EK_FN vi valid_rays(RayLanes ray, vf t_max, uint count) {
  return (LANE_INDEX < (vu)(count)) & (t_max > 0.0f) & (ray.p_o.x == ray.p_o.x) & (ray.p_o.y == ray.p_o.y) & (ray.p_o.z == ray.p_o.z) &
         (ray.extent < EK_INFINITY) & (ray.sx == ray.sx) & (ray.sy == ray.sy) & (ray.p_rcp_d.z != 0.0f);
}

// 1 if a packet is likely to pay. Even rays that start together and lead to the same light may go
// anywhere, so those of a packet must agree on their longest axis, its sign, and on the slopes to
// it within a quarter.
EK_FN int use_packet(RayLanes ray, vi valid, int coherent) {
  if (!USE_WIDE | (EK_WIDTH == 1)) return 0;
  if (EK_SMALL_TREE) return 1;
  if (!coherent) return 0;
  const vf least = -EK_INFINITY, most = EK_INFINITY;
  const vf axis = ray.axis + (ray.p_rcp_d.z < 0.0f ? (vf)(4.0f) : (vf)(0.0f));
  return lanes_max(valid ? axis : least) <= lanes_min(valid ? axis : most) &&
         lanes_max(valid ? ray.sx : least) - lanes_min(valid ? ray.sx : most) < 0.25f &&
         lanes_max(valid ? ray.sy : least) - lanes_min(valid ? ray.sy : most) < 0.25f;
}

EK_FN int traverse_one(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  if (USE_WIDE) return traverse_wide(geometry, ray, any_hit, hit);
  if (EK_LAYOUT_bvh2) return traverse_bvh2(geometry, ray, any_hit, hit);
  if (EK_LAYOUT_bvh4) return traverse_bvh4(geometry, ray, any_hit, hit);
  if (EK_LAYOUT_cwbvh) return traverse_cwbvh(geometry, ray, any_hit, hit);
#if USE_CELLS
  return traverse_space(geometry, ray, any_hit, hit);
#endif
  return traverse_none(geometry, ray, any_hit, hit);
}

#if EK_HAS_moving_surface
// Sets the time of rays.
EK_FN void set_time(Geometry geometry, RayLanes* ray, vf time) {
  ray->step = step_of(geometry.scene.motion[0], time, &ray->share);
}
#endif

#if EK_ROWS == 1
// Where lanes are scalars, one ray on its way, by the same functions. There are no tables: an array
// whose index varies would lie in memory.
typedef struct {
  RayOne ray;
  Hit hit;
  int open;  // the ray is to be traced
} Tracing;

EK_FN void tracing_clear(Tracing* tracing) { tracing->open = 0; }

EK_FN void tracing_begin(constant Frame* frame, Geometry geometry, Tracing* tracing, TracedRays rays, const int any_hit) {
  RayLanes ray = ray_lanes(frame, rays.origin, rays.dir, rays.key);
  ray.ends = rays.ends;
#if EK_HAS_moving_surface
  set_time(geometry, &ray, rays.time);
#endif
  ray_store(&tracing->ray, ray, rays.t_max);
#if EK_RAY_IN_LOCAL_MEMORY
  ray_memory_store(geometry.ray_memory, ray);
#endif
  tracing->open = valid_rays(ray, rays.t_max, rays.count);
  tracing->hit = no_hit(rays.t_max);
}

EK_FN void tracing_finish(constant Frame* frame, Geometry geometry, Tracing* tracing, const int any_hit) {
  if (!tracing->open) return;
  Hit hit = tracing->hit;
#if EK_HAS_moving_surface
  geometry = still_geometry(geometry);
#endif
  int found = traverse_one(geometry, &tracing->ray, any_hit, &hit);
#if EK_HAS_moving_surface
  if (!(any_hit & found)) found = traverse_moving(geometry, &tracing->ray, any_hit, &hit);
#endif
  if (EK_HAS_implicit && !(any_hit & found)) report_given_up(geometry, hit.gave_up, hit.gave_up_surface, hit.t);
  if (any_hit & found) hit.triangle = 0u;
#if EK_COUNT
  hit.u = (float)hit.tests;
  hit.v = (float)hit.steps;
#endif
  tracing->hit = hit;
}

EK_FN HitLanes closest_result(const Tracing* tracing, uint row) {
  const HitLanes hit = {.t = tracing->hit.t,
                        .u = tracing->hit.u,
                        .v = tracing->hit.v,
                        .triangle = tracing->hit.triangle,
                        .instance = tracing->hit.instance};
  return hit;
}
EK_FN vi any_result(const Tracing* tracing, uint row) { return tracing->hit.triangle != EK_NO_HIT; }
#else
// EK_ROWS rays on their way: tracing_begin for each vector of them, then tracing_finish, then
// closest_result or any_result.
typedef struct {
  RayOne rays[EK_SORTS ? 1 : EK_ROWS];
#if EK_HAS_moving_surface
  ushort moving[EK_ROWS];  // rows whose rays enter the box around all that moves
  float enter_t[EK_ROWS] EK_ROWS_ALIGNED;  // where they do
  uint moving_count, row_count;
#endif
  HitTable hits;
  ushort open[EK_SORTS ? 1 : EK_ROWS];  // rows that tracing_finish is to trace
  uint open_count;
#if USE_WIDE && EK_WIDTH > 1
  Packet packets[EK_PACKETS];  // they wait until there are enough of them
  uint packet_count;
#endif
#if EK_SORTS
  SortedRays sorted;
#endif
} Tracing;

EK_FN void tracing_clear(Tracing* tracing) {
  tracing->open_count = 0;
#if EK_HAS_moving_surface
  tracing->moving_count = tracing->row_count = 0;
#endif
#if USE_WIDE && EK_WIDTH > 1
  tracing->packet_count = 0;
#endif
#if EK_SORTS
  tracing->sorted.count = 0;
#endif
}

EK_FN void tracing_store(HitTable* hits, uint row, HitLanes hit) {
  *(vf*)(hits->t + row) = hit.t;
  *(vf*)(hits->u + row) = hit.u;
  *(vf*)(hits->v + row) = hit.v;
  *(vu*)(hits->triangle + row) = hit.triangle;
  if (EK_HAS_instance) *(vu*)(hits->instance + row) = hit.instance;
  if (EK_HAS_implicit) {
    *(vf*)(hits->gave_up + row) = hit.gave_up;
    *(vu*)(hits->gave_up_surface + row) = hit.gave_up_surface;
  }
}

#if USE_WIDE && EK_WIDTH > 1
/// The hits of a packet that was traced; lanes without a ray hit nothing. any_hit: a triangle
/// stands for whatever is in the way
EK_FN HitLanes packet_result(const Packet* p, const int any_hit) {
  HitLanes hit = p->hit;
  if (any_hit) hit.triangle = (p->valid & (hit.t < 0.0f)) ? (vu)(0u) : hit.triangle;
  hit.t = p->valid ? hit.t : (vf)(EK_INFINITY);
  return hit;
}

EK_FN void tracing_run_packets(Geometry geometry, Packet* packets, uint count, const int any_hit, HitTable* hits) {
  traverse_packets(geometry, packets, count, any_hit, 0);
  for (uint i = 0; i < count; ++i) {
    if (EK_REPORTS_AT_ONCE) packet_report_given_up(geometry, packets + i);
    tracing_store(hits, packets[i].row, packet_result(packets + i, any_hit));
  }
}
#endif

#if USE_WIDE && EK_WIDTH > 1
// A packet of these rays (at most EK_WIDTH, those of `valid`) that ends at t_max.
EK_FN Packet tracing_packet(RayLanes ray, vi valid, vf t_max, uint row) {
  Packet packet;
  packet.ray = ray;
  packet.valid = valid;
  packet.hit = no_hit_lanes(valid ? t_max : (vf)(-1.0f));
  packet.row = row;
  packet_begin_at_root(&packet);
  return packet;
}
#endif

#if EK_SORTS
EK_FN void tracing_run_sorted(constant Frame* frame, Geometry geometry, Tracing* tracing, const int any_hit) {
  const SortedRays* s = &tracing->sorted;
  HitTable* hits = &tracing->hits;
  uint order[EK_ROWS + EK_WIDTH];
  sorted_order(s, order);
  for (uint first = 0; first < s->count; first += EK_WIDTH) {
    const uint* at = order + first;
    const uint count = min(s->count - first, (uint)EK_WIDTH);
    const v3 origin = V3(sorted_f(s->origin_x, at), sorted_f(s->origin_y, at), sorted_f(s->origin_z, at));
    const v3 dir = V3(sorted_f(s->dir_x, at), sorted_f(s->dir_y, at), sorted_f(s->dir_z, at));
    const vf t_max = any_hit ? sorted_f(s->t_max, at) : (vf)(EK_INFINITY);
    OpacityKey key = {(vu)(0u), (vu)(0u)};
#if EK_HAS_opacity
    key.key = AS_U(sorted_f((const float*)s->key, at));
    key.index = AS_U(sorted_f((const float*)s->index, at));
#endif
    RayLanes ray = ray_lanes(frame, origin, dir, key);
    ray.ends.origin_prim = AS_U(sorted_f((const float*)s->origin_prim, at));
    if (any_hit) ray.ends.target_prim = AS_U(sorted_f((const float*)s->target_prim, at));
    const vi valid = valid_rays(ray, t_max, count);
    Packet packet = tracing_packet(ray, valid, t_max, 0);
    traverse_packets(geometry, &packet, 1u, any_hit, 1);
    if (EK_HAS_implicit) packet_report_given_up(geometry, &packet);
    HitTable one;
    tracing_store(&one, 0, packet_result(&packet, any_hit));
    for (uint lane = 0; lane < count; ++lane) {
      const uint row = s->row[at[lane]];
      hits->triangle[row] = one.triangle[lane];
      if (any_hit) continue;
      hits->t[row] = one.t[lane];
      hits->u[row] = one.u[lane];
      hits->v[row] = one.v[lane];
      if (EK_HAS_instance) hits->instance[row] = one.instance[lane];
    }
  }
}
#endif

#if EK_HAS_moving_surface
// Notes the rays that enter the box around all that moves; returns 1 if there are some.
EK_FN int tracing_note_moving(Geometry geometry, Tracing* tracing, RayLanes ray, vi valid, TracedRays rays) {
  if (EK_LAYOUT_none) return 0;
  vf end;
  const vf begin = moving_interval(geometry, ray, &end);
  const uint bits = mask_bits(valid & (begin <= end) & (begin <= rays.t_max));
  if (bits == 0u) return 0;
  *(vf*)(tracing->enter_t + rays.row) = begin;
  for (uint rest = bits; rest != 0u; rest &= rest - 1u)
    tracing->moving[tracing->moving_count++] = (ushort)(rays.row + lowest_bit(rest));
  return 1;
}

// Keeps those of the noted rays that nothing before that box ends, with where they end.
EK_FN void tracing_end_moving(Tracing* tracing, const int any_hit) {
  const HitTable* hits = &tracing->hits;
  uint kept = 0;
  for (uint i = 0; i < tracing->moving_count; ++i) {
    const uint row = tracing->moving[i];
    tracing->moving[kept] = (ushort)row;
    if (any_hit) {
      kept += hits->triangle[row] == EK_NO_HIT ? 1u : 0u;
    } else {
      tracing->rays[row].t = hits->t[row];
      kept += tracing->enter_t[row] <= hits->t[row] ? 1u : 0u;
    }
  }
  tracing->moving_count = kept;
}

// Looks for hits on triangles that move.
EK_FN void tracing_finish_moving(Geometry geometry, Tracing* tracing, const int any_hit) {
  tracing_end_moving(tracing, any_hit);
  if (tracing->moving_count == 0u) return;
  HitTable* hits = &tracing->hits;
#if USE_WIDE
  traverse_batch(moving_geometry(geometry), tracing->rays, tracing->moving, tracing->moving_count, any_hit, hits);
#else
  for (uint i = 0; i < tracing->moving_count; ++i) {
    const uint row = tracing->moving[i];
    Hit hit = table_hit(hits, row, tracing->rays[row].t);
    hit.u = hits->u[row];
    hit.v = hits->v[row];
    const int found = traverse_moving(geometry, tracing->rays + row, any_hit, &hit);
    hits->t[row] = hit.t;
    hits->u[row] = hit.u;
    hits->v[row] = hit.v;
    hits->triangle[row] = any_hit & found ? 0u : hit.triangle;
    if (EK_HAS_instance) hits->instance[row] = hit.instance;
  }
#endif
}
#endif

// Begins rays. For each, tracing_finish finds the closest hit in 0 < t < t_max, or with any_hit
// whether there is one.
EK_FN void tracing_begin(constant Frame* frame, Geometry geometry, Tracing* tracing, TracedRays rays, const int any_hit) {
#if EK_SORTS
  if (!rays.coherent) {
    sorted_add(frame, &tracing->sorted, rays);
    return;
  }
#endif
  RayLanes ray = ray_lanes(frame, rays.origin, rays.dir, rays.key);
  ray.ends = rays.ends;
  const vi valid = valid_rays(ray, rays.t_max, rays.count);
  int stored = 0;
#if EK_HAS_moving_surface
  geometry = still_geometry(geometry);
  set_time(geometry, &ray, rays.time);
  tracing->row_count = rays.row + rays.count;
  stored = tracing_note_moving(geometry, tracing, ray, valid, rays);
  if (stored) ray_store(tracing->rays + rays.row, ray, rays.t_max);
  if (!some_stands_still(geometry)) {
    tracing_store(&tracing->hits, rays.row, no_hit_lanes(rays.t_max));
    return;
  }
#endif
#if USE_WIDE && EK_WIDTH > 1
  if (ANY(valid) && use_packet(ray, valid, rays.coherent)) {
    Packet packet = tracing_packet(ray, valid, rays.t_max, rays.row);
    if (EK_PACKETS == 1) {
      tracing_run_packets(geometry, &packet, 1u, any_hit, &tracing->hits);
    } else {
      tracing->packets[tracing->packet_count++] = packet;
      if (tracing->packet_count == EK_PACKETS) {
        tracing_run_packets(geometry, tracing->packets, EK_PACKETS, any_hit, &tracing->hits);
        tracing->packet_count = 0;
      }
    }
    return;
  }
#endif
  if (!EK_SORTS) {  // else no ray is left: what was not sorted went in a packet
    if (!stored) ray_store(tracing->rays + rays.row, ray, rays.t_max);
    const uint bits = mask_bits(valid);
    for (uint lane = 0; lane < rays.count; ++lane) {
      tracing->open[tracing->open_count] = (ushort)(rays.row + lane);
      tracing->open_count += bits >> lane & 1u;
    }
  }
  tracing_store(&tracing->hits, rays.row, no_hit_lanes(rays.t_max));
}

EK_FN void tracing_finish(constant Frame* frame, Geometry geometry, Tracing* tracing, const int any_hit) {
  HitTable* hits = &tracing->hits;
#if EK_HAS_moving_surface
  geometry = still_geometry(geometry);
#endif
#if EK_SORTS
  tracing_run_sorted(frame, geometry, tracing, any_hit);
#endif
#if USE_WIDE && EK_WIDTH > 1
  if (EK_PACKETS > 1) tracing_run_packets(geometry, tracing->packets, tracing->packet_count, any_hit, hits);
  if (!EK_SORTS && tracing->open_count != 0) traverse_batch(geometry, tracing->rays, tracing->open, tracing->open_count, any_hit, hits);
#else
  for (uint i = 0; i < tracing->open_count; ++i) {
    const uint row = tracing->open[i];
    Hit hit = no_hit(hits->t[row]);
    const int found = traverse_one(geometry, tracing->rays + row, any_hit, &hit);
    hits->t[row] = hit.t;
#if EK_COUNT
    hits->u[row] = (float)hit.tests;
    hits->v[row] = (float)hit.steps;
#else
    hits->u[row] = hit.u;
    hits->v[row] = hit.v;
#endif
    hits->triangle[row] = any_hit & found ? 0u : hit.triangle;
    if (EK_HAS_instance) hits->instance[row] = hit.instance;
    if (EK_REPORTS_AT_ONCE && !(any_hit & found)) report_given_up(geometry, hit.gave_up, hit.gave_up_surface, hit.t);
    if (EK_HAS_implicit & EK_HAS_moving_surface) {
      hits->gave_up[row] = hit.gave_up;
      hits->gave_up_surface[row] = hit.gave_up_surface;
    }
  }
#endif
#if EK_HAS_moving_surface
  tracing_finish_moving(geometry, tracing, any_hit);
  for (uint row = 0; EK_HAS_implicit && row < tracing->row_count; ++row)
    if (!any_hit || hits->triangle[row] == EK_NO_HIT)
      report_given_up(geometry, hits->gave_up[row], hits->gave_up_surface[row], hits->t[row]);
#endif
}

// The results of EK_WIDTH rows from `row`; those of rows without a ray are arbitrary.
EK_FN HitLanes closest_result(const Tracing* tracing, uint row) {
  HitLanes hit;
  hit.t = *(const vf*)(tracing->hits.t + row);
  hit.u = *(const vf*)(tracing->hits.u + row);
  hit.v = *(const vf*)(tracing->hits.v + row);
  hit.triangle = *(const vu*)(tracing->hits.triangle + row);
  if (EK_HAS_instance) hit.instance = *(const vu*)(tracing->hits.instance + row);
  return hit;
}
EK_FN vi any_result(const Tracing* tracing, uint row) {
  return *(const vu*)(tracing->hits.triangle + row) != (vu)(EK_NO_HIT);
}
#endif

#endif
