// SPDX-License-Identifier: Apache-2.0
// Sizes of the memory probe: kernels/probe/canary.h and host/device/probes.cpp.
#ifndef EK_SHARED_CANARY_H
#define EK_SHARED_CANARY_H
#define EK_CANARY_WORDS 64      // of its result
#define EK_CANARY_RECORDS 4096u // of each of its buffers; a power of two
#endif
