// SPDX-License-Identifier: Apache-2.0
// Division and square root of kernels: they are called by these names instead of `/` and `sqrt`, but for constants, so that a device
// can have its own.
#ifndef EK_DIVISION_H
#define EK_DIVISION_H
#include "lanes/lanes.h"

#define div_f(a, b) ((a) / (b))
#define sqrt_f(x) sqrt(x)

#endif
