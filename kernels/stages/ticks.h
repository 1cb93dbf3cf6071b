// SPDX-License-Identifier: Apache-2.0
// The processor's cycle counter, where it has one that any program may read: for the profile alone,
// never for a picture.
#ifndef EK_TICKS_H
#define EK_TICKS_H
#include "lanes/simd.h"

// EK_TICKS: the host says that programs of this processor may read its counter (on some, the
// instruction is an error). Constant rate, and the same on all cores: x86's on processors of the
// last ten years, ARM's virtual counter everywhere (its cycle counter is not for programs). 0 where
// there is none: stage_sampler.h.
EK_FN ulong ticks_now(void) {
#if defined(EK_TICKS) && EK_TICKS && defined(__x86_64__) && EK_BUILTIN(__builtin_readcyclecounter)
  return __builtin_readcyclecounter();
#elif defined(EK_TICKS) && EK_TICKS && defined(__aarch64__) && EK_BUILTIN(__builtin_arm_rsr64)
  return __builtin_arm_rsr64("cntvct_el0");
#else
  return 0;
#endif
}

EK_FN void ticks_store(global uint* words, ulong ticks) {
  words[0] = (uint)ticks;
  words[1] = (uint)(ticks >> 32);
}

#endif
