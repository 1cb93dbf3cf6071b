// SPDX-License-Identifier: Apache-2.0
// Triangles that move while the shutter is open (EK_HAS_moving_surface).
//
// The shutter's time has some equal steps. Of each triangle that moves there is a record for each
// pose, at the ends of the steps: corners, and with them normals and tangents. Between two poses a
// corner goes straight, and this file alone says where it is. So rays, shading and light sampling
// find the same bits of it, and so do triangles that share it. Every coordinate stays between those
// of the two poses, however it is rounded: the box around the corners of all poses holds the
// triangle at any time, and the interval rule (traverse/ray.h) needs no more.
//   motion  word 0: number of steps; word 1: place of the word of triangle 0, behind which lie
//           those of the others: 0 if it stands still, else 1 + its first record among the poses;
//           words from 2 on: bit i is 1 if triangle i moves, so that those which do not, of many,
//           need few words
// A record of a pose is that of the triangle at rest, with other corners, and twice the area at
// rest as the x of its normal.
#ifndef EK_MOTION_H
#define EK_MOTION_H
#include "lanes/pose_step.h"
#include "surface/attributes.h"
#include "surface/instance.h"

#if EK_HAS_moving_surface
// Coordinates on the way from a to b = a + way, of any number of corners at once. share: of the
// way, [0, EK_MOST_OF_STEP] No rounding takes them past b. With u = 2^-24 the difference and its
// product with the share are each at most 1 + u times too large, and (1 - 4u) (1 + u)^2 < 1. So the
// product is at most b - a, and what a sum of at most b rounds to is at most b.
#define EK_MOVED_BY(F, name) \
  EK_FN F name(F a, F way, F share) { return a + way * share; }
EK_MOVED_BY(float, moved_by_one)
EK_MOVED_BY(float8, moved_by_8)
EK_MOVED_BY(float16, moved_by_16)
EK_MOVED_BY(vf, moved_by)
#undef EK_MOVED_BY
EK_FN float moved_one(float a, float b, float share) { return moved_by_one(a, b - a, share); }
EK_FN vf moved(vf a, vf b, vf share) { return moved_by(a, b - a, share); }
EK_FN v3 moved3(v3 a, v3 b, vf share) { return V3(moved(a.x, b.x, share), moved(a.y, b.y, share), moved(a.z, b.z, share)); }

/// Where triangles are between two poses.
typedef struct {
  vi moves;   // mask: the triangle moves
  vu before;  // record of the pose before, some valid one where it does not; that of the pose after follows
  vf share;   // of the way between the two
} PoseSpan;

EK_FN PoseSpan pose_span(SceneData scene, vu triangle, vf time) {
  PoseSpan span = {(gather_u(scene.motion, (triangle >> 5) + 2u) >> (triangle & 31u) & 1u) != 0u, (vu)(0u), (vf)(0.0f)};
  if (ANY(span.moves)) {
    const vu step = step_of(scene.motion[0], time, &span.share);
    const vu first = gather_u(scene.motion + scene.motion[1], span.moves ? triangle : (vu)(0u));
    span.before = span.moves ? first - 1u + step : (vu)(0u);
  }
  return span;
}

/// Twice the area of a triangle; see triangle_normal() for the scaling.
EK_FN vf twice_area(v3 p0, v3 p1, v3 p2) {
  const v3 n = cross3(sub3(p1, p0), sub3(p2, p0));
  const vf size = max_component(abs3(n));
  const v3 scaled = scale3(n, inverse_power_of_two(size));
  return sqrt_f(dot3(scaled, scaled)) * AS_F(AS_U(size) & 0x7f800000u);
}

/// The triangles of a span in place of those of `t`, of which those that move are not read; without
/// their normals.
EK_FN TriangleLanes moved_corners(SceneData scene, PoseSpan span, TriangleLanes t, vf* area_ratio) {
  const TriangleLanes a = load_triangle(scene.pose_triangles, span.before);
  const TriangleLanes b = load_triangle(scene.pose_triangles, span.before + 1u);
  t.p0 = select3(span.moves, moved3(a.p0, b.p0, span.share), t.p0);
  t.p1 = select3(span.moves, moved3(a.p1, b.p1, span.share), t.p1);
  t.p2 = select3(span.moves, moved3(a.p2, b.p2, span.share), t.p2);
  t.material = span.moves ? a.material : t.material;
  t.light_pdf_m2 = span.moves ? a.light_pdf_m2 : t.light_pdf_m2;
  t.node = span.moves ? a.node : t.node;
  t.flags = span.moves ? a.flags : t.flags;
  // Densities on the area are those of the triangle at rest.
  *area_ratio = span.moves ? div_f(a.n.x, twice_area(t.p0, t.p1, t.p2)) : (vf)(1.0f);
  return t;
}

/// The triangle of each lane whose record at rest is read: not of those that move.
EK_FN vu resting_triangle(PoseSpan span, vu triangle) { return span.moves ? (vu)(0u) : triangle; }

/// Triangles at the time of a span.
EK_FN TriangleLanes moved_triangle(SceneData scene, PoseSpan span, TriangleLanes t) {
  vf area_ratio;
  t = moved_corners(scene, span, t, &area_ratio);
  t.n = select3(span.moves, accurate_triangle_normal(t.p0, t.p1, t.p2), t.n);
  t.light_pdf_m2 = t.light_pdf_m2 * area_ratio;
  return t;
}

/// Attributes with the normal and the tangent at the time of a span; the rest does not move.
EK_FN HitAttributes moved_attributes(SceneData scene, PoseSpan span, vf u, vf v, HitAttributes at) {
  if (EK_HAS_vertex_normal) {
    const TriangleNormalsLanes a = load_triangle_normals(scene.pose_normals, span.before);
    const TriangleNormalsLanes b = load_triangle_normals(scene.pose_normals, span.before + 1u);
    const v3 n = interpolate3(moved3(a.n0, b.n0, span.share), moved3(a.n1, b.n1, span.share),
                              moved3(a.n2, b.n2, span.share), u, v);
    at.normal = select3(span.moves, n, at.normal);
  }
  if (EK_HAS_tangent) {
    const TriangleTangentsLanes a = load_triangle_tangents(scene.pose_tangents, span.before);
    const TriangleTangentsLanes b = load_triangle_tangents(scene.pose_tangents, span.before + 1u);
    const v3 t = interpolate3(moved3(a.t0, b.t0, span.share), moved3(a.t1, b.t1, span.share),
                              moved3(a.t2, b.t2, span.share), u, v);
    at.tangent = select3(span.moves, t, at.tangent);
  }
  return at;
}
#endif

#endif
