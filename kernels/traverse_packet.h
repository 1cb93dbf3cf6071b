// SPDX-License-Identifier: Apache-2.0
// All lanes' rays together through the `bvh8` layout: for rays that are neighbours, and for trees so small that any rays share
// most of the way. A node's boxes are first held against bounds of the whole packet, eight at once, then one by one against
// the rays. The bounds need no margin, because rounding is monotone; each ray's own test is that of traverse_bvh8.h; so a
// ray meets every triangle that could be its hit, and the hits have the same bits.
// source [Wald, Boulos, Shirley 2007, "Ray tracing deformable scenes using dynamic bounding volume hierarchies"]
#ifndef EK_TRAVERSE_PACKET_H
#define EK_TRAVERSE_PACKET_H
#include "traverse_bvh8.h"

#if EK_WIDTH == 1
EK_FN float lanes_min(vf a) { return a; }
EK_FN float lanes_max(vf a) { return a; }
#else
EK_FN float lanes_min8(float8 a) {
  const float4 b = a.lo < a.hi ? a.lo : a.hi;
  const float2 c = b.lo < b.hi ? b.lo : b.hi;
  return c.x < c.y ? c.x : c.y;
}
EK_FN float lanes_max8(float8 a) {
  const float4 b = a.lo > a.hi ? a.lo : a.hi;
  const float2 c = b.lo > b.hi ? b.lo : b.hi;
  return c.x > c.y ? c.x : c.y;
}
#if EK_WIDTH == 8
EK_FN float lanes_min(vf a) { return lanes_min8(a); }
EK_FN float lanes_max(vf a) { return lanes_max8(a); }
#else
EK_FN float lanes_min(vf a) { return lanes_min8(shape_min_block(a.lo, a.hi)); }
EK_FN float lanes_max(vf a) { return lanes_max8(shape_max_block(a.lo, a.hi)); }
#endif
#endif

// Bounds of a packet on one axis. Where the signs of the directions differ the axis bounds nothing: r is 0, open infinite.
typedef struct {
  float r_lo, r_hi, near_o, far_o, open;
  uint near, far;  // offsets of the planes in a node
} PacketAxis;

EK_FN PacketAxis packet_axis(vi valid, vf r, vf n, vf f, uint planes) {
  const vf least = -EK_INFINITY, most = EK_INFINITY;
  PacketAxis a;
  a.r_lo = lanes_min(valid ? r : most);
  a.r_hi = lanes_max(valid ? r : least);
  const int negative = a.r_hi < 0.0f, mixed = (a.r_lo < 0.0f) & !negative;
  a.near_o = negative ? lanes_min(valid ? n : most) : lanes_max(valid ? n : least);
  a.far_o = negative ? lanes_max(valid ? f : least) : lanes_min(valid ? f : most);
  a.open = mixed ? INFINITY : 0.0f;
  a.r_lo = mixed ? 0.0f : a.r_lo;
  a.r_hi = mixed ? 0.0f : a.r_hi;
  a.near = planes + (negative ? 8u : 0u);
  a.far = planes + (negative ? 0u : 8u);
  return a;
}
// At most what any ray of the packet finds for the begin of its interval on this axis, at least what it finds for the end.
EK_FN float8 packet_begin(PacketAxis a, global const float* node) {
  const float8 d = bvh8_load(node + a.near) - a.near_o;
  return shape_min_block(d * a.r_lo, d * a.r_hi);
}
EK_FN float8 packet_end(PacketAxis a, global const float* node) {
  const float8 d = bvh8_load(node + a.far) - a.far_o;
  return shape_max_block(d * a.r_lo, d * a.r_hi) + a.open;
}

// t in lengths of the direction; u, v: weights of corners b and c; triangle: EK_NO_HIT where nothing was hit.
typedef struct {
  vf t, u, v;
  vu triangle;
} HitLanes;

// Which axis is z of each lane's triangle test; `same` if it is one for all, with the offsets of x, y and z in a block.
typedef struct {
  vi z_is_x, z_is_y;
  int same;
  uint x, y, z;
} PacketAxes;

EK_FN PacketAxes packet_axes(const RayLanes* ray, vi valid) {
  PacketAxes a;
  a.z_is_x = ray->axis == 0.0f;
  a.z_is_y = ray->axis == 1.0f;
  const float least = lanes_min(valid ? ray->axis : (vf)(2.0f)), most = lanes_max(valid ? ray->axis : (vf)(0.0f));
  a.same = least >= most;
  a.z = 8u * (uint)least;
  a.x = a.z == 16u ? 0u : a.z + 8u;
  a.y = a.x == 16u ? 0u : a.x + 8u;
  return a;
}

EK_FN void packet_corner(PacketAxes axes, global const float* p, vf* x, vf* y, vf* z) {
  if (axes.same) {
    *x = (vf)(p[axes.x]);
    *y = (vf)(p[axes.y]);
    *z = (vf)(p[axes.z]);
  } else {
    const vf a = (vf)(p[0]), b = (vf)(p[8]), c = (vf)(p[16]);
    *x = axes.z_is_x ? b : axes.z_is_y ? c : a;
    *y = axes.z_is_x ? c : axes.z_is_y ? a : b;
    *z = axes.z_is_x ? a : axes.z_is_y ? b : c;
  }
}

