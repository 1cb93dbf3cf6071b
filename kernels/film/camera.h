// SPDX-License-Identifier: Apache-2.0
// Rays through the film: a pinhole's, those of a thin lens (EK_HAS_lens), the parallel ones of an
// orthographic camera (EK_HAS_orthographic), or all around (EK_HAS_panorama). With
// EK_HAS_camera_motion each ray has a time, and the camera stands where it is then.
#ifndef EK_CAMERA_H
#define EK_CAMERA_H
#include "lanes/math.h"
#include "lanes/pose_step.h"
#include "lanes/sampler.h"
#include "lanes/warp.h"

typedef struct { v3 origin, dir; } CameraRay;  // world; dir: unit

typedef struct {
  vf x, y;  // pixel
  vf u, v;  // place in it, from its upper left corner: [0, 1]^2, or beyond with a wide filter
} FilmPoint;

// CameraPose: where the camera stands. EK_OF_CAMERA(camera, vector): one of the vectors of Frame
// that say so. EK_INVERSE_FOCUS(camera): 1 / how far ahead things are sharp, 1 / metres.
#if EK_HAS_camera_motion
#define EK_CAMERA_ARGUMENTS , global const float *camera_poses
#define EK_CAMERA_DATA , camera_poses

typedef struct {
  v3 camera_origin, camera_x, camera_y, camera_corner, lens_x, lens_y;
  vf inverse_focus;
} CameraPose;
#define EK_OF_CAMERA(camera, vector) ((camera).vector)
#define EK_INVERSE_FOCUS(camera) ((camera).inverse_focus)

EK_FN CameraPose still_camera(constant Frame* frame) {
  const CameraPose pose = {splat3(frame->camera_origin), splat3(frame->camera_x), splat3(frame->camera_y),
                           splat3(frame->camera_corner), splat3(frame->lens_x),   splat3(frame->lens_y),
                           (vf)(frame->lens_x.w)};
  return pose;
}

EK_FN vf camera_word(global const float* poses, vu pose, uint which, vf share) {
  const vu at = pose * (uint)EK_CAMERA_POSE_WORDS + which;
  const vf a = gather_f(poses, at), b = gather_f(poses, at + (uint)EK_CAMERA_POSE_WORDS);
  return a + (b - a) * share;
}
EK_FN v3 camera_vector(global const float* poses, vu pose, uint which, vf share) {
  return V3(camera_word(poses, pose, 4u * which, share), camera_word(poses, pose, 4u * which + 1u, share),
            camera_word(poses, pose, 4u * which + 2u, share));
}

/// The camera at a time in [0, 1) of the shutter's.
/// poses  EK_CAMERA_POSE_WORDS for each of frame->pose_steps + 1: the vectors of CameraPose as
///        float4
// Between two poses each vector goes straight. Where the camera turns, the steps are so short that
// this is less than a pixel off (host/gltf/animation/shutter_poses.cpp).
EK_FN CameraPose moving_camera(constant Frame* frame, global const float* poses, vf time) {
  vf share;
  const vu step = step_of(frame->pose_steps, time, &share);
  CameraPose pose;
  pose.camera_origin = camera_vector(poses, step, 0u, share);
  pose.camera_x = camera_vector(poses, step, 1u, share);
  pose.camera_y = camera_vector(poses, step, 2u, share);
  pose.camera_corner = camera_vector(poses, step, 3u, share);
  pose.lens_x = camera_vector(poses, step, 4u, share);
  pose.lens_y = camera_vector(poses, step, 5u, share);
  pose.inverse_focus = camera_word(poses, step, 4u * 4u + 3u, share);  // beside lens_x
  return pose;
}
#else
#define EK_CAMERA_ARGUMENTS
#define EK_CAMERA_DATA

// The vectors of a camera that stands still are read from Frame where they are used: with a copy of
// all of them Intel's compiler makes stage `generate` for 16 lanes instead of 32.
typedef constant Frame* CameraPose;
#define EK_OF_CAMERA(camera, vector) splat3((camera)->vector)
#define EK_INVERSE_FOCUS(camera) ((vf)((camera)->lens_x.w))
EK_FN CameraPose still_camera(constant Frame* frame) { return frame; }
#endif

/// A ray of the equirectangular panorama, as environment maps are. x, y: place on the film, pixels
EK_FN CameraRay panorama_ray(constant Frame* frame, CameraPose camera, vf x, vf y) {
  vf sin_azimuth, cos_azimuth, sin_polar, cos_polar;
  sincos_2pi(x * frame->camera_x.w - 0.5f, &sin_azimuth, &cos_azimuth);
  sincos_2pi(0.5f * y * frame->camera_y.w, &sin_polar, &cos_polar);
  CameraRay ray;
  ray.origin = EK_OF_CAMERA(camera, camera_origin);
  const v3 right = EK_OF_CAMERA(camera, camera_x), up = EK_OF_CAMERA(camera, camera_y);
  const v3 back = EK_OF_CAMERA(camera, camera_corner);
  ray.dir = normalize3(sub3(add3(scale3(right, sin_azimuth * sin_polar), scale3(up, cos_polar)),
                            scale3(back, cos_azimuth * sin_polar)));
  return ray;
}

/// A point of the lens, relative to its middle, world.
EK_FN v3 lens_point(CameraPose camera, vf u, vf v) {
  const DiskPoint p = warp_disk(u, v);
  return add3(scale3(EK_OF_CAMERA(camera, lens_x), p.x), scale3(EK_OF_CAMERA(camera, lens_y), p.y));
}

/// Moves a pinhole's ray to a point of the lens, so that all rays of a film point meet where it is
// in focus.
/// film_point  from the middle of the lens, one metre ahead
EK_FN CameraRay lens_ray(CameraPose camera, v3 film_point, vf u, vf v) {
  const v3 on_lens = lens_point(camera, u, v);
  CameraRay ray;
  ray.origin = add3(EK_OF_CAMERA(camera, camera_origin), on_lens);
  ray.dir = normalize3(sub3(film_point, scale3(on_lens, EK_INVERSE_FOCUS(camera))));
  return ray;
}

/// The ray of a point of the film. key, index: of the sample, for its point on the lens
EK_FN CameraRay camera_ray(constant Frame* frame, CameraPose camera, FilmPoint at, vu key, vu index) {
  if (EK_HAS_panorama) return panorama_ray(frame, camera, at.x + at.u, at.y + at.v);
  const v3 dx = EK_OF_CAMERA(camera, camera_x), dy = EK_OF_CAMERA(camera, camera_y);
  const v3 corner = EK_HAS_orthographic ? EK_OF_CAMERA(camera, camera_origin) : EK_OF_CAMERA(camera, camera_corner);
  const v3 pixel_corner = add3(corner, add3(scale3(dx, at.x), scale3(dy, at.y)));
  const v3 film_point = add3(pixel_corner, add3(scale3(dx, at.u), scale3(dy, at.v)));
  if (EK_HAS_lens) {
    vf lens_u, lens_v;
    sample_2d(key, index, DIM_LENS, &lens_u, &lens_v);
    return lens_ray(camera, film_point, lens_u, lens_v);
  }
  CameraRay ray;
  ray.origin = EK_HAS_orthographic ? film_point : EK_OF_CAMERA(camera, camera_origin);
  ray.dir = EK_HAS_orthographic ? EK_OF_CAMERA(camera, camera_corner) : normalize3(film_point);
  return ray;
}

#endif
