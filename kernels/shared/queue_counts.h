// SPDX-License-Identifier: Apache-2.0
// The words of buffer `counts` on devices that launch each stage. Four come first
// (stages/wavefront.h); then eight for each of the depths shaded last, depth d in the place d mod
// EK_COUNT_DEPTHS: its paths, its shadow rays once the next depth is shaded, and its hits of each
// shading class where these have queues (stages/by_class/hit_queues.h). So the host may launch
// several depths before it reads the counts of all of them.
#ifndef EK_SHARED_QUEUE_COUNTS_H
#define EK_SHARED_QUEUE_COUNTS_H

#define EK_COUNT_DEPTHS 32
#define EK_DEPTH_WORDS 8
#define EK_DEPTH_HITS 4  // the first of the words for hits, which are cleared by one store of four
#define EK_COUNT_WORDS (4 + EK_DEPTH_WORDS * EK_COUNT_DEPTHS)

#endif
