// SPDX-License-Identifier: Apache-2.0
// Many rays, each on its own way through a tree of wide nodes, one step of each in turn: for rays that have nothing in common.
//   - BATCH_SLOTS rays are on their way; where one is done the next takes its place.
//   - A step at a node has no branch and does not depend on the step before it, which belongs to another ray, so the processor
//     works on several at once, and the next node of a ray can be fetched while the others move.
//   - At a block, the cheap first question of the triangle test is asked of its eight triangles. What is left of all rays is
//     collected, and tested in lanes of one ray and one triangle each.
// Children are put on the stack by batch_push, in one of three ways by what this processor has.
#ifndef EK_TRAVERSE_BATCH_H
#define EK_TRAVERSE_BATCH_H
#include "traverse_wide.h"

#if EK_WIDTH > 1

#ifndef BATCH_SLOTS
#define BATCH_SLOTS 64
#endif
#define BATCH_DONE 0xffffffffu                             // below the last entry of a stack; has the leaf bit, but is no block
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
#include "compress_table.h"
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

// Rays on their way: rows of the table, by what they stand at.
typedef struct {
  uchar at_node[BATCH_SLOTS], at_leaf[BATCH_SLOTS], done[BATCH_SLOTS], asked[BATCH_SLOTS];
  uchar bits[BATCH_SLOTS];  // of the asked: which triangles of the block
} BatchLists;
// How many of each; apart, so that they stay in registers.
typedef struct {
  uint node, leaf, done, asked;
} BatchCounts;

// Ray `row` goes on to `next` if `goes` is 1 (not 0), without a branch.
EK_FN void batch_go(Geometry geometry, BatchLists* lists, BatchCounts* counts, RayOne* ray, uint row, uint top, uint next, uint goes) {
  ray->top = top;
  ray->current = next;
  wide_prefetch(geometry, next);
  const uint leaf = next >> 31, done = next == BATCH_DONE ? 1u : 0u;
  lists->at_node[counts->node] = (uchar)row;
  counts->node += goes & ~leaf;
  lists->at_leaf[counts->leaf] = (uchar)row;
  counts->leaf += goes & (leaf - done);
  lists->done[counts->done] = (uchar)row;
  counts->done += goes & done;
}

// What passed the first questions: `triangle` may be hit by ray `row`.
typedef struct {
  uint row[8 * BATCH_SLOTS + EK_WIDTH], triangle[8 * BATCH_SLOTS + EK_WIDTH];
} BatchCandidates;

// Tests EK_WIDTH candidates, the first `count` of which count, and leaves in `rays` and `hits` what traverse_batch leaves.
EK_FN void batch_resolve(Geometry geometry, RayOne* rays, const uint* rows, const uint* triangles, uint count, const int any_hit,
                         HitTable* hits) {
  Rec rec;
#define BATCH_ROW(vector, lane, offset) rec.w##vector = *(const vf*)((const float*)(rays + rows[0x##lane]) + 16 + offset);
  EK_REC_ROWS(BATCH_ROW)
#undef BATCH_ROW
  rec = rec_transposed(rec);
  Rec record;
#define BATCH_ROW(vector, lane, offset) \
  record.w##vector = *(global const vf*)((global const float*)(geometry.scene.triangles + triangles[0x##lane]) + offset);
  EK_REC_ROWS(BATCH_ROW)
#undef BATCH_ROW
  record = rec_transposed(record);
  RayLanes ray;
  ray.p_ox = rec.w0; ray.p_oy = rec.w1; ray.p_oz = rec.w2; ray.sx = rec.w3; ray.sy = rec.w4;
  ray.p_rx = rec.w5; ray.p_ry = rec.w6; ray.p_rz = rec.w7; ray.p_nx = rec.w8; ray.p_ny = rec.w9;
  ray.p_fx = rec.wa; ray.p_fy = rec.wb; ray.reach = rec.wc;
  const vi z_is_x = AS_U(rec.wf) == 0u, z_is_y = AS_U(rec.wf) == 8u;
  const v3 a = permute3(V3(record.w0, record.w1, record.w2), z_is_x, z_is_y),
           b = permute3(V3(record.w3, record.w4, record.w5), z_is_x, z_is_y),
           c = permute3(V3(record.w6, record.w7, record.w8), z_is_x, z_is_y);
  const Corners_lanes corners = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};
  TriangleHit_lanes found = triangle_hit_lanes(&ray, corners);
#if EK_HAS_opacity
  const vi ask = found.hit & (LANE_INDEX < (vu)(count)) & ((AS_U(record.wf) & (vu)(EK_TRIANGLE_PASSABLE)) != 0u);
  if (mask_bits(ask) != 0) {
    uint key[EK_WIDTH] EK_ROWS_ALIGNED, index[EK_WIDTH] EK_ROWS_ALIGNED;
    for (uint lane = 0; lane < EK_WIDTH; ++lane) {
      key[lane] = rays[rows[lane]].key;
      index[lane] = rays[rows[lane]].index;
    }
    const OpacityKey keys = {*(const vu*)key, *(const vu*)index};
    found.hit = found.hit & !(ask & passes(geometry.scene, *(const vu_unaligned*)triangles, found.u, found.v, keys));
  }
