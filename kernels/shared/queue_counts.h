// SPDX-License-Identifier: Apache-2.0
// The words of buffer `counts` on devices that launch each stage. Four come first (stages/wavefront.h); then two for each of
// the depths shaded last, depth d in the place d mod EK_COUNT_DEPTHS: its paths, and its shadow rays once the next depth is
// shaded. So the host may launch several depths before it reads the counts of all of them.
#ifndef EK_SHARED_QUEUE_COUNTS_H
#define EK_SHARED_QUEUE_COUNTS_H

#define EK_COUNT_DEPTHS 32
#define EK_COUNT_WORDS (4 + 2 * EK_COUNT_DEPTHS)

#endif
