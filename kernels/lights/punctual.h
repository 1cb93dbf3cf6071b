// SPDX-License-Identifier: Apache-2.0
// Attenuation of lights without extent [KHR_lights_punctual]. No ray can meet them.
#ifndef EK_LIGHT_PUNCTUAL_H
#define EK_LIGHT_PUNCTUAL_H
#include "lanes/math.h"

/// Inverse square with the recommended window, 1 / m^2: max(1 - (d / range)^4, 0) / d^2.
/// distance2  squared, > 0
/// range2     squared range, infinite where there is none
/// source  [KHR_lights_punctual, "Range Property"]
EK_FN vf punctual_falloff(vf distance2, vf range2) {
  const vf ratio2 = distance2 / range2;
  return max_f(1.0f - ratio2 * ratio2, (vf)(0.0f)) / distance2;
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

#endif
