// SPDX-License-Identifier: Apache-2.0
// Layer `motion`: how far what a camera ray meets goes on the picture until the next frame, in
// pixels, x to the right and y up, as compositors have it. Both ends are projected through the
// middle of the lens, as the cameras of the two frames stand; what moves while the shutter is open
// counts where it is at the time of the frame. Where a camera ray meets nothing, it is the motion
// of the environment, and 0 if there is none or the picture is transparent.
//   motion_cameras  behind the poses of a moving camera (film/camera.h): CAMERA_WORDS for this
//                   frame, and for the next
//   next_corners    a word for each triangle, which is 0 if it stands still until the next frame,
//                   else the place in this array of its nine coordinates there
#ifndef EK_MOTION_VECTOR_H
#define EK_MOTION_VECTOR_H
#include "film/slots.h"
#include "surface/attributes.h"

#if EK_HAS_motion
enum {
  CAMERA_eye = 0,
  CAMERA_right = 3,    // in pixels; of what is one metre ahead, if the camera is a perspective one
  CAMERA_up = 6,
  CAMERA_ahead = 9,    // 0 of an orthographic camera,
  CAMERA_flat = 12,    // which has 1 here
  CAMERA_WORDS = EK_MOTION_CAMERA_WORDS
};

// Points near the plane of the camera would be anywhere; what is further away than this is far
// outside of any picture.
#define EK_MOST_MOTION 65504.0f  // the largest half float

typedef struct {
  vf x, y;  // pixels from the middle of the picture
  vi seen;  // mask: it is in front of the camera
} FilmPlace;

EK_FN vf camera_dot(global const float* camera, uint row, v3 d) {
  return d.x * camera[row] + d.y * camera[row + 1] + d.z * camera[row + 2];
}

/// Where a point (w = 1), or what is infinitely far away in a direction (w = 0), is on the film.
EK_FN FilmPlace film_place(global const float* camera, v3 p, float w) {
  const v3 d = V3(p.x - w * camera[CAMERA_eye], p.y - w * camera[CAMERA_eye + 1], p.z - w * camera[CAMERA_eye + 2]);
  const vf ahead = camera_dot(camera, CAMERA_ahead, d) + w * camera[CAMERA_flat];
  FilmPlace place;
  place.seen = ahead > 0.0f;
  const vf by = place.seen ? ahead : (vf)(1.0f);
  place.x = div_f(camera_dot(camera, CAMERA_right, d), by);
  place.y = div_f(camera_dot(camera, CAMERA_up, d), by);
  return place;
}

EK_FN vf bounded_motion(vi seen, vf way) {
  way = way < EK_MOST_MOTION ? way : (vf)(EK_MOST_MOTION);
  way = way > -EK_MOST_MOTION ? way : (vf)(-EK_MOST_MOTION);
  return seen ? way : (vf)(0.0f);
}

/// What paths see, in this frame and in the next one.
typedef struct {
  vi live;         // mask of the lanes that have a path
  vu path;
  vf weight;       // by the pixel filter
  v3 now, next;    // points (w = 1), or directions (w = 0)
  float w;
} SeenMotion;

/// Writes the layer.
EK_FN void film_motion(constant Frame* frame, SceneData scene, FilmSlots film, const SeenMotion* seen) {
  const uint poses = EK_HAS_camera_motion ? frame->pose_steps + 1u : 0u;
  global const float* camera = scene.motion_cameras + poses * (uint)EK_CAMERA_POSE_WORDS;
  const FilmPlace a = film_place(camera, seen->now, seen->w), b = film_place(camera + CAMERA_WORDS, seen->next, seen->w);
  const vi ahead = a.seen & b.seen;
  film_set(film, SLOT_motion, seen->live, seen->path, bounded_motion(ahead, b.x - a.x) * seen->weight);
  film_set(film, SLOT_motion + 1, seen->live, seen->path, bounded_motion(ahead, b.y - a.y) * seen->weight);
}

EK_FN v3 next_corner(SceneData scene, vu at) {
  global const float* words = (global const float*)scene.next_corners;
  return V3(gather_f(words, at), gather_f(words, at + 1u), gather_f(words, at + 2u));
}

/// Puts the points of triangles in this frame and in the next one in the place of those of `seen`,
/// where they move. u, v: weights of the corners p1 and p2
EK_FN void follow_triangle(SceneData scene, vu triangle, vf u, vf v, SeenMotion* seen) {
  const vu record = seen->live ? gather_u(scene.next_corners, triangle) : (vu)(0u);
  const vi moves = record != 0u;
  if (!ANY(moves)) return;
  const TriangleLanes rest = load_triangle(scene.triangles, triangle);
  seen->now = select3(moves, interpolate3(rest.p0, rest.p1, rest.p2, u, v), seen->now);
  const v3 p0 = next_corner(scene, record), p1 = next_corner(scene, record + 3u), p2 = next_corner(scene, record + 6u);
  seen->next = select3(moves, interpolate3(p0, p1, p2, u, v), seen->next);
}
#endif

#endif
