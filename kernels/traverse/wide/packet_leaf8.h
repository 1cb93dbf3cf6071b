// SPDX-License-Identifier: Apache-2.0
// The test of a packet's rays against the triangles and shapes of a leaf.
#ifndef EK_PACKET_LEAF8_H
#define EK_PACKET_LEAF8_H
#include "traverse/wide/packet_lanes.h"

// Loads a corner of one triangle for all lanes.
EK_FN void packet_corner(PacketAxes axes, PacketCorners p, vf* x, vf* y, vf* z) {
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
// Tests the shape at a place in a leaf, and keeps where its search was given up. u of the result is
// the shape's part.
EK_FN TriangleHit_lanes packet_shape(SceneData scene, Packet* p, global const float* at, uint id) {
  const ShapeHit met = shape_hit_one(scene, &p->ray, p->valid, p->hit.t, id, V3((vf)(at[0]), (vf)(at[8]), (vf)(at[16])),
                                     V3((vf)(at[24]), (vf)(at[32]), (vf)(at[40])));
  const vu shape = (vu)(as_uint(((global const float*)(scene.triangles + id))[12]));
  if (EK_HAS_implicit) keep_given_up_lanes(met.gave_up, shape, &p->hit.gave_up, &p->hit.gave_up_surface);
  const TriangleHit_lanes found = {met.hit, met.t, met.part, (vf)(0.0f), (vi)(0)};
  return found;
}
#endif

// Keeps the hits that are closer than those so far.
EK_FN void packet_keep(Packet* p, TriangleHit_lanes found, vu triangle, vu instance, const int any_hit) {
  HitLanes* hit = &p->hit;
  if (any_hit) {
    hit->t = (found.hit & (found.t < hit->t)) ? (vf)(-1.0f) : hit->t;
    return;
  }
  const vi closer = found.hit & is_closer_lanes(hit, found.t, triangle, instance);
  hit->t = closer ? found.t : hit->t;
  hit->u = closer ? found.u : hit->u;
  hit->v = closer ? found.v : hit->v;
  hit->triangle = closer ? triangle : hit->triangle;
  if (EK_HAS_instance) hit->instance = closer ? instance : hit->instance;
}

// The lanes whose ray neither starts nor ends at their triangle.
EK_FN vi packet_meets(const Packet* p, vu triangle, const int any_hit) {
  const vi meets = p->ray.ends.origin_prim != triangle;
  return any_hit ? meets & (p->ray.ends.target_prim != triangle) : meets;
}

// Loads `triangle`, whose corners are at `corners` in a leaf, for all lanes.
EK_FN PacketTriangles packet_triangle(Geometry geometry, const Packet* p, PacketCorners corners, uint triangle, const int any_hit) {
  PacketTriangles all;
  all.here = p->valid & packet_meets(p, (vu)(triangle), any_hit);
  packet_corner(p->axes, corners, &all.corners.ax, &all.corners.ay, &all.corners.az);
  packet_corner(p->axes, corners + 24, &all.corners.bx, &all.corners.by, &all.corners.bz);
  packet_corner(p->axes, corners + 48, &all.corners.cx, &all.corners.cy, &all.corners.cz);
  all.triangle = (vu)(triangle);
  if (EK_HAS_instance) all.instance = (vu)(p->instance);
  if (EK_HAS_opacity) all.alpha_tested = (vi)(is_alpha_tested(geometry.scene, triangle) ? -1 : 0);
  return all;
}

// Tests each ray of `here` against its triangle.
EK_FN void packet_test(Geometry geometry, Packet* p, const PacketTriangles* each, const int any_hit) {
  TriangleHit_lanes found = triangle_hit_lanes(&p->ray, each->corners);
  found.hit = found.hit & each->here;
  if (mask_bits(found.hit) == 0) return;
  if (EK_CULLS(any_hit)) {
    const vi ask = found.hit & found.back & (found.t <= p->hit.t);
    if (EK_CULLED(geometry.scene) != 0u && mask_bits(ask) != 0) {
      const vu flags = load_word_u(Triangle, geometry.scene.triangles, ask ? each->triangle : (vu)(0u), flags);
      found.hit = found.hit & !culls_lanes(geometry, ask, flags);
    }
  }
  if (EK_HAS_opacity) {
    const vi ask = found.hit & (found.t <= p->hit.t) & each->alpha_tested;
    if (mask_bits(ask) != 0) {
      const vu triangle = ask ? each->triangle : (vu)(0u);  // a lane whose triangle was never set has any number there
      found.hit = found.hit & !(ask & alpha_test_rejects(geometry.scene, triangle, found.u, found.v, p->ray.key));
    }
  }
  packet_keep(p, found, each->triangle, each->instance, any_hit);
}

// Tests the triangles that wait.
EK_FN void packet_test_waiting(Geometry geometry, Packet* p, const int any_hit) {
  if (mask_bits(p->waits.here) == 0) return;
  packet_test(geometry, p, &p->waits, any_hit);
  p->waits.here = (vi)(0);
}

// Lets each ray's candidate wait until a ray has a second one, and then tests all that wait. This
// pays where rays share little: each then hits few of the triangles that the packet meets, and
// rarely the same ones.
EK_FN void packet_wait(Geometry geometry, Packet* p, const PacketTriangles* each, const int any_hit) {
  PacketTriangles* waits = &p->waits;
  const vi may = each->here & triangle_may_be_hit_lanes(&p->ray, each->corners, p->hit.t);
  if (mask_bits(may & waits->here) != 0) packet_test_waiting(geometry, p, any_hit);
  waits->here = waits->here | may;
#define PACKET_WAITS(name) waits->name = may ? each->name : waits->name;
  PACKET_WAITS(corners.ax) PACKET_WAITS(corners.ay) PACKET_WAITS(corners.az) PACKET_WAITS(corners.bx) PACKET_WAITS(corners.by)
  PACKET_WAITS(corners.bz) PACKET_WAITS(corners.cx) PACKET_WAITS(corners.cy) PACKET_WAITS(corners.cz) PACKET_WAITS(triangle)
  if (EK_HAS_instance) { PACKET_WAITS(instance) }
  if (EK_HAS_opacity) { PACKET_WAITS(alpha_tested) }
#undef PACKET_WAITS
}

#if EK_LARGE_TREE && EK_WIDTH > 1
#if EK_WIDTH == 16
#define PACKET_EIGHTS(row) ((vf)(row, row))
#else
#define PACKET_EIGHTS(row) (row)
#endif

// Pre-tests eight triangles for each lane of p->lanes; bit k of a lane says that its ray may hit
// triangle k. A vector of 16 lanes holds the eight triangles twice, so two rays are tested at a
// time.
// corners  the eight triangles, in the axes that all rays have
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
    of.p_o.x = lanes_of(ray->p_o.x, lane); of.p_o.y = lanes_of(ray->p_o.y, lane); of.p_o.z = lanes_of(ray->p_o.z, lane);
    of.sx = lanes_of(ray->sx, lane); of.sy = lanes_of(ray->sy, lane); of.p_rcp_d.z = lanes_of(ray->p_rcp_d.z, lane);
    of.t_slack = lanes_of(ray->t_slack, lane);
    const uint bits = mask_bits(triangle_may_be_hit_lanes(&of, *corners, lanes_of(p->hit.t, lane)));
    candidates = LANE_INDEX == second ? (vu)(bits >> 8) : candidates;
    candidates = LANE_INDEX == first ? (vu)(bits & 0xffu) : candidates;
  }
  return candidates;
}

