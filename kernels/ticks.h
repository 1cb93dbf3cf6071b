// SPDX-License-Identifier: Apache-2.0
// The processor's cycle counter, where it has one that any program may read: for the profile alone, never for a picture.
#ifndef EK_TICKS_H
#define EK_TICKS_H
#include "simd.h"

// EK_TICKS: the host says that programs of this processor may read its counter (on some, the instruction is an error).
// Constant rate, and the same on all cores, on processors of the last ten years.
EK_FN ulong ticks_now(void) {
#if defined(EK_TICKS) && EK_TICKS && EK_BUILTIN(__builtin_readcyclecounter)
  return __builtin_readcyclecounter();
#else
  return 0;
#endif
}

EK_FN void ticks_store(global uint* words, ulong ticks) {
  words[0] = (uint)ticks;
  words[1] = (uint)(ticks >> 32);
}

#endif
