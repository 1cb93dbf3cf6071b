// SPDX-License-Identifier: Apache-2.0
// Samples of emissive triangles that move while the shutter is open (EK_HAS_moving_surface), at the
// sample's time, with the density that hits on them have (surface/motion.h). Lights without extent
// move in lights/punctual.h.
#ifndef EK_MOVING_LIGHT_H
#define EK_MOVING_LIGHT_H
#include "lights/light.h"
#include "surface/motion.h"

#if EK_HAS_moving_surface
/// Moves samples of emissive triangles to where these are at `time`.
EK_FN LightSample moved_light_sample(SceneData scene, LightSample s, vf time) {
  if (!EK_HAS_area) return s;
  const vi is_triangle = !(s.is_distant | s.is_punctual | s.is_shape);
  const vu triangle = is_triangle ? s.triangle : (vu)(0u);
  PoseSpan span = pose_span(scene, triangle, time);
  span.moves = span.moves & is_triangle;
  if (!ANY(span.moves)) return s;
  vf area_ratio;
  const TriangleLanes t = moved_corners(scene, span, load_triangle(scene.triangles, resting_triangle(span, triangle)), &area_ratio);
  v3 p_error;
  const v3 p = triangle_point(t.p0, t.p1, t.p2, s.b1, s.b2, &p_error);
  s.p = select3(span.moves, p, s.p);
  s.p_error = select3(span.moves, p_error, s.p_error);
  // The normal of hits, so that both densities agree.
  s.n = select3(span.moves, accurate_triangle_normal(t.p0, t.p1, t.p2), s.n);
  // A triangle without area at this time is not sampled.
  s.pdf = span.moves ? (area_ratio < EK_INFINITY ? s.pdf * area_ratio : (vf)(0.0f)) : s.pdf;
  return s;
}
#endif

#endif
