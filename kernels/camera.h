// SPDX-License-Identifier: Apache-2.0
// Rays through the film: a pinhole's, or the parallel ones of an orthographic camera (EK_HAS_orthographic).
#ifndef EK_CAMERA_H
#define EK_CAMERA_H
#include "math.h"

typedef struct { v3 origin, dir; } CameraRay;  // world; dir: unit

/// x, y  pixel; u, v  place in it, from its upper left corner: [0, 1]^2, or beyond it with a wide filter
EK_FN CameraRay camera_ray(constant Frame* frame, vf x, vf y, vf u, vf v) {
  const v3 dx = splat3(frame->camera_x), dy = splat3(frame->camera_y);
  const v3 corner = splat3(EK_HAS_orthographic ? frame->camera_origin : frame->camera_corner);
  const v3 pixel_corner = add3(corner, add3(scale3(dx, x), scale3(dy, y)));
  const v3 film_point = add3(pixel_corner, add3(scale3(dx, u), scale3(dy, v)));
  CameraRay ray;
  ray.origin = EK_HAS_orthographic ? film_point : splat3(frame->camera_origin);
  ray.dir = EK_HAS_orthographic ? splat3(frame->camera_corner) : normalize3(film_point);
  return ray;
}

#endif
