// SPDX-License-Identifier: Apache-2.0
// Where a point of the scene is seen on the film: the inverse of camera.h, for light paths.
#ifndef EK_CAMERA_CONNECTION_H
#define EK_CAMERA_CONNECTION_H
#include "film/camera.h"

/// Density of the points that camera rays of all pixels meet: pixels^2 of the film per m^2 of a
/// surface across the ray.
/// dir       of the ray, unit
/// distance  from the camera, or from the point on its lens
EK_FN vf film_density_m2(constant Frame* frame, v3 dir, vf distance) {
  const vf density = (vf)(frame->film_normal.w);
  if (EK_HAS_orthographic) return density;
  const vf distance2 = distance * distance;
  if (EK_HAS_panorama) {
    const vf cos_polar = dot3(splat3(frame->camera_y), dir);
    const vf sin_polar = sqrt_f(max_f(1.0f - cos_polar * cos_polar, (vf)(0x1p-40f)));
    return div_f(density, distance2 * sin_polar);
  }
  // The film lies across the axis at the distance 1 / cosine along the ray, so its angle falls as
  // the cube of that.
  const vf cosine = dot3(splat3(frame->film_normal), dir);
  return div_f(density, distance2 * ((cosine * cosine) * cosine));
}

/// A point as the camera sees it.
typedef struct {
  vi in_front;   // mask: some ray of the camera goes there
  v3 eye;        // where that ray starts, world
  v3 dir;        // of the ray, unit
  vf distance;   // from eye to the point
  vf x, y;       // place on the film, pixels
} CameraView;

EK_FN CameraView panorama_view(constant Frame* frame, v3 p) {
  CameraView view;
  view.eye = splat3(frame->camera_origin);
  const v3 way = sub3(p, view.eye);
  view.distance = sqrt_f(dot3(way, way));
  view.dir = scale3(way, div_f((vf)(1.0f), view.distance));
  const vf right = dot3(splat3(frame->camera_x), view.dir), up = dot3(splat3(frame->camera_y), view.dir),
           back = dot3(splat3(frame->camera_corner), view.dir);
  view.x = div_f(atan2_turns(right, -back) + 0.5f, frame->camera_x.w);
  view.y = div_f(2.0f * atan2_turns(sqrt_f(right * right + back * back), up), frame->camera_y.w);
  view.in_front = view.distance > 0.0f;
  return view;
}

EK_FN CameraView parallel_view(constant Frame* frame, v3 p) {
  CameraView view;
  const v3 axis = splat3(frame->camera_corner), way = sub3(p, splat3(frame->camera_origin));
  view.distance = dot3(way, axis);
  view.dir = axis;
  view.eye = sub3(p, scale3(axis, view.distance));
  view.x = dot3(splat3(frame->film_dual_x), way) + frame->film_dual_x.w;
  view.y = dot3(splat3(frame->film_dual_y), way) + frame->film_dual_y.w;
  view.in_front = view.distance > 0.0f;
  return view;
}

/// key, index, depth: of the light path and its vertex, for the point on the lens
EK_FN CameraView camera_view(constant Frame* frame, v3 p, vu key, vu index, uint depth) {
  if (EK_HAS_panorama) return panorama_view(frame, p);
  if (EK_HAS_orthographic) return parallel_view(frame, p);
  CameraView view;
  view.eye = splat3(frame->camera_origin);
  v3 on_film = V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f));
  if (EK_HAS_lens) {
    vf u, v;
    sample_2d(key, index, bounce_dimension(depth, DIM_LIGHT), &u, &v);
    const v3 on_lens = lens_point(still_camera(frame), u, v);
    view.eye = add3(view.eye, on_lens);
    on_film = scale3(on_lens, (vf)(frame->lens_x.w));
  }
  const v3 way = sub3(p, view.eye);
  view.distance = sqrt_f(dot3(way, way));
  view.dir = scale3(way, div_f((vf)(1.0f), view.distance));
  const vf cosine = dot3(splat3(frame->film_normal), view.dir);
  // The rays of a film point meet where it is in focus, so from a point of the lens the film looks
  // moved.
  on_film = add3(on_film, scale3(view.dir, div_f((vf)(1.0f), cosine)));
  view.x = dot3(splat3(frame->film_dual_x), on_film) + frame->film_dual_x.w;
  view.y = dot3(splat3(frame->film_dual_y), on_film) + frame->film_dual_y.w;
  view.in_front = cosine > 0.0f;
  return view;
}

#endif
