// SPDX-License-Identifier: Apache-2.0
// The boxes of a node's children with one byte per plane, as `bvh4` and `cwbvh` have them: plane =
// origin + byte * 2^(exponent - 127). The product is exact. The sum rounds, and
// host/accel/layouts/quantised.cpp chose each byte by this very expression so that the box contains
// the child's. So by the interval rule (ray.h) no child is missed, and hits keep their bits.
//   words 0-2 of a node  the origin x y z, floats
//   word 3               exponents of x, y, z, a byte each from the lowest; the layout says what
//                        the highest byte is
#ifndef EK_QUANTISED_H
#define EK_QUANTISED_H
#include "traverse/hit.h"

// The intervals of four boxes on one axis. entered, left: the planes that the ray enters and leaves
// by, a byte each
EK_FN float4 quantised_interval(uint entered, uint left, float origin, uint exponent, float r, float near_o, float far_o,
                                float4* end) {
  const float scale = as_float(exponent << 23);
  const float4 enters = (float4)(origin) + convert_float4(as_uchar4(entered)) * scale;
  const float4 leaves = (float4)(origin) + convert_float4(as_uchar4(left)) * scale;
  *end = (leaves - far_o) * r;
  return (enters - near_o) * r;
}

EK_FN float4 min_plane(float4 a, float4 b) { return a < b ? a : b; }
EK_FN float4 max_plane(float4 a, float4 b) { return a > b ? a : b; }

// The t at which the ray enters each of four children; *end: the t at which it leaves them. x, y,
// z: bytes of lo, then of hi
EK_FN float4 quantised_boxes(uint4 frame, uint2 x, uint2 y, uint2 z, const RayBoxes* ray, float4* end) {
  const int back_x = ray->rcp_d.x < 0.0f, back_y = ray->rcp_d.y < 0.0f, back_z = ray->rcp_d.z < 0.0f;
  float4 end_x, end_y, end_z;
  const float4 begin_x = quantised_interval(back_x ? x.y : x.x, back_x ? x.x : x.y, as_float(frame.x), frame.w & 255u,
                                            ray->rcp_d.x, ray->o_near.x, ray->o_far.x, &end_x);
  const float4 begin_y = quantised_interval(back_y ? y.y : y.x, back_y ? y.x : y.y, as_float(frame.y),
                                            (frame.w >> 8) & 255u, ray->rcp_d.y, ray->o_near.y, ray->o_far.y, &end_y);
  const float4 begin_z = quantised_interval(back_z ? z.y : z.x, back_z ? z.x : z.y, as_float(frame.z),
                                            (frame.w >> 16) & 255u, ray->rcp_d.z, ray->o_near.z, ray->o_far.z, &end_z);
  *end = min_plane(min_plane(end_x, end_y), end_z);
  return max_plane(max_plane(begin_x, begin_y), max_plane(begin_z, (float4)(0.0f)));
}

#endif
