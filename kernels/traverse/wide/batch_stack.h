// SPDX-License-Identifier: Apache-2.0
// What waits for each ray of a batch (traverse/wide/batch.h).
// Children are put on the stack by batch_push, in one of three ways by what this processor has.
#ifndef EK_BATCH_STACK_H
#define EK_BATCH_STACK_H
#include "traverse/wide/wide.h"

#if EK_WIDTH > 1
#ifndef BATCH_SLOTS
#define BATCH_SLOTS 64
#endif
#define BATCH_DONE 0xffffffffu                             // below the last entry of a stack; has the leaf bit, but is no block
#define BATCH_LIST (BATCH_SLOTS + EK_WIDTH)                // whole vectors are written
#define BATCH_STACK (EK_STACK_SIZE + EK_NODE_WIDTH + 1u)   // whole vectors are written

typedef wu __attribute__((aligned(4))) wu_unaligned;

#if EK_LAYOUT_bvh16 && defined(__AVX512F__) && EK_BUILTIN(__builtin_ia32_permvarsi512) && \
    EK_BUILTIN(__builtin_ia32_compresssi512_mask)
#define BATCH_PERMUTE(v, order) as_uint16(__builtin_ia32_permvarsi512(as_int16(v), as_int16(order)))
#define BATCH_COMPRESS(v, bits) as_uint16(__builtin_ia32_compresssi512_mask(as_int16(v), as_int16(v), (ushort)(bits)))
#elif !EK_LAYOUT_bvh16 && defined(__AVX2__) && EK_BUILTIN(__builtin_ia32_permvarsi256)
#define BATCH_PERMUTE(v, order) as_uint8(__builtin_ia32_permvarsi256(as_int8(v), as_int8(order)))
#if defined(__AVX512VL__) && EK_BUILTIN(__builtin_ia32_compresssi256_mask)
#define BATCH_COMPRESS(v, bits) as_uint8(__builtin_ia32_compresssi256_mask(as_int8(v), as_int8(v), (uchar)(bits)))
#else
#include "lanes/compress_table.h"
#define BATCH_COMPRESS(v, bits) BATCH_PERMUTE(v, convert_uint8(compress_order(bits)))
#endif
#endif

// Children that wait, of all slots, and where the ray's interval in them begins (closest hits only).
typedef struct {
  uint child[BATCH_SLOTS * BATCH_STACK];
  float begin[BATCH_SLOTS * BATCH_STACK];
} BatchStack;

// Puts the children of a node that the ray meets on the stack, the one to try first last. returns the new top.
EK_FN uint batch_push(BatchStack* stack, uint top, global const float* node, wf begin, wf end, const RayOne* ray,
                      const int any_hit) {
  global const uint* list = (global const uint*)(node + 6u * EK_NODE_WIDTH);
  global const uint* orders = list + EK_NODE_WIDTH;
  wu children = begin <= end ? *(global const wu*)list : (wu)(0u);  // no child is 0
  // Farthest first, by the order that the builder stored for this octant; any-hit queries take them as they lie, because the
  // largest is the likeliest.
#ifdef BATCH_COMPRESS
  const wu order = any_hit ? (wu)(0u) : *(global const wu*)orders >> ray->order;
  if (!any_hit) children = BATCH_PERMUTE(children, order);
  const uint bits = wide_bits(children != 0u);
  *(wu_unaligned*)(stack->child + top) = BATCH_COMPRESS(children, bits);
  if (!any_hit) *(wu_unaligned*)(stack->begin + top) = BATCH_COMPRESS(BATCH_PERMUTE(wide_words(begin), order), bits);
  return top + (uint)popcount(bits);
#else
  uint met[EK_NODE_WIDTH] __attribute__((aligned(64)));
  float begins[EK_NODE_WIDTH] __attribute__((aligned(64)));
  *(wu*)met = children;
  *(wf*)begins = begin;
  for (uint i = 0; i < EK_NODE_WIDTH; ++i) {
    const uint k = any_hit ? i : orders[i] >> ray->order & (EK_NODE_WIDTH - 1u);
    stack->child[top] = met[k];
    if (!any_hit) stack->begin[top] = begins[k];
    top += met[k] != 0u ? 1u : 0u;
  }
  return top;
#endif
}

// Drops from the stack above `base` what begins behind the ray's end. returns the new top.
EK_FN uint batch_cull(BatchStack* stack, uint base, uint top, float end) {
  uint kept = base + 1u;
#ifdef BATCH_COMPRESS
  uint at = kept;
  do {
    const wu children = *(const wu_unaligned*)(stack->child + at), begins = *(const wu_unaligned*)(stack->begin + at);
    const uint rest = min(top - at, EK_NODE_WIDTH);
    const uint bits = wide_bits(wide_floats(begins) <= (wf)(end)) & ((1u << rest) - 1u);
    *(wu_unaligned*)(stack->child + kept) = BATCH_COMPRESS(children, bits);
    *(wu_unaligned*)(stack->begin + kept) = BATCH_COMPRESS(begins, bits);
    kept += (uint)popcount(bits);
    at += EK_NODE_WIDTH;
  } while (at < top);
#else
  for (uint at = kept; at < top; ++at) {
    stack->child[kept] = stack->child[at];
    stack->begin[kept] = stack->begin[at];
    kept += stack->begin[at] <= end ? 1u : 0u;
  }
#endif
  return kept;
}
#endif

#endif