// hit->t: where each ray ends, -1 for a lane without a valid ray; an any-hit query leaves -1 where something was found.
EK_FN void traverse_packet(Geometry geometry, const RayLanes* ray, vi valid, const int any_hit, HitLanes* hit) {
  ulong stack[EK_STACK_SIZE];
  uint waiting = 0, current = 0;
  const PacketAxis x = packet_axis(valid, ray->rx, ray->nx, ray->fx, 0u), y = packet_axis(valid, ray->ry, ray->ny, ray->fy, 16u),
                   z = packet_axis(valid, ray->rz, ray->nz, ray->fz, 32u);
  const vi negative_x = ray->rx < 0.0f, negative_y = ray->ry < 0.0f, negative_z = ray->rz < 0.0f;
  const PacketAxes axes = packet_axes(ray, valid);
  const vf zero = (vf)(0.0f);
  float farthest = lanes_max(hit->t);
  for (;;) {
    if (!(current & BVH8_LEAF)) {
      global const float* node = (global const float*)geometry.nodes + (size_t)current * 64;
      global const uint* children = (global const uint*)node + 48;
      const float8 begins = shape_max_block(shape_max_block(packet_begin(x, node), packet_begin(y, node)),
                                            shape_max_block(packet_begin(z, node), (float8)(0.0f)));
      const float8 ends = shape_min_block(shape_min_block(packet_end(x, node), packet_end(y, node)),
                                          shape_min_block(packet_end(z, node), (float8)(farthest)));
      uint bits = mask_bits8(begins <= ends);
      float begin[8] __attribute__((aligned(32)));
      *(float8*)begin = begins;
      const uint base = waiting;
      while (bits != 0) {
        const uint k = lowest_bit(bits);
        bits &= bits - 1;
        const vf lo_x = (vf)(node[k]), hi_x = (vf)(node[8 + k]), lo_y = (vf)(node[16 + k]), hi_y = (vf)(node[24 + k]),
                 lo_z = (vf)(node[32 + k]), hi_z = (vf)(node[40 + k]);
        const vf begin_x = ((negative_x ? hi_x : lo_x) - ray->nx) * ray->rx, end_x = ((negative_x ? lo_x : hi_x) - ray->fx) * ray->rx;
        const vf begin_y = ((negative_y ? hi_y : lo_y) - ray->ny) * ray->ry, end_y = ((negative_y ? lo_y : hi_y) - ray->fy) * ray->ry;
        const vf begin_z = ((negative_z ? hi_z : lo_z) - ray->nz) * ray->rz, end_z = ((negative_z ? lo_z : hi_z) - ray->fz) * ray->rz;
        const vf first = shape_max_lanes(shape_max_lanes(begin_x, begin_y), shape_max_lanes(begin_z, zero));
        const vf last = shape_min_lanes(shape_min_lanes(end_x, end_y), shape_min_lanes(end_z, hit->t));
        if (mask_bits(first <= last) == 0) continue;
        // Insertion into the stack's end, nearest last.
        const ulong entry = bvh8_entry(begin, children, k);
        uint at = waiting++;
        for (; at > base && stack[at - 1] < entry; --at) stack[at] = stack[at - 1];
        stack[at] = entry;
      }
    } else {
      global const float* block = (global const float*)geometry.leaves + (size_t)(current & ~BVH8_LEAF) * 80;
      for (uint k = 0; k < 8; ++k) {
        const uint triangle = as_uint(block[72 + k]);
        if (triangle == EK_NO_HIT) break;
        Corners_lanes corners;
        packet_corner(axes, block + k, &corners.ax, &corners.ay, &corners.az);
        packet_corner(axes, block + 24 + k, &corners.bx, &corners.by, &corners.bz);
        packet_corner(axes, block + 48 + k, &corners.cx, &corners.cy, &corners.cz);
        TriangleHit_lanes found = triangle_hit_lanes(ray, corners);
        if (mask_bits(found.hit) == 0) continue;
        if (EK_HAS_opacity && mask_bits(found.hit & (found.t <= hit->t)) != 0 && may_be_passed(geometry.scene, triangle))
          found.hit = found.hit & !passes(geometry.scene, (vu)(triangle), found.u, found.v, ray_key(ray));
        if (any_hit) {
          hit->t = (found.hit & (found.t < hit->t)) ? (vf)(-1.0f) : hit->t;
        } else {
          const vi closer = found.hit & ((found.t < hit->t) | ((found.t == hit->t) & ((vu)(triangle) < hit->triangle)));
          hit->t = closer ? found.t : hit->t;
          hit->u = closer ? found.u : hit->u;
          hit->v = closer ? found.v : hit->v;
          hit->triangle = closer ? (vu)(triangle) : hit->triangle;
        }
      }
      farthest = lanes_max(hit->t);
      if (any_hit && farthest < 0.0f) return;
    }
    ulong next;
    do {
      if (waiting == 0) return;
      next = stack[--waiting];
    } while (as_float((uint)(next >> 32)) > farthest);
    current = (uint)next;
  }
}

#endif
