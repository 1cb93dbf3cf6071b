// SPDX-License-Identifier: Apache-2.0
// The processor's cycle counter, where it has one that any program may read: for the profile alone,
// never for a picture.
#ifndef EK_TICKS_H
#define EK_TICKS_H
#include "lanes/simd.h"

/// Ticks of a counter of constant rate that is the same on all cores: x86's on processors of the
/// last ten years, and ARM's virtual counter on all (its cycle counter is not for programs). The
/// host sets EK_TICKS where programs may read it, since on some processors the instruction is an
/// error. Where there is none this returns 0, and the host samples stages instead
/// (stage_sampler.h).
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
