// SPDX-License-Identifier: Apache-2.0
// Lights without extent [KHR_lights_punctual], which no ray can meet: their attenuation, and where
// they are if they move.
#ifndef EK_LIGHT_PUNCTUAL_H
#define EK_LIGHT_PUNCTUAL_H
#include "lanes/math.h"
#include "lanes/pose_step.h"
#include "lanes/record_lanes.h"

// The poses of lights that move, as an argument of kernels and as a member of LightData.
#if EK_HAS_moving_light
#define EK_LIGHT_POSE_ARGUMENTS , global const Light *light_poses
#define EK_LIGHT_POSE_DATA , light_poses
#else
#define EK_LIGHT_POSE_ARGUMENTS
#define EK_LIGHT_POSE_DATA
#endif

/// Inverse square with the recommended window, 1 / m^2: max(1 - (d / range)^4, 0) / d^2.
/// distance2  squared, > 0
/// range2     squared range, infinite where there is none
/// source  [KHR_lights_punctual, "Range Property"]
EK_FN vf punctual_falloff(vf distance2, vf range2) {
  const vf ratio2 = div_f(distance2, range2);
  return div_f(max_f(1.0f - ratio2 * ratio2, (vf)(0.0f)), distance2);
}

/// Attenuation of a spot light between its cones.
/// cos_axis    between its axis and the direction away from it
/// cone_cos    of the outer cone; cone_scale  1 / max(0.001, cos inner - cos outer)
/// source  [KHR_lights_punctual, "Inner and Outer Cone Angles"]: clamp(cos * scale + offset)^2 with
///         offset = -cos outer * scale; as a difference, which is exact near the outer cone
EK_FN vf spot_falloff(vf cos_axis, vf cone_cos, vf cone_scale) {
  const vf angular = min_f(max_f((cos_axis - cone_cos) * cone_scale, (vf)(0.0f)), (vf)(1.0f));
  return angular * angular;
}

#if EK_HAS_moving_light
/// Lights without extent at a time of the shutter's. Between two poses they go straight, and their
/// axes turn.
/// poses  frame->pose_steps + 1 records of each that moves
/// moves  mask of those; `triangle` is 1 + their first record
EK_FN LightLanes moved_punctual(constant Frame* frame, global const Light* poses, LightLanes r, vi moves, vf time) {
  vf share;
  const vu step = step_of(frame->pose_steps, time, &share), before = moves ? r.triangle - 1u + step : (vu)(0u);
  const LightLanes a = load_light(poses, before), b = load_light(poses, before + 1u);
  r.p0 = select3(moves, add3(a.p0, scale3(sub3(b.p0, a.p0), share)), r.p0);
  const v3 axis = add3(a.p1, scale3(sub3(b.p1, a.p1), share));
  const vf length2 = dot3(axis, axis);
  // Opposite axes have no mean. A point light has no axis.
  const vi turns = moves & (length2 > 0x1p-20f);
  r.p1 = select3(turns, scale3(axis, div_f((vf)(1.0f), sqrt_f(length2))), r.p1);
  return r;
}
#endif

#endif
