// SPDX-License-Identifier: Apache-2.0
// Traversal of the wide trees by many rays, each on its own way, one step of each in turn: for rays
// that have nothing in common.
//   - BATCH_SLOTS rays are on their way. When one is done, the next takes its place.
//   - A step at a node has no branch and does not depend on the step before it, which belongs to
//     another ray. So the processor works on several steps at once, and the next node of a ray is
//     fetched while the others move.
//   - At a leaf, the cheap pre-test (leaf8.h) rejects most of its eight triangles. The candidates
//     that all rays have left are collected and tested in lanes of one ray and one triangle each.
#ifndef EK_TRAVERSE_BATCH_H
#define EK_TRAVERSE_BATCH_H
#include "traverse/wide/batch_stack.h"
#include "traverse/wide/batch_test.h"

#if EK_WIDTH > 1

// Rays: the row of each in the table, the child (node, leaf or instance) that it is at, and the
// size of its stack.
typedef struct {
  uint row[BATCH_LIST], child[BATCH_LIST], stack_size[BATCH_LIST];
} BatchList;

// The rays in flight, in one list for each kind of thing that they are at. The arrays below have a
// word for each ray of a list:
// candidates, next   of `leaf`: bits of the triangles that the pre-test left, and the child on top
//                    of the ray's stack
// pretested_bits     of `pretested`: bits of the candidates that wait for the whole test
typedef struct {
  BatchList node, leaf, pretested, instance;
  uint candidates[BATCH_LIST], next[BATCH_LIST], pretested_bits[BATCH_LIST];
  uint done[BATCH_LIST];  // rows
} BatchLists;

// Lengths of the lists. They are not in BatchLists because they are to stay in registers.
typedef struct {
  uint node, leaf, pretested, instance, done;
} BatchCounts;

// The state that all functions of a batch share. stack_base: the place where the stack of each
// row's ray begins in `stack`.
typedef struct {
  Geometry geometry;
  RayOne* rays;
  HitTable* hits;
  BatchStack* stack;
  uint* stack_base;
  BatchLists* lists;
  BatchCandidates* candidates;
} Batch;

EK_FN vu batch_load(const uint* words, uint at) { return *(const vu_unaligned*)(words + at); }

EK_FN uint batch_append(BatchList* list, uint at, Packing lanes, vu row, vu child, vu stack_size) {
  append(list->row + at, lanes, row);
  append(list->child + at, lanes, child);
  append(list->stack_size + at, lanes, stack_size);
  return at + lanes.count;
}

// Puts the first `count` rays of `from` into the lists that their children say. `from` may be one
// of those lists if its own count is 0, because no list grows faster than `from` is read.
EK_FN void batch_distribute(BatchLists* lists, BatchCounts* counts, const BatchList* from, uint count) {
  for (uint i = 0; i < count; i += EK_WIDTH) {
    const vu row = batch_load(from->row, i), child = batch_load(from->child, i), size = batch_load(from->stack_size, i);
    const vi here = (vu)(i) + LANE_INDEX < (vu)(count), is_done = child == BATCH_DONE;
    vi is_leaf = AS_I(child) < 0;
    if (EK_HAS_instance) {
      const vi is_instance = ((child & (vu)(INSTANCE_CHILD)) == (vu)(INSTANCE_CHILD)) & !is_done;
      is_leaf = is_leaf & !is_instance;
      counts->instance = batch_append(&lists->instance, counts->instance, packing(here & is_instance), row, child, size);
    }
    const Packing done = packing(here & is_done);
    append(lists->done + counts->done, done, row);
    counts->done += done.count;
    counts->node = batch_append(&lists->node, counts->node, packing(here & (AS_I(child) >= 0)), row, child, size);
    counts->leaf = batch_append(&lists->leaf, counts->leaf, packing(here & is_leaf & !is_done), row, child, size);
  }
}

// All ones if the ray surely hits one of the triangles that are set in `certain`, else 0.
EK_FN uint batch_done(uint certain) { return 0u - (uint)(certain != 0u); }

// Notes what the pre-test says of ray i of those at leaves. done: all ones if an any-hit query of
// it is done, else 0. It is a mask, because the outcome cannot be predicted, and compilers make a
// branch of a truth value: shadow rays of scenes/window_room.gltf were a fifth slower.
EK_FN void batch_note(const Batch* b, uint i, uint candidates, uint done, const int any_hit) {
  const BatchList* leaf = &b->lists->leaf;
  const uint next = b->stack->child[leaf->stack_size[i] - 1u] | done;
  b->lists->candidates[i] = candidates & ~done;
  b->lists->next[i] = next;
  if (any_hit) b->hits->triangle[leaf->row[i]] &= ~done;
  wide_prefetch(b->geometry, wide_record(b->geometry, next, b->rays + leaf->row[i]));
}

EK_FN Leaf8Visit batch_visit(const Batch* b, uint i) {
  const BatchList* leaf = &b->lists->leaf;
  return leaf8_visit(b->geometry, leaf->child[i], b->rays + leaf->row[i]);
}

