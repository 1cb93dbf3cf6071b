// SPDX-License-Identifier: Apache-2.0
// Bounds of all rays of a packet, against which all boxes of a node are tested at once (packet.h).
#ifndef EK_PACKET_BOUNDS_H
#define EK_PACKET_BOUNDS_H
#include "traverse/wide/wide.h"

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
EK_FN float lanes_min(vf a) { return lanes_min8(a.lo < a.hi ? a.lo : a.hi); }
EK_FN float lanes_max(vf a) { return lanes_max8(a.lo > a.hi ? a.lo : a.hi); }
#endif
#endif

// Bounds of a packet on one axis. Where the signs of the directions differ the axis bounds nothing:
// r is then 0, and open infinite.
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
  a.near = planes + (negative ? EK_NODE_WIDTH : 0u);
  a.far = planes + (negative ? 0u : EK_NODE_WIDTH);
  return a;
}
// packet_begin is at most what any ray of the packet finds for the begin of its interval on this
// axis; packet_end is at least what it finds for the end.
EK_FN wf packet_begin(PacketAxis a, global const float* node) {
  const wf d = wide_load(node + a.near) - a.near_o;
  return wide_min(d * a.r_lo, d * a.r_hi);
}
EK_FN wf packet_end(PacketAxis a, global const float* node) {
  const wf d = wide_load(node + a.far) - a.far_o;
  return wide_max(d * a.r_lo, d * a.r_hi) + a.open;
}

#endif
