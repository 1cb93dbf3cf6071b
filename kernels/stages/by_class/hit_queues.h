// SPDX-License-Identifier: Apache-2.0
// Hits by shading class (SHADING_*, records.h) on devices that launch each stage. The registers
// that a kernel takes decide how many work-items a GPU holds at a time, and a kernel that shades
// every kind of surface takes as many as glass does, though most hits are of flat Lambert walls. So
// where the scene has surfaces of several classes, stage sort_hits puts each hit into the queue of
// its class, and each class has a stage of its own in place of `shade`, in whose kernel the code of
// the others is left out (SceneData.absent_classes). This changes no result, because each path is
// shaded independently.
//   queue_hits  EK_CHUNK entries for each class of the scene, in the order of their numbers
#ifndef EK_HIT_QUEUES_H
#define EK_HIT_QUEUES_H
#include "stages/hit_walk.h"

#if !EK_CHUNKED
/// The first entry of the queue of class k.
EK_FN uint hit_queue_begin(uint k) { return (uint)popcount(EK_CLASSES_HERE & ((1 << k) - 1)) * EK_CHUNK; }

/// The numbers of this depth's hits of each class.
EK_FN global uint* hit_counts(global uint* counts, uint depth) { return counts_of_depth(counts, depth) + EK_DEPTH_HITS; }
#endif

#endif