// Pre-tests the leaves that `count` rays are at.
EK_FN void batch_pretest(const Batch* b, uint count, const int any_hit) {
#if EK_LAYOUT_bvh16
  for (uint i = 0; i < count; i += 2u) {
    const uint j = min(i + 1u, count - 1u);  // an odd one at the end is paired with itself
    const Leaf8Visit first = batch_visit(b, i), second = batch_visit(b, j);
    uint certain;
    const uint candidates = leaf8_pretest_2(&first, &second, any_hit, &certain);
    batch_note(b, i, candidates & 0xffu, batch_done(certain & 0xffu), any_hit);
    batch_note(b, j, candidates >> 8, batch_done(certain >> 8), any_hit);
  }
#else
  for (uint i = 0; i < count; ++i) {
    const Leaf8Visit visit = batch_visit(b, i);
    uint certain;
    const uint candidates = leaf8_pretest(&visit, &visit, any_hit, &certain);
    batch_note(b, i, candidates, batch_done(certain), any_hit);
  }
#endif
}

// Parts the rays at leaves: those with candidates wait for the whole test, the others go on.
EK_FN void batch_part(BatchLists* lists, BatchCounts* counts) {
  const uint count = counts->leaf;
  uint kept = 0;
  BatchList* leaf = &lists->leaf;
  for (uint i = 0; i < count; i += EK_WIDTH) {
    const vu row = batch_load(leaf->row, i), size = batch_load(leaf->stack_size, i), bits = batch_load(lists->candidates, i),
             child = batch_load(leaf->child, i), next = batch_load(lists->next, i);
    const vi here = (vu)(i) + LANE_INDEX < (vu)(count), waits = bits != 0u;
    const Packing waiting = packing(here & waits);
    append(lists->pretested_bits + counts->pretested, waiting, bits);
    counts->pretested = batch_append(&lists->pretested, counts->pretested, waiting, row, child, size);
    kept = batch_append(leaf, kept, packing(here & !waits), row, next, size - 1u);
  }
  counts->leaf = 0;
  batch_distribute(lists, counts, leaf, kept);
}

// Collects the candidates of the pre-tested rays from `first` on.
EK_FN void batch_gather(const Batch* b, uint first, uint count) {
  BatchCandidates* candidates = b->candidates;
  for (uint i = first; i < count; ++i) {
    const uint child = b->lists->pretested.child[i], row = b->lists->pretested.row[i];
    const RayOne* ray = b->rays + row;
    global const float* leaf8 = wide_leaf8(b->geometry, wide_record(b->geometry, child, ray));
    global const uint* triangles = (global const uint*)leaf8 + LEAF8_TRIANGLES;
    uint bits = b->lists->pretested_bits[i];
    do {
      const uint k = lowest_bit(bits), triangle = triangles[k];
      candidates->row[candidates->count] = row;
#if EK_HAS_moving_surface
      candidates->record[candidates->count] = candidate_record(b->geometry, leaf8, k, ray);
#endif
      candidates->triangle[candidates->count++] = triangle;
      candidate_prefetch(b->geometry, candidates);
      bits &= bits - 1u;
    } while (bits != 0);
  }
}

// 1 if there are enough pre-tested rays to test their candidates now, or too few other rays to wait
// for more.
EK_FN int batch_should_test(const BatchCounts* counts) {
  return counts->pretested >= EK_WIDTH || (counts->pretested != 0 && counts->node + counts->leaf < BATCH_SLOTS / 4);
}

// Tests all candidates, and sends the pre-tested rays on.
EK_FN void batch_test(const Batch* b, BatchCounts* counts, const int any_hit) {
  BatchList* pretested = &b->lists->pretested;
  BatchCandidates* candidates = b->candidates;
  const uint count = candidates->count;
  for (uint i = count; i % EK_WIDTH != 0; ++i) {
    candidates->row[i] = candidates->row[0];
    candidates->triangle[i] = candidates->triangle[0];
#if EK_HAS_moving_surface
    candidates->record[i] = candidates->record[0];
#endif
  }
  for (uint first = 0; first < count; first += EK_WIDTH)
    test_candidates(b->geometry, b->rays, candidates, first, any_hit, b->hits);
  candidates->count = 0;
  for (uint i = 0; i < counts->pretested; ++i) {
    const uint row = pretested->row[i], base = b->stack_base[row];
    uint size = pretested->stack_size[i];
    if (any_hit)
      size = b->hits->triangle[row] != EK_NO_HIT ? base + 1u : size;
    else
      size = batch_cull(b->stack, base, size, b->rays[row].t);
    const uint next = b->stack->child[size - 1u];
    wide_prefetch(b->geometry, wide_record(b->geometry, next, b->rays + row));
    pretested->child[i] = next;
    pretested->stack_size[i] = size - 1u;
  }
  batch_distribute(b->lists, counts, pretested, counts->pretested);
  counts->pretested = 0;
}

