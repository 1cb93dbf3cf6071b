// SPDX-License-Identifier: Apache-2.0
// A packet's rays against the triangles and shapes of a block.
#ifndef EK_PACKET_BLOCK_H
#define EK_PACKET_BLOCK_H
#include "traverse/wide/packet_lanes.h"

// A corner of one triangle for all lanes.
EK_FN void packet_corner(PacketAxes axes, PacketBlock p, vf* x, vf* y, vf* z) {
  if (axes.same) {
    *x = (vf)(p[axes.x]);
    *y = (vf)(p[axes.y]);
    *z = (vf)(p[axes.z]);
  } else {
    const v3 corner = permute3(V3((vf)(p[0]), (vf)(p[8]), (vf)(p[16])), axes.z_is_x, axes.z_is_y);
    *x = corner.x;
    *y = corner.y;
    *z = corner.z;
  }
}

#if EK_HAS_shape
// Tests the shape of a place in a block, and keeps where its search was given up; u is its part.
EK_FN TriangleHit_lanes packet_shape(SceneData scene, Packet* p, global const float* at, uint id) {
  const ShapeHit met = shape_hit_one(scene, &p->ray, p->valid, p->hit.t, id, V3((vf)(at[0]), (vf)(at[8]), (vf)(at[16])),
                                     V3((vf)(at[24]), (vf)(at[32]), (vf)(at[40])));
#if EK_HAS_implicit
  const vu shape = (vu)(as_uint(((global const float*)(scene.triangles + id))[12]));
  HitLanes* hit = &p->hit;
  const vi nearer = (met.gave_up < hit->gave_up) | ((met.gave_up == hit->gave_up) & (shape < hit->gave_up_surface));
  hit->gave_up = nearer ? met.gave_up : hit->gave_up;
  hit->gave_up_surface = nearer ? shape : hit->gave_up_surface;
#endif
  const TriangleHit_lanes found = {met.hit, met.t, met.part, (vf)(0.0f)};
  return found;
}
#endif

// Keeps hits that are nearer than those so far.
EK_FN void packet_keep(Packet* p, TriangleHit_lanes found, vu triangle, vu instance, const int any_hit) {
  HitLanes* hit = &p->hit;
  if (any_hit) {
    hit->t = (found.hit & (found.t < hit->t)) ? (vf)(-1.0f) : hit->t;
    return;
  }
  const vi closer = found.hit & lanes_closer(hit, found.t, triangle, instance);
  hit->t = closer ? found.t : hit->t;
  hit->u = closer ? found.u : hit->u;
  hit->v = closer ? found.v : hit->v;
  hit->triangle = closer ? triangle : hit->triangle;
#if EK_HAS_instance
  hit->instance = closer ? instance : hit->instance;
#endif
}

// Lanes whose triangle is not at their ray's ends.
EK_FN vi packet_meets(const Packet* p, vu triangle, const int any_hit) {
  const vi meets = p->ray.ends.left != triangle;
  return any_hit ? meets & (p->ray.ends.goal != triangle) : meets;
}

// Triangle `triangle`, at `corners` in a block, for all lanes.
EK_FN PacketTriangles packet_triangle(Geometry geometry, const Packet* p, PacketBlock corners, uint triangle, const int any_hit) {
  PacketTriangles all;
  all.here = p->valid & packet_meets(p, (vu)(triangle), any_hit);
  packet_corner(p->axes, corners, &all.corners.ax, &all.corners.ay, &all.corners.az);
  packet_corner(p->axes, corners + 24, &all.corners.bx, &all.corners.by, &all.corners.bz);
  packet_corner(p->axes, corners + 48, &all.corners.cx, &all.corners.cy, &all.corners.cz);
  all.triangle = (vu)(triangle);
#if EK_HAS_instance
  all.instance = (vu)(p->instance);
#endif
#if EK_HAS_opacity
  all.passable = (vi)(is_alpha_tested(geometry.scene, triangle) ? -1 : 0);
#endif
  return all;
}

