// SPDX-License-Identifier: Apache-2.0
// The number of shadow rays per vertex: one, unless the host asks for more.
#ifndef EK_LIGHT_SAMPLES_H
#define EK_LIGHT_SAMPLES_H
#ifndef EK_LIGHT_SAMPLES
#define EK_LIGHT_SAMPLES 1
#endif
// Odd. Multiples of it, added to a path's key, give each light sample random numbers of its own.
#define EK_LIGHT_SAMPLE_KEY 0x632be5abu
#endif
