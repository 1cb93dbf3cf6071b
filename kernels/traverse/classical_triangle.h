// SPDX-License-Identifier: Apache-2.0
// Two classical tests of a ray and a triangle (EK_TRIANGLE_TEST 1 or 2). Only `bench rays` and
// tests use them, to compare their cost with that of the watertight test. Neither is watertight,
// and no box bounds their t, so accelerators may differ where they round.
//   1  [Moller, Trumbore 1997, "Fast, minimum storage ray/triangle intersection"]
//   2  the point where the ray meets the plane, then its side of each edge, by the cross product of
//      edge and point
// Both work in the axes of traverse/triangle.h, by the depth z on the longest one: the ray is o + z
// (sx, sy, 1).
#ifndef EK_TRAVERSE_CLASSICAL_TRIANGLE_H
#define EK_TRAVERSE_CLASSICAL_TRIANGLE_H

EK_FN float3 classical_cross(float3 a, float3 b) { return (float3)(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x); }
EK_FN float classical_dot(float3 a, float3 b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }

EK_FN TriangleHit_one triangle_hit_classical(const RayOne* ray, Corners_one p) {
  TriangleHit_one r = {0, 0.0f, 0.0f, 0.0f, 0};
  const float3 a = (float3)(p.ax, p.ay, p.az), b = (float3)(p.bx, p.by, p.bz), c = (float3)(p.cx, p.cy, p.cz);
  const float3 o = (float3)(ray->p_o.x, ray->p_o.y, ray->p_o.z), d = (float3)(ray->sx, ray->sy, 1.0f);
  const float3 ab = b - a, ac = c - a;
#if EK_TRIANGLE_TEST == 1
  const float3 s = classical_cross(d, ac), from_a = o - a;
  const float det = classical_dot(ab, s);
  if (det == 0.0f) return r;
  const float inverse = div_f(1.0f, det);
  r.u = classical_dot(from_a, s) * inverse;
  if ((r.u < 0.0f) | (r.u > 1.0f)) return r;
  const float3 q = classical_cross(from_a, ab);
  r.v = classical_dot(d, q) * inverse;
  if ((r.v < 0.0f) | (r.u + r.v > 1.0f)) return r;
  r.t = classical_dot(ac, q) * inverse * ray->p_rcp_d.z;
#else
  const float3 n = classical_cross(ab, ac);
  const float across = classical_dot(n, d);
  if (across == 0.0f) return r;
  const float z = div_f(classical_dot(n, a - o), across);
  r.t = z * ray->p_rcp_d.z;
  if (!(r.t > 0.0f)) return r;
  const float3 x = o + z * d;
  const float in_c = classical_dot(classical_cross(ab, x - a), n), in_a = classical_dot(classical_cross(c - b, x - b), n);
  const float in_b = classical_dot(classical_cross(a - c, x - c), n);
  if ((in_a < 0.0f) | (in_b < 0.0f) | (in_c < 0.0f)) return r;
  const float inverse = div_f(1.0f, classical_dot(n, n));
  r.u = in_b * inverse;
  r.v = in_c * inverse;
#endif
  r.hit = r.t > 0.0f;
  return r;
}

#endif