// The lanes of `here` whose triangle is alpha tested.
EK_FN vi packet_alpha_tested(Geometry geometry, const PacketTriangles* each) {
  uint triangle[EK_WIDTH] EK_ROWS_ALIGNED;
  int alpha_tested[EK_WIDTH] EK_ROWS_ALIGNED;
  *(vu*)triangle = each->triangle;
  *(vi*)alpha_tested = (vi)(0);
  for (uint lanes = mask_bits(each->here); lanes != 0; lanes &= lanes - 1u) {
    const uint lane = lowest_bit(lanes);
    alpha_tested[lane] = is_alpha_tested(geometry.scene, triangle[lane]) ? -1 : 0;
  }
  return *(const vi*)alpha_tested;
}

// Tests each ray against candidates of its own, all rays together: for leaves that few rays meet,
// and not in the same triangles. All rays have the same axes. It returns the places of the leaf
// that hold shapes, which it does not test.
// stored      the leaf
// corners_at  its corners, in the world
EK_FN uint packet_each(Geometry geometry, Packet* p, global const float* stored, PacketCorners corners_at, const int any_hit) {
  const PacketRow x = (PacketRow)(corners_at + p->axes.x), y = (PacketRow)(corners_at + p->axes.y), z = (PacketRow)(corners_at + p->axes.z);
  const Corners_lanes corners = {PACKET_EIGHTS(x[0]), PACKET_EIGHTS(y[0]), PACKET_EIGHTS(z[0]), PACKET_EIGHTS(x[3]), PACKET_EIGHTS(y[3]),
                                 PACKET_EIGHTS(z[3]), PACKET_EIGHTS(x[6]), PACKET_EIGHTS(y[6]), PACKET_EIGHTS(z[6])};
  vu left = packet_candidates(p, &corners);
  while (ANY(left != 0u)) {
    const vu next = left != 0u ? left & (0u - left) : (vu)(1u);
    const vu k = (AS_U(TO_F(AS_I(next))) >> 23) - 127u;  // of 2^k
    PacketTriangles each;
    each.triangle = AS_U(lanes_of(PACKET_EIGHTS(*(global const float8*)(stored + LEAF8_TRIANGLES)), k));
    each.here = (left != 0u) & packet_meets(p, each.triangle, any_hit);
    each.corners.ax = lanes_of(corners.ax, k); each.corners.ay = lanes_of(corners.ay, k); each.corners.az = lanes_of(corners.az, k);
    each.corners.bx = lanes_of(corners.bx, k); each.corners.by = lanes_of(corners.by, k); each.corners.bz = lanes_of(corners.bz, k);
    each.corners.cx = lanes_of(corners.cx, k); each.corners.cy = lanes_of(corners.cy, k); each.corners.cz = lanes_of(corners.cz, k);
    left &= ~next;
    if (EK_HAS_instance) each.instance = (vu)(p->instance);
    if (EK_HAS_opacity) each.alpha_tested = packet_alpha_tested(geometry, &each);
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

// Tests all that is in a leaf. apart: 1 if the rays share little (packet_wait)
EK_FN void packet_leaf8(Geometry geometry, Packet* p, uint child, const int any_hit, const int apart) {
  global const float* stored = wide_leaf8(geometry, child);
#if EK_HAS_instance
  float corners[LEAF8_TRIANGLES] __attribute__((aligned(64)));
  packet_world_corners(geometry, p, stored, corners);
#else
  global const float* corners = stored;
#endif
  uint bits = 0xffu;
#if EK_LARGE_TREE && EK_WIDTH > 1
  if (p->axes.same) bits = packet_each(geometry, p, stored, corners, any_hit);
#endif
  for (; bits != 0; bits &= bits - 1u) {
    const uint k = lowest_bit(bits);
    const uint triangle = as_uint(stored[LEAF8_TRIANGLES + k]);
    if (triangle == EK_NO_HIT) break;
#if EK_HAS_shape
    if (stored[48 + k] != stored[48 + k]) {
      packet_keep(p, packet_shape(geometry.scene, p, stored + k, triangle), (vu)(triangle), (vu)(INSTANCE_SHAPE), any_hit);
      continue;
    }
#endif
    const PacketTriangles all = packet_triangle(geometry, p, corners + k, triangle, any_hit);
    if (apart)
      packet_wait(geometry, p, &all, any_hit);
    else
      packet_test(geometry, p, &all, any_hit);
  }
}

#endif