// Tests each ray of `here` with its triangle.
EK_FN void packet_test(Geometry geometry, Packet* p, const PacketTriangles* each, const int any_hit) {
  TriangleHit_lanes found = triangle_hit_lanes(&p->ray, each->corners);
  found.hit = found.hit & each->here;
  if (mask_bits(found.hit) == 0) return;
#if EK_HAS_opacity
  const vi ask = found.hit & (found.t <= p->hit.t) & each->passable;
  if (mask_bits(ask) != 0) {
    const vu triangle = ask ? each->triangle : (vu)(0u);  // where none has waited yet there is none
    found.hit = found.hit & !(ask & alpha_test_rejects(geometry.scene, triangle, found.u, found.v, p->ray.key));
  }
#endif
#if EK_HAS_instance
  packet_keep(p, found, each->triangle, each->instance, any_hit);
#else
  packet_keep(p, found, each->triangle, (vu)(0u), any_hit);
#endif
}

// The triangles that wait.
EK_FN void packet_test_waiting(Geometry geometry, Packet* p, const int any_hit) {
  if (mask_bits(p->waits.here) == 0) return;
  packet_test(geometry, p, &p->waits, any_hit);
  p->waits.here = (vi)(0);
}

// Where rays share little, each may hit few of the triangles that the packet meets, and not the same ones: the exact test
// waits until a ray has a second.
EK_FN void packet_wait(Geometry geometry, Packet* p, const PacketTriangles* each, const int any_hit) {
  PacketTriangles* waits = &p->waits;
  const vi may = each->here & triangle_may_be_hit_lanes(&p->ray, each->corners, p->hit.t);
  if (mask_bits(may & waits->here) != 0) packet_test_waiting(geometry, p, any_hit);
  waits->here = waits->here | may;
#define PACKET_WAITS(name) waits->name = may ? each->name : waits->name;
  PACKET_WAITS(corners.ax) PACKET_WAITS(corners.ay) PACKET_WAITS(corners.az) PACKET_WAITS(corners.bx) PACKET_WAITS(corners.by)
  PACKET_WAITS(corners.bz) PACKET_WAITS(corners.cx) PACKET_WAITS(corners.cy) PACKET_WAITS(corners.cz) PACKET_WAITS(triangle)
#if EK_HAS_instance
  PACKET_WAITS(instance)
#endif
#if EK_HAS_opacity
  PACKET_WAITS(passable)
#endif
#undef PACKET_WAITS
}

#if EK_LARGE_TREE && EK_WIDTH > 1
#if EK_WIDTH == 16
#define PACKET_EIGHTS(row) ((vf)(row, row))
#else
#define PACKET_EIGHTS(row) (row)
#endif

// Lanes of p->lanes: bit k where the ray may hit triangle k of eight. As many rays are asked the first questions at a time as there are
// eights in a vector. corners: the eight triangles, once for each, in the axes that all rays have.
EK_FN vu packet_candidates(const Packet* p, const Corners_lanes* corners) {
  const RayLanes* ray = &p->ray;
  vu candidates = (vu)(0u);
  for (uint lanes = p->lanes; lanes != 0;) {
    const uint first = lowest_bit(lanes);
    lanes &= lanes - 1u;
    uint second = first;
#if EK_WIDTH == 16
    second = lanes != 0 ? lowest_bit(lanes) : first;
    lanes &= lanes - 1u;
#endif
    const vu lane = LANE_INDEX < 8u ? (vu)(first) : (vu)(second);
    RayLanes of;
    of.p_ox = lanes_of(ray->p_ox, lane); of.p_oy = lanes_of(ray->p_oy, lane); of.p_oz = lanes_of(ray->p_oz, lane);
    of.sx = lanes_of(ray->sx, lane); of.sy = lanes_of(ray->sy, lane); of.p_rz = lanes_of(ray->p_rz, lane);
    of.slack = lanes_of(ray->slack, lane);
    const uint bits = mask_bits(triangle_may_be_hit_lanes(&of, *corners, lanes_of(p->hit.t, lane)));
    candidates = LANE_INDEX == second ? (vu)(bits >> 8) : candidates;
    candidates = LANE_INDEX == first ? (vu)(bits & 0xffu) : candidates;
  }
  return candidates;
}