// Takes the rays that are at an instance into the tree of its mesh, and those that leave one back
// to the world.
EK_FN void batch_instances(const Batch* b, BatchCounts* counts, const int any_hit) {
  BatchList* at = &b->lists->instance;
  uint rows[BATCH_LIST], instances[BATCH_LIST], entering = 0;
  for (uint i = 0; i < counts->instance; ++i) {
    const uint row = at->row[i], child = at->child[i], size = at->stack_size[i];
    if (child == INSTANCE_EXIT) {
      ray_exit(b->rays + row);
      at->child[i] = b->stack->child[size - 1u];
      at->stack_size[i] = size - 1u;
    } else {
      rows[entering] = row;
      instances[entering++] = child & ~INSTANCE_CHILD;
      b->stack->child[size] = INSTANCE_EXIT;
      if (!any_hit) b->stack->begin[size] = 0.0f;  // so that it is never culled
      at->child[i] = b->geometry.scene.instances[child & ~INSTANCE_CHILD].root;
      at->stack_size[i] = size + 1u;
    }
    wide_prefetch(b->geometry, at->child[i]);
  }
  for (uint i = entering; entering != 0 && i % EK_WIDTH != 0; ++i) {
    rows[i] = rows[entering - 1u];
    instances[i] = instances[entering - 1u];
  }
  for (uint first = 0; first < entering; first += EK_WIDTH)
    rays_enter(b->geometry.scene.instances, b->rays, rows + first, instances + first);
  const uint count = counts->instance;
  counts->instance = 0;
  batch_distribute(b->lists, counts, at, count);
}

// Stores where the rays that are done ended, and gives their slots to the next of the rows, of
// which *opened of `count` have begun.
EK_FN void batch_refill(const Batch* b, BatchCounts* counts, const ushort* rows, uint count, uint* opened, const int any_hit) {
  for (uint i = 0; i < counts->done; ++i) {
    const uint old = b->lists->done[i], base = b->stack_base[old];
    b->hits->t[old] = b->rays[old].t;
    if (EK_REPORTS_AT_ONCE && (!any_hit || b->hits->triangle[old] == EK_NO_HIT))
      report_given_up(b->geometry, b->hits->gave_up[old], b->hits->gave_up_surface[old], b->rays[old].t);
    if (*opened == count) continue;
    const uint row = rows[(*opened)++], at = counts->node++;
    b->stack_base[row] = base;
    b->lists->node.row[at] = row;
    b->lists->node.child[at] = 0;
    b->lists->node.stack_size[at] = base + 1u;
  }
  counts->done = 0;
}

// One step of each ray that is at a node: the children that it meets are pushed, and the first of
// them is next.
EK_FN void batch_nodes(const Batch* b, BatchCounts* counts, const int any_hit) {
  BatchList* list = &b->lists->node;
  const uint count = counts->node;
  for (uint i = 0; i < count; ++i) {
    const RayOne* ray = b->rays + list->row[i];
    global const float* node = wide_node(b->geometry, wide_record(b->geometry, list->child[i], ray));
    const uint size = batch_push(b->geometry, b->stack, list->stack_size[i], node, ray, any_hit) - 1u;
    const uint next = b->stack->child[size];
    wide_prefetch(b->geometry, wide_record(b->geometry, next, ray));
    list->child[i] = next;
    list->stack_size[i] = size;
  }
  counts->node = 0;
  batch_distribute(b->lists, counts, list, count);
}

// Traces the rays of `count` rows. hits->t: where each ray ends. An any-hit query sets
// hits->triangle to 0 where something was hit.
EK_FN void traverse_batch(Geometry geometry, RayOne* rays, const ushort* rows, uint count, const int any_hit, HitTable* hits) {
  BatchStack stack;
  BatchLists lists;
  BatchCandidates candidates;
  uint stack_base[EK_ROWS];
  const Batch b = {.geometry = geometry, .rays = rays, .hits = hits, .stack = &stack, .stack_base = stack_base, .lists = &lists,
                   .candidates = &candidates};
  candidates.count = 0;
  uint opened = min(count, (uint)BATCH_SLOTS);
  for (uint i = 0; i < opened; ++i) {
    const uint base = i * BATCH_STACK;
    stack_base[rows[i]] = base;
    stack.child[base] = BATCH_DONE;
    lists.node.row[i] = rows[i];
    lists.node.child[i] = 0;
    lists.node.stack_size[i] = base + 1u;
  }
  BatchCounts counts = {.node = opened};
  while (counts.node | counts.leaf | counts.pretested | counts.instance | counts.done) {
    batch_pretest(&b, counts.leaf, any_hit);
    const uint pretested = counts.pretested;
    batch_part(&lists, &counts);
    batch_gather(&b, pretested, counts.pretested);
    if (!EK_MEDIUM_TREE && batch_should_test(&counts)) batch_test(&b, &counts, any_hit);
    batch_refill(&b, &counts, rows, count, &opened, any_hit);
    batch_nodes(&b, &counts, any_hit);
    // In a tree larger than a core's caches the test comes after the nodes, so that the triangles
    // can be fetched meanwhile.
    if (EK_MEDIUM_TREE && batch_should_test(&counts)) batch_test(&b, &counts, any_hit);
    if (EK_HAS_instance && counts.instance != 0) batch_instances(&b, &counts, any_hit);
  }
}

#endif
#endif
