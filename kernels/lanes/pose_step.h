// SPDX-License-Identifier: Apache-2.0
// The steps of the shutter's time, at whose ends whatever moves has a pose.
#ifndef EK_POSE_STEP_H
#define EK_POSE_STEP_H
#include "lanes/lanes.h"

/// The step in which a time of [0, 1) lies. share: receives the part of the step that has passed, [0, 1]
EK_FN vu step_of(uint steps, vf time, vf* share) {
  const vf at = time * (vf)((float)steps);
  const vu whole = AS_U(TO_I(at)), last = (vu)(steps - 1u), step = whole < last ? whole : last;
  *share = at - TO_F(AS_I(step));
  return step;
}

#endif
