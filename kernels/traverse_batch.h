// SPDX-License-Identifier: Apache-2.0
// Many rays, each on its own way through the `bvh8` layout, one step of each in turn: for rays that have nothing in
// common. A step has no branch and does not depend on the step before it, which belongs to another ray, so the processor
// works on several at once, and the next node of a ray can be fetched while the others move. Needs permutation and
// compression of registers; EK_HAS_BATCH says whether this processor has them.
#ifndef EK_TRAVERSE_BATCH_H
#define EK_TRAVERSE_BATCH_H
#include "traverse_bvh8.h"

#if defined(__AVX512VL__) && EK_BUILTIN(__builtin_ia32_permvarsf256) && EK_BUILTIN(__builtin_ia32_permvarsi256) && \
    EK_BUILTIN(__builtin_ia32_compresssi256_mask) && EK_BUILTIN(__builtin_prefetch)
#define EK_HAS_BATCH 1

#define BATCH_DONE 0xffffffffu             // below the last entry of a stack; has the leaf bit, but is no block
#define BATCH_STACK (EK_STACK_SIZE + 9)    // eight entries are written at a time

EK_FN void batch_prefetch(Geometry geometry, uint child) {
  global const char* node = (global const char*)geometry.nodes + (size_t)child * 256;
  global const char* block = (global const char*)geometry.leaves + (size_t)(child & ~BVH8_LEAF) * 320;
  global const char* p = child & BVH8_LEAF ? block : node;
  __builtin_prefetch(p);
  __builtin_prefetch(p + 64);
  __builtin_prefetch(p + 128);
  __builtin_prefetch(p + 192);
  __builtin_prefetch(p + (child & BVH8_LEAF ? 256 : 192));
}

// Hits of a step on triangles that rays may pass: the rays' questions about them are answered together, in full vectors.
typedef struct {
  float u[8 * EK_ROWS] EK_ROWS_ALIGNED, v[8 * EK_ROWS] EK_ROWS_ALIGNED, t[8 * EK_ROWS];
  uint triangle[8 * EK_ROWS] EK_ROWS_ALIGNED, key[8 * EK_ROWS] EK_ROWS_ALIGNED, index[8 * EK_ROWS] EK_ROWS_ALIGNED;
  uchar row[8 * EK_ROWS];
} BatchQuestions;

// Tests the block that each ray of `rows` stands at, current[row], and leaves in `hits` what traverse_batch leaves.
EK_FN void batch_blocks(Geometry geometry, const RayTable* rays, const uchar* rows, uint count, const uint* current,
                        const int any_hit, HitTable* hits) {
  BatchQuestions questions;
  uint asked = 0;
  for (uint i = 0; i < count; ++i) {
    const uint row = rows[i];
    const RayOne ray = ray_pick(rays, row);
    const uint z = 8u * (uint)ray.axis, x = z == 16u ? 0u : z + 8u, y = x == 16u ? 0u : x + 8u;
    Hit hit = {hits->t[row], hits->u[row], hits->v[row], hits->triangle[row]};
    global const float* block = (global const float*)geometry.leaves + (size_t)(current[row] & ~BVH8_LEAF) * 80;
    const TriangleHit_block found = bvh8_found(block, &ray, x, y, z);
    uint bits = any_hit ? mask_bits8(found.hit & (found.t < hit.t)) : mask_bits8(found.hit & (found.t <= hit.t));
    if (bits == 0) continue;
    float t[8] __attribute__((aligned(32))), u[8] __attribute__((aligned(32))), v[8] __attribute__((aligned(32)));
    *(float8*)t = found.t;
    *(float8*)u = found.u;
    *(float8*)v = found.v;
    const uint before = asked;
    do {
      const uint k = lowest_bit(bits);
      bits &= bits - 1;
      const uint triangle = as_uint(block[72 + k]);
      if (!any_hit & !is_closer(&hit, t[k], triangle)) continue;
      if (may_be_passed(geometry.scene, triangle)) {
        questions.u[asked] = u[k];
        questions.v[asked] = v[k];
        questions.t[asked] = t[k];
        questions.triangle[asked] = triangle;
#define EK_RAY_WORD(name) questions.name[asked] = ray.name;
        EK_RAY_WORDS(EK_RAY_WORD)
#undef EK_RAY_WORD
        questions.row[asked++] = (uchar)row;
      } else {
        hit.t = t[k];
        hit.u = u[k];
        hit.v = v[k];
        hit.triangle = triangle;
        if (any_hit) break;
      }
    } while (bits != 0);
    if (any_hit & (hit.triangle != EK_NO_HIT)) {
      hits->triangle[row] = 0;
      asked = before;
      continue;
    }
    hits->t[row] = hit.t;
    hits->u[row] = hit.u;
    hits->v[row] = hit.v;
    hits->triangle[row] = hit.triangle;
  }
  for (uint i = asked; i % EK_WIDTH != 0; ++i) {
    questions.u[i] = questions.v[i] = 0.0f;
    questions.triangle[i] = questions.key[i] = questions.index[i] = 0u;
  }
  for (uint first = 0; first < asked; first += EK_WIDTH) {
    const OpacityKey key = {*(const vu*)(questions.key + first), *(const vu*)(questions.index + first)};
    const vi passed = passes(geometry.scene, *(const vu*)(questions.triangle + first), *(const vf*)(questions.u + first),
                             *(const vf*)(questions.v + first), key);
    for (uint bits = mask_bits(!passed & ((vu)(first) + LANE_INDEX < (vu)(asked))); bits != 0; bits &= bits - 1) {
      const uint i = first + lowest_bit(bits), row = questions.row[i];
      const Hit hit = {hits->t[row], hits->u[row], hits->v[row], hits->triangle[row]};
      if (any_hit) {
        hits->triangle[row] = 0;
      } else if (is_closer(&hit, questions.t[i], questions.triangle[i])) {
        hits->t[row] = questions.t[i];
        hits->u[row] = questions.u[i];
        hits->v[row] = questions.v[i];
        hits->triangle[row] = questions.triangle[i];
      }
    }
  }
}

