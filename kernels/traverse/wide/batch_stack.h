// SPDX-License-Identifier: Apache-2.0
// The stacks of the rays of a batch (batch.h).
#ifndef EK_BATCH_STACK_H
#define EK_BATCH_STACK_H
#include "traverse/wide/wide.h"

#if EK_WIDTH > 1
#ifndef BATCH_SLOTS
#define BATCH_SLOTS 64
#endif
#define BATCH_DONE WIDE_NOTHING                           // below the last entry of a stack
#define BATCH_LIST (BATCH_SLOTS + EK_WIDTH)               // whole vectors are written
#define BATCH_STACK (EK_STACK_SIZE + EK_NODE_WIDTH + 1u)  // whole vectors are written

// The stacks of all slots: children still to be visited, and (for closest hits only) where the
// ray's interval in them begins.
typedef struct {
  uint child[BATCH_SLOTS * BATCH_STACK];
  float begin[BATCH_SLOTS * BATCH_STACK];
} BatchStack;

// Pushes the children of a node that the ray meets, the one to visit first last; returns the new
// size. They are pushed from far to near, in the order that the builder stored for the ray's
// octant. Any-hit queries take them as they are stored, smallest first, because the largest is the
// likeliest to be hit.
EK_FN uint batch_push(Geometry geometry, BatchStack* stack, uint size, global const float* node, const RayOne* ray, const int any_hit) {
  global const uint* list = (global const uint*)(node + 6u * EK_NODE_WIDTH);
  const wf begin = wide_begin(geometry, node, ray), end = wide_end(geometry, node, ray);
  wu children = begin <= end ? *(global const wu*)list : (wu)(0u);  // 0 is never a child
  const wu order = any_hit ? (wu)(0u) : *(global const wu*)(list + EK_NODE_WIDTH) >> ray->order;
  if (!any_hit) children = wide_permute(children, order);
  const uint bits = wide_bits(children != 0u);
  wide_append(stack->child + size, children, bits);
  if (!any_hit) wide_append((uint*)stack->begin + size, wide_permute(wide_words(begin), order), bits);
  return size + (uint)popcount(bits);
}

// Drops the entries of the stack above `base` that begin behind the ray's end; returns the new
// size.
EK_FN uint batch_cull(BatchStack* stack, uint base, uint size, float end) {
  uint kept = base + 1u, at = kept;
  do {
    const wu children = *(const wu_unaligned*)(stack->child + at), begins = *(const wu_unaligned*)(stack->begin + at);
    const uint rest = min(size - at, EK_NODE_WIDTH);
    const uint bits = wide_bits(wide_floats(begins) <= (wf)(end)) & ((1u << rest) - 1u);
    wide_append(stack->child + kept, children, bits);
    wide_append((uint*)stack->begin + kept, begins, bits);
    kept += (uint)popcount(bits);
    at += EK_NODE_WIDTH;
  } while (at < size);
  return kept;
}
#endif

#endif