// Where few rays meet a block, and not the same triangles: what the first questions leave is tested together, each ray with its own
// triangle. All rays have the same axes.
// stored: the block; block: its corners at the packet's place. returns which places hold no triangles, but shapes
EK_FN uint packet_each(Geometry geometry, Packet* p, global const float* stored, PacketBlock block, const int any_hit) {
  const PacketRow x = (PacketRow)(block + p->axes.x), y = (PacketRow)(block + p->axes.y), z = (PacketRow)(block + p->axes.z);
  const Corners_lanes corners = {PACKET_EIGHTS(x[0]), PACKET_EIGHTS(y[0]), PACKET_EIGHTS(z[0]), PACKET_EIGHTS(x[3]), PACKET_EIGHTS(y[3]),
                                 PACKET_EIGHTS(z[3]), PACKET_EIGHTS(x[6]), PACKET_EIGHTS(y[6]), PACKET_EIGHTS(z[6])};
  vu left = packet_candidates(p, &corners);
  while (ANY(left != 0u)) {
    const vu next = left != 0u ? left & (0u - left) : (vu)(1u);
    const vu k = (AS_U(TO_F(AS_I(next))) >> 23) - 127u;  // of 2^k
    PacketTriangles each;
    each.triangle = AS_U(lanes_of(PACKET_EIGHTS(*(global const float8*)(stored + 72)), k));
    each.here = (left != 0u) & packet_meets(p, each.triangle, any_hit);
    each.corners.ax = lanes_of(corners.ax, k); each.corners.ay = lanes_of(corners.ay, k); each.corners.az = lanes_of(corners.az, k);
    each.corners.bx = lanes_of(corners.bx, k); each.corners.by = lanes_of(corners.by, k); each.corners.bz = lanes_of(corners.bz, k);
    each.corners.cx = lanes_of(corners.cx, k); each.corners.cy = lanes_of(corners.cy, k); each.corners.cz = lanes_of(corners.cz, k);
    left &= ~next;
#if EK_HAS_instance
    each.instance = (vu)(p->instance);
#endif
#if EK_HAS_opacity
    uint triangle[EK_WIDTH] EK_ROWS_ALIGNED;
    int passable[EK_WIDTH] EK_ROWS_ALIGNED;
    *(vu*)triangle = each.triangle;
    *(vi*)passable = (vi)(0);
    for (uint lanes = mask_bits(each.here); lanes != 0; lanes &= lanes - 1u) {
      const uint lane = lowest_bit(lanes);
      passable[lane] = is_alpha_tested(geometry.scene, triangle[lane]) ? -1 : 0;
    }
    each.passable = *(const vi*)passable;
#endif
    packet_test(geometry, p, &each, any_hit);
  }
#if EK_HAS_shape
  const float8 third_x = *(global const float8*)(stored + 48);
  return mask_bits8(third_x != third_x);
#else
  return 0;
#endif
}
#endif

// All that is in a block. apart: the rays share little (packet_wait).
EK_FN void packet_block(Geometry geometry, Packet* p, uint child, const int any_hit, const int apart) {
  global const float* stored = wide_block(geometry, child);
#if EK_HAS_instance
  float block[72] __attribute__((aligned(64)));
  packet_place_block(geometry, p, stored, block);
#else
  global const float* block = stored;
#endif
  uint bits = 0xffu;
#if EK_LARGE_TREE && EK_WIDTH > 1
  if (p->axes.same) bits = packet_each(geometry, p, stored, block, any_hit);
#endif
  for (; bits != 0; bits &= bits - 1u) {
    const uint k = lowest_bit(bits);
    const uint triangle = as_uint(stored[72 + k]);
    if (triangle == EK_NO_HIT) break;
#if EK_HAS_shape
    if (stored[48 + k] != stored[48 + k]) {
      // Behind all triangles, by its instance.
      packet_keep(p, packet_shape(geometry.scene, p, stored + k, triangle), (vu)(triangle), (vu)(EK_NO_HIT), any_hit);
      continue;
    }
#endif
    const PacketTriangles all = packet_triangle(geometry, p, block + k, triangle, any_hit);
    if (apart)
      packet_wait(geometry, p, &all, any_hit);
    else
      packet_test(geometry, p, &all, any_hit);
  }
}

#endif