// The rays of `rows` (count of them). hits->t: where each ray ends. An any-hit query sets hits->triangle to 0 where something was
// found.
EK_FN void traverse_batch(Geometry geometry, const RayTable* rays, const uchar* rows, uint count, const int any_hit,
                          HitTable* hits) {
  uint stack[EK_ROWS][BATCH_STACK], current[EK_ROWS], top[EK_ROWS];
  uint near[EK_ROWS][3], octant[EK_ROWS];
  uchar at_node[EK_ROWS], at_leaf[EK_ROWS];
  uint node_count = 0, leaf_count = 0;
  for (uint i = 0; i < count; ++i) {
    const uint row = rows[i];
    const uint x = rays->rx[row] < 0.0f, y = rays->ry[row] < 0.0f, z = rays->rz[row] < 0.0f;
    near[row][0] = 8u * x;
    near[row][1] = 16u + 8u * y;
    near[row][2] = 32u + 8u * z;
    octant[row] = 3u * (x + 2u * y + 4u * z);
    stack[row][0] = BATCH_DONE;
    top[row] = 1;
    current[row] = 0;
    at_node[node_count++] = (uchar)row;
  }
  while (node_count | leaf_count) {
    uint still = 0;
    for (uint i = 0; i < node_count; ++i) {
      const uint row = at_node[i];
      global const float* node = (global const float*)geometry.nodes + (size_t)current[row] * 64;
      const uint x = near[row][0], y = near[row][1], z = near[row][2];
      const float8 begin_x = (bvh8_load(node + x) - rays->nx[row]) * rays->rx[row];
      const float8 begin_y = (bvh8_load(node + y) - rays->ny[row]) * rays->ry[row];
      const float8 begin_z = (bvh8_load(node + z) - rays->nz[row]) * rays->rz[row];
      const float8 end_x = (bvh8_load(node + (x ^ 8u)) - rays->fx[row]) * rays->rx[row];
      const float8 end_y = (bvh8_load(node + (y ^ 8u)) - rays->fy[row]) * rays->ry[row];
      const float8 end_z = (bvh8_load(node + (z ^ 8u)) - rays->fz[row]) * rays->rz[row];
      float8 begin = shape_max_block(shape_max_block(begin_x, begin_y), shape_max_block(begin_z, (float8)(0.0f)));
      float8 end = shape_min_block(shape_min_block(end_x, end_y), shape_min_block(end_z, (float8)(hits->t[row])));
      int8 children = *(global const int8*)(node + 48);
      if (!any_hit) {
        // Farthest first, by the order that the builder stored for this octant.
        const int8 order = as_int8(*(global const uint8*)(node + 56) >> octant[row]);
        begin = __builtin_ia32_permvarsf256(begin, order);
        end = __builtin_ia32_permvarsf256(end, order);
        children = __builtin_ia32_permvarsi256(children, order);
      }
      const uint bits = mask_bits8(begin <= end);
      const int8 kept = __builtin_ia32_compresssi256_mask(children, children, (uchar)bits);
      const uint at = top[row];
      vstore8(as_uint8(kept), 0, stack[row] + at);
      const uint last = at + (uint)popcount(bits) - 1u;
      const uint next = stack[row][last];
      top[row] = last;
      current[row] = next;
      batch_prefetch(geometry, next);
      at_leaf[leaf_count] = (uchar)row;
      leaf_count += (next >> 31) & (next != BATCH_DONE);
      at_node[still] = (uchar)row;
      still += 1u - (next >> 31);
    }
    node_count = still;
    uint waiting = 0;
    if (EK_HAS_opacity) batch_blocks(geometry, rays, at_leaf, leaf_count, current, any_hit, hits);
    for (uint i = 0; i < leaf_count; ++i) {
      const uint row = at_leaf[i];
      const RayOne ray = ray_pick(rays, row);
      const uint z = 8u * (uint)ray.axis, x = z == 16u ? 0u : z + 8u, y = x == 16u ? 0u : x + 8u;
      Hit hit = {hits->t[row], hits->u[row], hits->v[row], hits->triangle[row]};
      global const float* block = (global const float*)geometry.leaves + (size_t)(current[row] & ~BVH8_LEAF) * 80;
      // With opacity the blocks are tested already; without, one after the other is faster.
      if (EK_HAS_opacity ? any_hit && hit.triangle != EK_NO_HIT : bvh8_block(geometry, block, &ray, x, y, z, any_hit, &hit)) {
        hits->triangle[row] = 0;
        continue;
      }
      hits->t[row] = hit.t;
      hits->u[row] = hit.u;
      hits->v[row] = hit.v;
      hits->triangle[row] = hit.triangle;
      const uint last = top[row] - 1u, next = stack[row][last];
      top[row] = last;
      current[row] = next;
      batch_prefetch(geometry, next);
      at_leaf[waiting] = (uchar)row;
      waiting += (next >> 31) & (next != BATCH_DONE);
      at_node[node_count] = (uchar)row;
      node_count += 1u - (next >> 31);
    }
    leaf_count = waiting;
  }
}

#else
#define EK_HAS_BATCH 0
EK_FN void traverse_batch(Geometry geometry, const RayTable* rays, const uchar* rows, uint count, const int any_hit,
                          HitTable* hits) {}
#endif

#endif
