// SPDX-License-Identifier: Apache-2.0
// Rays through the film: a pinhole's, those of a thin lens (EK_HAS_lens), the parallel ones of an
// orthographic camera (EK_HAS_orthographic), or all around (EK_HAS_panorama).
#ifndef EK_CAMERA_H
#define EK_CAMERA_H
#include "lanes/math.h"
#include "lanes/sampler.h"
#include "lanes/warp.h"

typedef struct { v3 origin, dir; } CameraRay;  // world; dir: unit

typedef struct {
  vf x, y;  // pixel
  vf u, v;  // place in it, from its upper left corner: [0, 1]^2, or beyond with a wide filter
} FilmPoint;

/// A ray of the equirectangular panorama, as environment maps are. x, y: place on the film, pixels
EK_FN CameraRay panorama_ray(constant Frame* frame, vf x, vf y) {
  vf sin_azimuth, cos_azimuth, sin_polar, cos_polar;
  sincos_2pi(x * frame->camera_x.w - 0.5f, &sin_azimuth, &cos_azimuth);
  sincos_2pi(0.5f * y * frame->camera_y.w, &sin_polar, &cos_polar);
  const v3 right = splat3(frame->camera_x), up = splat3(frame->camera_y), back = splat3(frame->camera_corner);
  CameraRay ray;
  ray.origin = splat3(frame->camera_origin);
  ray.dir = normalize3(sub3(add3(scale3(right, sin_azimuth * sin_polar), scale3(up, cos_polar)),
                            scale3(back, cos_azimuth * sin_polar)));
  return ray;
}

/// A point of the lens, relative to its middle, world.
EK_FN v3 lens_point(constant Frame* frame, vf u, vf v) {
  const DiskPoint p = warp_disk(u, v);
  return add3(scale3(splat3(frame->lens_x), p.x), scale3(splat3(frame->lens_y), p.y));
}

/// Moves a pinhole's ray to a point of the lens, so that all rays of a film point meet where it is
// in focus.
/// film_point  from the middle of the lens, one metre ahead
EK_FN CameraRay lens_ray(constant Frame* frame, v3 film_point, vf u, vf v) {
  const v3 on_lens = lens_point(frame, u, v);
  CameraRay ray;
  ray.origin = add3(splat3(frame->camera_origin), on_lens);
  ray.dir = normalize3(sub3(film_point, scale3(on_lens, (vf)(frame->lens_x.w))));
  return ray;
}

/// The ray of a point of the film. key, index: of the sample, for its point on the lens
EK_FN CameraRay camera_ray(constant Frame* frame, FilmPoint at, vu key, vu index) {
  if (EK_HAS_panorama) return panorama_ray(frame, at.x + at.u, at.y + at.v);
  const v3 dx = splat3(frame->camera_x), dy = splat3(frame->camera_y);
  const v3 corner = splat3(EK_HAS_orthographic ? frame->camera_origin : frame->camera_corner);
  const v3 pixel_corner = add3(corner, add3(scale3(dx, at.x), scale3(dy, at.y)));
  const v3 film_point = add3(pixel_corner, add3(scale3(dx, at.u), scale3(dy, at.v)));
  if (EK_HAS_lens) {
    vf lens_u, lens_v;
    sample_2d(key, index, DIM_LENS, &lens_u, &lens_v);
    return lens_ray(frame, film_point, lens_u, lens_v);
  }
  CameraRay ray;
  ray.origin = EK_HAS_orthographic ? film_point : splat3(frame->camera_origin);
  ray.dir = EK_HAS_orthographic ? splat3(frame->camera_corner) : normalize3(film_point);
  return ray;
}

#endif