#endif
  float t[EK_WIDTH] EK_ROWS_ALIGNED, u[EK_WIDTH] EK_ROWS_ALIGNED, v[EK_WIDTH] EK_ROWS_ALIGNED;
  *(vf*)t = found.t;
  *(vf*)u = found.u;
  *(vf*)v = found.v;
  const uint hit = mask_bits(found.hit);
  for (uint lane = 0; lane < count; ++lane) {
    const uint row = rows[lane], triangle = triangles[lane], is_hit = hit >> lane & 1u;
    if (any_hit) {
      hits->triangle[row] = is_hit & (t[lane] < rays[row].t ? 1u : 0u) ? 0u : hits->triangle[row];
    } else {
      const uint last = hits->triangle[row];
      const float end = rays[row].t;
      const int closer = (int)is_hit & ((t[lane] < end) | ((t[lane] == end) & (triangle < last)));
      rays[row].t = closer ? t[lane] : end;
      hits->u[row] = closer ? u[lane] : hits->u[row];
      hits->v[row] = closer ? v[lane] : hits->v[row];
      hits->triangle[row] = closer ? triangle : last;
    }
  }
}

// Tests what the blocks of the asked rays have left, and sends these rays on.
EK_FN void batch_answer(Geometry geometry, RayOne* rays, BatchStack* stack, const uchar* slots, BatchLists* lists,
                        BatchCounts* counts, const int any_hit, HitTable* hits) {
  BatchCandidates candidates;
  uint count = 0;
  for (uint i = 0; i < counts->asked; ++i) {
    const uint row = lists->asked[i];
    global const uint* triangles = (global const uint*)wide_block(geometry, rays[row].current) + 72;
    uint bits = lists->bits[i];
    do {
      candidates.row[count] = row;
      candidates.triangle[count++] = triangles[lowest_bit(bits)];
      bits &= bits - 1u;
    } while (bits != 0);
  }
  for (uint i = count; i % EK_WIDTH != 0; ++i) {
    candidates.row[i] = candidates.row[0];
    candidates.triangle[i] = candidates.triangle[0];
  }
  for (uint first = 0; first < count; first += EK_WIDTH)
    batch_resolve(geometry, rays, candidates.row + first, candidates.triangle + first, min(count - first, (uint)EK_WIDTH),
                  any_hit, hits);
  for (uint i = 0; i < counts->asked; ++i) {
    const uint row = lists->asked[i], base = slots[row] * BATCH_STACK;
    RayOne* ray = rays + row;
    uint top = ray->top;
    if (any_hit)
      top = hits->triangle[row] != EK_NO_HIT ? base + 1u : top;
    else
      top = batch_cull(stack, base, top, ray->t);
    batch_go(geometry, lists, counts, ray, row, top - 1u, stack->child[top - 1u], 1u);
  }
  counts->asked = 0;
}

// The rays of `rows` (count of them). hits->t: where each ray ends. An any-hit query sets hits->triangle to 0 where something was
// found.
EK_FN void traverse_batch(Geometry geometry, RayOne* rays, const uchar* rows, uint count, const int any_hit, HitTable* hits) {
  BatchStack stack;
  BatchLists lists;
  uchar slots[EK_ROWS];
  uint opened = min(count, (uint)BATCH_SLOTS);
  for (uint i = 0; i < opened; ++i) {
    slots[rows[i]] = (uchar)i;
    stack.child[i * BATCH_STACK] = BATCH_DONE;
    rays[rows[i]].top = i * BATCH_STACK + 1u;
    lists.at_node[i] = rows[i];
  }
  BatchCounts counts = {opened, 0, 0, 0};
  while (counts.node | counts.leaf | counts.asked) {
    const uint node_count = counts.node;
    counts.node = 0;
    for (uint i = 0; i < node_count; ++i) {
      const uint row = lists.at_node[i];
      RayOne* ray = rays + row;
      global const float* node = wide_node(geometry, ray->current);
      const uint top = batch_push(&stack, ray->top, node, wide_begin(node, ray), wide_end(node, ray), ray, any_hit) - 1u;
      batch_go(geometry, &lists, &counts, ray, row, top, stack.child[top], 1u);
    }
    const uint leaf_count = counts.leaf;
    counts.leaf = 0;
    for (uint i = 0; i < leaf_count; ++i) {
      const uint row = lists.at_leaf[i];
      RayOne* ray = rays + row;
      const uint bits = wide_candidates(wide_block(geometry, ray->current), ray), some = bits != 0 ? 1u : 0u;
      lists.asked[counts.asked] = (uchar)row;
      lists.bits[counts.asked] = (uchar)bits;
      counts.asked += some;
      const uint block = ray->current, top = ray->top - 1u;
      batch_go(geometry, &lists, &counts, ray, row, top + some, some ? block : stack.child[top], 1u - some);
    }
    if (counts.asked >= EK_WIDTH || (counts.asked != 0 && counts.node + counts.leaf < BATCH_SLOTS / 4))
      batch_answer(geometry, rays, &stack, slots, &lists, &counts, any_hit, hits);
    for (uint i = 0; i < counts.done; ++i) {
      const uint old = lists.done[i];
      hits->t[old] = rays[old].t;
      if (opened == count) continue;
      const uint row = rows[opened++];
      slots[row] = slots[old];
      rays[row].top = slots[old] * BATCH_STACK + 1u;
      lists.at_node[counts.node++] = (uchar)row;
    }
    counts.done = 0;
  }
}

#endif
#endif
