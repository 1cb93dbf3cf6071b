// SPDX-License-Identifier: Apache-2.0
// The steps of the shutter's time, at whose ends whatever moves has a pose.
#ifndef EK_POSE_STEP_H
#define EK_POSE_STEP_H
#include "lanes/lanes.h"

// The largest share of a step: 1 - 2^-22, which moved_one() and its like (surface/motion.h) rely
// on.
#define EK_MOST_OF_STEP 0x1.fffff8p-1f

/// The step in which a time of [0, 1) lies. share: receives the part of the step that has passed,
/// [0, EK_MOST_OF_STEP]
EK_FN vu step_of(uint steps, vf time, vf* share) {
  const vf at = time * (vf)((float)steps);
  const vu whole = AS_U(TO_I(at)), last = (vu)(steps - 1u), step = whole < last ? whole : last;
  const vf passed = at - TO_F(AS_I(step)), most = (vf)(EK_MOST_OF_STEP);
  *share = passed < most ? passed : most;
  return step;
}

#endif
