// SPDX-License-Identifier: Apache-2.0
// The point where a ray meets a surface, a bound on the error of that point, and the origins of
// rays that leave it.
#ifndef EK_SURFACE_H
#define EK_SURFACE_H
#include "lanes/math.h"
#include "lanes/record_lanes.h"

/// (p1 - p0) x (p2 - p0), unit; its error is some 2^-23 over the sine of the angle at p0. It serves
/// lights, whose records have no room for a normal; triangles have a better one in their record.
/// The result is not finite where the product in floats vanishes, and does not change under scaling
/// by powers of two, for edges from 2^-60 to 2^60 m.
EK_FN v3 triangle_normal(v3 p0, v3 p1, v3 p2) {
  const v3 n = cross3(sub3(p1, p0), sub3(p2, p0));
  // n has the size of a squared length, whose square would leave the range of float, so it is
  // scaled by a power of two first.
  return normalize3(scale3(n, inverse_power_of_two(max_component(abs3(n)))));
}

/// The point of weights 1 - u - v, u, v, and a bound on how far it is from the exact triangle, per
/// axis.
/// source  [Pharr, Jakob, Humphreys 2023, section 6.8.5]. Their third weight has no error; ours, 1
///         - u - v, adds two roundings of 2^-25 of the first corner.
EK_FN v3 triangle_point(v3 p0, v3 p1, v3 p2, vf u, vf v, v3* p_error) {
  const v3 a = scale3(p0, (1.0f - u) - v);
  const v3 b = scale3(p1, u);
  const v3 c = scale3(p2, v);
  const float gamma_7 = (7.0f * 0x1p-24f) / (1.0f - 7.0f * 0x1p-24f);
  *p_error = add3(scale3(add3(add3(abs3(a), abs3(b)), abs3(c)), (vf)(gamma_7)), scale3(abs3(p0), (vf)(0x1p-24f)));
  return add3(add3(a, b), c);
}

/// p, moved on one axis towards the origin of the ray.
EK_FN vf moved_back(vf p, vf error, vf travelled) {
  return p - copysign_f(min_f(2.0f * error, 0.5f * abs_f(travelled)), travelled);
}

typedef struct {
  v3 p;        // world, metres
  v3 p_error;  // bound of its error per axis
  v3 n_geom;   // unit, to the front side
} Surface;

/// The point of a hit.
/// u, v       the hit's weights of p1 and p2
/// travelled  from the ray's origin to the hit, along the ray
// The point is moved back by twice its error, because u and v have errors too, but by half of the
// way at most. Rounding could otherwise put it beyond a wall that crosses this triangle and that
// the ray has not reached, and rays that leave from there would see the other side of that wall.
// Each weight is 2^-20 at least, which moves the point by a millionth of the triangle. Closer to an
// edge than that, rounding could put it beyond the wall that meets the triangle there, and closed
// boxes would leak.
EK_FN Surface surface_at(TriangleLanes t, vf u, vf v, v3 travelled) {
  const vf least = (vf)(0x1p-20f);
  u = max_f(u, least);
  v = max_f(v, least);
  const vf excess = max_f((u + v) - (1.0f - least), (vf)(0.0f));
  const vi from_u = u > v;
  u = from_u ? u - excess : u;
  v = from_u ? v : v - excess;
  v3 error;
  const v3 p = triangle_point(t.p0, t.p1, t.p2, u, v, &error);
  Surface s;
  s.p = V3(moved_back(p.x, error.x, travelled.x), moved_back(p.y, error.y, travelled.y),
           moved_back(p.z, error.z, travelled.z));
  // Includes 2^-24 of p, a seventh of `error`, for the rounding of the move.
  s.p_error = scale3(error, (vf)(3.25f));
  s.n_geom = t.n;
  return s;
}

// x moved by one float in the direction of `step`'s sign; not if that is zero or x too small to
// matter.
EK_FN vf next_float_towards(vf x, vf step) {
  const vu bits = AS_U(x);
  const vi outward = ((bits ^ AS_U(step)) & 0x80000000u) == 0u;
  const vi moves = (step != 0.0f) & ((bits & 0x7fffffffu) > 0x00800000u);
  const vu moved = outward ? bits + 1u : bits - 1u;
  return AS_F(moves ? moved : bits);
}

/// Origin of a ray that leaves `p` towards w (of any length): on w's side of the triangle, however
/// p was rounded. Every ray that leaves a surface starts here; no constant is in it, so a scene
/// scaled by 2^k gives the same picture.
/// source  [Pharr, Jakob, Humphreys 2023, section 6.8.6]
EK_FN v3 offset_ray_origin(v3 p, v3 p_error, v3 n_geom, v3 w) {
  const vf distance = dot3(abs3(n_geom), p_error);
  const v3 offset = scale3(n_geom, dot3(w, n_geom) < 0.0f ? -distance : distance);
  return V3(next_float_towards(p.x + offset.x, offset.x), next_float_towards(p.y + offset.y, offset.y),
            next_float_towards(p.z + offset.z, offset.z));
}

#endif
