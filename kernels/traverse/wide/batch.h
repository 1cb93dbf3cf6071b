// SPDX-License-Identifier: Apache-2.0
// Many rays, each on its own way through a tree of wide nodes, one step of each in turn: for rays that have nothing in common.
//   - BATCH_SLOTS rays are on their way; where one is done the next takes its place.
//   - A step at a node has no branch and does not depend on the step before it, which belongs to another ray, so the processor
//     works on several at once, and the next node of a ray can be fetched while the others move.
//   - At a block, the cheap first question of the triangle test is asked of its eight triangles. What is left of all rays is
//     collected, and tested in lanes of one ray and one triangle each.
#ifndef EK_TRAVERSE_BATCH_H
#define EK_TRAVERSE_BATCH_H
#include "traverse/wide/batch_stack.h"

#if EK_WIDTH > 1

// Rays on their way: row of the table, the node or block that each stands at, and the top of its stack.
typedef struct {
  uint row[BATCH_LIST], child[BATCH_LIST], top[BATCH_LIST];
} BatchList;
// By what they stand at. asked: at a block of which `asked_bits` says which triangles are left to test. bits,
// popped: the same of the rays at a block, and what lies on top of their stacks.
typedef struct {
  BatchList node, leaf, asked;
  uint bits[BATCH_LIST], asked_bits[BATCH_LIST], popped[BATCH_LIST], done[BATCH_LIST];
#if EK_HAS_instance
  BatchList place;  // at one, or where a ray leaves it
#endif
} BatchLists;
// How many of each; apart, so that they stay in registers.
typedef struct {
  uint node, leaf, done, asked;
#if EK_HAS_instance
  uint place;
#endif
} BatchCounts;

EK_FN void batch_put(uint* words, uint at, vu x) { *(vu_unaligned*)(words + at) = x; }
EK_FN vu batch_get(const uint* words, uint at) { return *(const vu_unaligned*)(words + at); }

EK_FN uint batch_append(BatchList* list, uint at, Packing go, vu row, vu child, vu top) {
  batch_put(list->row, at, packed(go, row));
  batch_put(list->child, at, packed(go, child));
  batch_put(list->top, at, packed(go, top));
  return at + go.count;
}

// Puts the first `count` rays of `from` where they belong. The list may be one of those it writes, if its own count is 0.
EK_FN void batch_distribute(BatchLists* lists, BatchCounts* counts, const BatchList* from, uint count) {
#if EK_HAS_COMPRESS
  for (uint i = 0; i < count; i += EK_WIDTH) {
    const vu row = batch_get(from->row, i), child = batch_get(from->child, i), top = batch_get(from->top, i);
    const vi here = (vu)(i) + LANE_INDEX < (vu)(count), done = child == BATCH_DONE;
#if EK_HAS_instance
    const vi place = ((child & (vu)(INSTANCE_CHILD)) == (vu)(INSTANCE_CHILD)) & !done, leaf = (AS_I(child) < 0) & !place;
    counts->place = batch_append(&lists->place, counts->place, packing(here & place), row, child, top);
#else
    const vi leaf = AS_I(child) < 0;
#endif
    const Packing ends = packing(here & done);
    batch_put(lists->done, counts->done, packed(ends, row));
    counts->done += ends.count;
    counts->node = batch_append(&lists->node, counts->node, packing(here & (AS_I(child) >= 0)), row, child, top);
    counts->leaf = batch_append(&lists->leaf, counts->leaf, packing(here & leaf & !done), row, child, top);
  }
#else
  for (uint i = 0; i < count; ++i) {
    const uint row = from->row[i], child = from->child[i], top = from->top[i];
    const uint done = child == BATCH_DONE ? 1u : 0u;
#if EK_HAS_instance
    const uint place = is_instance_child(child) ? 1u - done : 0u, leaf = (child >> 31) - place;
    lists->place.row[counts->place] = row;
    lists->place.child[counts->place] = child;
    lists->place.top[counts->place] = top;
    counts->place += place;
#else
    const uint leaf = child >> 31;
#endif
    lists->done[counts->done] = row;
    counts->done += done;
    lists->node.row[counts->node] = row;
    lists->node.child[counts->node] = child;
    lists->node.top[counts->node] = top;
    counts->node += 1u - (child >> 31);
    lists->leaf.row[counts->leaf] = row;
    lists->leaf.child[counts->leaf] = child;
    lists->leaf.top[counts->leaf] = top;
    counts->leaf += leaf - done;
  }
#endif
}

// Asks the first questions at the blocks. A ray of an any-hit query that surely hits something is done.
EK_FN void batch_candidates(Geometry geometry, const RayOne* rays, const BatchStack* stack, BatchLists* lists, uint count,
                            const int any_hit, HitTable* hits) {
  const BatchList* leaf = &lists->leaf;
// Without branches: what comes cannot be foreseen. done: all ones, or 0.
#define BATCH_POP(i, candidates, done)                                     \
  lists->bits[i] = (candidates) & ~(done);                                 \
  lists->popped[i] = stack->child[leaf->top[i] - 1u] | (done);             \
  if (any_hit) hits->triangle[leaf->row[i]] &= ~(done);                    \
  wide_prefetch(geometry, lists->popped[i]);
#define BATCH_AT(i) wide_block(geometry, leaf->child[i]), rays + leaf->row[i]
#if EK_LAYOUT_bvh16
  for (uint i = 0; i < count; i += 2u) {
    const uint j = min(i + 1u, count - 1u);  // one that is left over goes beside itself
    uint sure;
    const uint bits = wide_candidates_2(geometry, BATCH_AT(i), BATCH_AT(j), any_hit, &sure);
    const uint done = 0u - (uint)((sure & 0xffu) != 0u), done_2 = 0u - (uint)(sure > 0xffu);
    BATCH_POP(i, bits & 0xffu, done)
    BATCH_POP(j, bits >> 8, done_2)
  }
#else
  for (uint i = 0; i < count; ++i) {
    uint sure;
    const uint bits = wide_candidates(geometry, BATCH_AT(i), any_hit, &sure);
    const uint done = 0u - (uint)(sure != 0u);
    BATCH_POP(i, bits, done)
  }
#endif
#undef BATCH_AT
#undef BATCH_POP
}

// The rays at blocks, by whether triangles are left to test: those are asked, the others go on.
EK_FN void batch_ask(BatchLists* lists, BatchCounts* counts) {
  const uint count = counts->leaf;
  uint kept = 0;
  BatchList* leaf = &lists->leaf;
#if EK_HAS_COMPRESS
  for (uint i = 0; i < count; i += EK_WIDTH) {
    const vu row = batch_get(leaf->row, i), top = batch_get(leaf->top, i), bits = batch_get(lists->bits, i),
             child = batch_get(leaf->child, i), popped = batch_get(lists->popped, i);
    const vi here = (vu)(i) + LANE_INDEX < (vu)(count), some = bits != 0u;
    const Packing asks = packing(here & some);
    batch_put(lists->asked_bits, counts->asked, packed(asks, bits));
    counts->asked = batch_append(&lists->asked, counts->asked, asks, row, child, top);
    kept = batch_append(leaf, kept, packing(here & !some), row, popped, top - 1u);
  }
#else
  for (uint i = 0; i < count; ++i) {
    const uint row = leaf->row[i], top = leaf->top[i], bits = lists->bits[i], some = bits != 0u ? 1u : 0u;
    lists->asked_bits[counts->asked] = bits;
    lists->asked.row[counts->asked] = row;
    lists->asked.child[counts->asked] = leaf->child[i];
    lists->asked.top[counts->asked] = top;
    counts->asked += some;
    leaf->row[kept] = row;
    leaf->child[kept] = lists->popped[i];
    leaf->top[kept] = top - 1u;
    kept += 1u - some;
  }
#endif
  counts->leaf = 0;
  batch_distribute(lists, counts, leaf, kept);
}

// What passed the first questions: `triangle` may be hit by ray `row`. Of all that are asked.
typedef struct {
  uint row[8 * BATCH_SLOTS + EK_WIDTH], triangle[8 * BATCH_SLOTS + EK_WIDTH], count;
} BatchCandidates;

#if EK_HAS_opacity
EK_FN OpacityKey batch_keys(const RayOne* rays, const uint* rows) {
  uint key[EK_WIDTH] EK_ROWS_ALIGNED, index[EK_WIDTH] EK_ROWS_ALIGNED;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) {
    key[lane] = rays[rows[lane]].key;
    index[lane] = rays[rows[lane]].index;
  }
  const OpacityKey keys = {*(const vu*)key, *(const vu*)index};
  return keys;
}
#endif

// Tests EK_WIDTH candidates, the first `count` of which count, and leaves in `rays` and `hits` what traverse_batch leaves.
EK_FN void batch_resolve(Geometry geometry, RayOne* rays, const uint* rows, const uint* triangles, uint count, const int any_hit,
                         HitTable* hits) {
  const RayTestLanes test = ray_test_lanes(rays, rows);
  Rec record_words;
#define BATCH_ROW(vector, lane, offset) \
  record_words.w##vector = *(global const vf*)((global const float*)(geometry.scene.triangles + triangles[0x##lane]) + offset);
  EK_REC_ROWS(BATCH_ROW)
#undef BATCH_ROW
  TriangleLanes record = triangle_lanes(rec_transposed(record_words));
#if EK_HAS_instance
  const vu instance = test.goal;
  const vi is_placed = instance != 0u;
  if (mask_bits(is_placed) != 0) {
    const Placing to_world =
        instance_placing(load_instance_matrix(geometry.scene.instances, is_placed ? instance - 1u : (vu)(0u)));
    record.p0 = select3(is_placed, placed_point(to_world, record.p0), record.p0);
    record.p1 = select3(is_placed, placed_point(to_world, record.p1), record.p1);
    record.p2 = select3(is_placed, placed_point(to_world, record.p2), record.p2);
  }
#endif
  RayLanes ray;
  ray.p_ox = test.p_o.x; ray.p_oy = test.p_o.y; ray.p_oz = test.p_o.z; ray.sx = test.sx; ray.sy = test.sy;
  ray.p_rx = test.p_r.x; ray.p_ry = test.p_r.y; ray.p_rz = test.p_r.z; ray.p_nx = test.p_nx; ray.p_ny = test.p_ny;
  ray.p_fx = test.p_fx; ray.p_fy = test.p_fy; ray.reach = test.reach;
  const vf end = test.t;
  const vi z_is_x = test.axis_z == 0u, z_is_y = test.axis_z == 8u;
  const v3 a = permute3(record.p0, z_is_x, z_is_y),
           b = permute3(record.p1, z_is_x, z_is_y),
           c = permute3(record.p2, z_is_x, z_is_y);
  const Corners_lanes corners = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};
#if EK_HAS_shape
  const vi is_shape = record.p2.x != record.p2.x;
  TriangleHit_lanes found = {(vi)(0), end, end, end};
  if (mask_bits(!is_shape) != 0) found = triangle_hit_lanes(&ray, corners);
#else
  TriangleHit_lanes found = triangle_hit_lanes(&ray, corners);
#endif
#if EK_HAS_opacity
  const vi ask = found.hit & (LANE_INDEX < (vu)(count)) & ((record.flags & (vu)(EK_TRIANGLE_ALPHA_TESTED)) != 0u);
  if (mask_bits(ask) != 0) {
    const OpacityKey keys = batch_keys(rays, rows);
    found.hit = found.hit & !(ask & alpha_test_rejects(geometry.scene, *(const vu_unaligned*)triangles, found.u, found.v, keys));
  }
#endif
#if EK_HAS_shape
  if (mask_bits(is_shape & (LANE_INDEX < (vu)(count))) != 0) {
    ray.axis = z_is_x ? (vf)(0.0f) : z_is_y ? (vf)(1.0f) : (vf)(2.0f);
#if EK_HAS_opacity
    ray.key = batch_keys(rays, rows);
#endif
    const ShapeInterval within = shape_interval_permuted(&ray, a, b);
    const vu number = is_shape ? AS_U(record.n.x) : (vu)(0u);
    const ShapeHit shape =
        shape_hit_within(geometry.scene, &ray, is_shape & (LANE_INDEX < (vu)(count)) & (within.begin <= within.end),
                         *(const vu_unaligned*)triangles, number, load_shape(geometry.scene.shapes, number), within, end);
#if EK_HAS_implicit
    if (mask_bits(shape.gave_up < EK_INFINITY) != 0) {
      float gave_up[EK_WIDTH] EK_ROWS_ALIGNED;
      uint surface[EK_WIDTH] EK_ROWS_ALIGNED;
      *(vf*)gave_up = shape.gave_up;
      *(vu*)surface = AS_U(record.n.x);
      for (uint lane = 0; lane < count; ++lane)
        keep_given_up(gave_up[lane], surface[lane], hits->gave_up + rows[lane], hits->gave_up_surface + rows[lane]);
    }
#endif
    found.hit = found.hit | (is_shape & shape.hit);
    found.t = is_shape ? shape.t : found.t;
    found.u = is_shape ? shape.part : found.u;
    found.v = is_shape ? (vf)(0.0f) : found.v;
  }
#endif
  const vi counts_here = found.hit & (LANE_INDEX < (vu)(count));
  uint bits = mask_bits(counts_here & (any_hit ? found.t < end : found.t <= end));
  if (any_hit) {
    for (; bits != 0; bits &= bits - 1u) hits->triangle[rows[lowest_bit(bits)]] = 0u;
    return;
  }
  float t[EK_WIDTH] EK_ROWS_ALIGNED, u[EK_WIDTH] EK_ROWS_ALIGNED, v[EK_WIDTH] EK_ROWS_ALIGNED;
  *(vf*)t = found.t;
  *(vf*)u = found.u;
  *(vf*)v = found.v;
#if EK_HAS_instance
  uint instances[EK_WIDTH] EK_ROWS_ALIGNED;
#if EK_HAS_shape
  *(vu*)instances = is_shape ? (vu)(INSTANCE_SHAPE) : instance;
#else
  *(vu*)instances = instance;
#endif
#endif
  for (; bits != 0; bits &= bits - 1u) {  // several may be of one ray
    const uint lane = lowest_bit(bits), row = rows[lane], triangle = triangles[lane], last = hits->triangle[row];
    const float now = rays[row].t;
#if EK_HAS_instance
    const int before = is_before(instances[lane], triangle, hits->instance[row], last);
#else
    const int before = triangle < last;
#endif
    const int closer = (t[lane] < now) | ((t[lane] == now) & before);
    rays[row].t = closer ? t[lane] : now;
    hits->u[row] = closer ? u[lane] : hits->u[row];
    hits->v[row] = closer ? v[lane] : hits->v[row];
    hits->triangle[row] = closer ? triangle : last;
#if EK_HAS_instance
    hits->instance[row] = closer ? instances[lane] : hits->instance[row];
#endif
  }
}

// Adds what the asked rays from `first` on have left to the candidates.
EK_FN void batch_gather(Geometry geometry, const BatchLists* lists, uint first, uint count, BatchCandidates* candidates) {
  for (uint i = first; i < count; ++i) {
    global const uint* triangles = (global const uint*)wide_block(geometry, lists->asked.child[i]) + 72;
    uint bits = lists->asked_bits[i];
    do {
      const uint triangle = triangles[lowest_bit(bits)];
      candidates->row[candidates->count] = lists->asked.row[i];
      candidates->triangle[candidates->count++] = triangle;
#if EK_MEDIUM_TREE && EK_BUILTIN(__builtin_prefetch)
      __builtin_prefetch(geometry.scene.triangles + triangle);
#endif
      bits &= bits - 1u;
    } while (bits != 0);
  }
}

// Tests the candidates, and sends the asked rays on. bases: of the rows' stacks.
EK_FN void batch_answer(Geometry geometry, RayOne* rays, BatchStack* stack, const uint* bases, BatchLists* lists,
                        BatchCounts* counts, BatchCandidates* candidates, const int any_hit, HitTable* hits) {
  BatchList* asked = &lists->asked;
  const uint count = candidates->count;
  for (uint i = count; i % EK_WIDTH != 0; ++i) {
    candidates->row[i] = candidates->row[0];
    candidates->triangle[i] = candidates->triangle[0];
  }
  for (uint first = 0; first < count; first += EK_WIDTH)
    batch_resolve(geometry, rays, candidates->row + first, candidates->triangle + first, min(count - first, (uint)EK_WIDTH),
                  any_hit, hits);
  candidates->count = 0;
  for (uint i = 0; i < counts->asked; ++i) {
    const uint row = asked->row[i], base = bases[row];
    uint top = asked->top[i];
    if (any_hit)
      top = hits->triangle[row] != EK_NO_HIT ? base + 1u : top;
    else
      top = batch_cull(stack, base, top, rays[row].t);
    const uint next = stack->child[top - 1u];
    wide_prefetch(geometry, next);
    asked->child[i] = next;
    asked->top[i] = top - 1u;
  }
  batch_distribute(lists, counts, asked, counts->asked);
  counts->asked = 0;
}

#if EK_HAS_instance
// Takes the rays that stand at a place into its mesh's tree, and those that leave one back to the world.
EK_FN void batch_place(Geometry geometry, RayOne* rays, BatchStack* stack, BatchLists* lists, BatchCounts* counts, const int any_hit) {
  BatchList* at = &lists->place;
  uint rows[BATCH_LIST], places[BATCH_LIST], entering = 0;
  for (uint i = 0; i < counts->place; ++i) {
    const uint row = at->row[i], child = at->child[i], top = at->top[i];
    if (child == INSTANCE_EXIT) {
      ray_exit(rays + row);
      at->child[i] = stack->child[top - 1u];
      at->top[i] = top - 1u;
    } else {
      rows[entering] = row;
      places[entering++] = child & ~INSTANCE_CHILD;
      stack->child[top] = INSTANCE_EXIT;
      if (!any_hit) stack->begin[top] = 0.0f;  // not to be culled
      at->child[i] = geometry.scene.instances[child & ~INSTANCE_CHILD].root;
      at->top[i] = top + 1u;
    }
    wide_prefetch(geometry, at->child[i]);
  }
  for (uint i = entering; entering != 0 && i % EK_WIDTH != 0; ++i) {
    rows[i] = rows[entering - 1u];
    places[i] = places[entering - 1u];
  }
  for (uint first = 0; first < entering; first += EK_WIDTH)
    rays_enter(geometry.scene.instances, rays, rows + first, places + first);
  const uint count = counts->place;
  counts->place = 0;
  batch_distribute(lists, counts, at, count);
}
#endif

// In a tree larger than a core's caches nodes come between, so that the triangles can be fetched meanwhile.
#define BATCH_ANSWER                                                                                          \
  if (counts.asked >= EK_WIDTH || (counts.asked != 0 && counts.node + counts.leaf < BATCH_SLOTS / 4)) \
    batch_answer(geometry, rays, &stack, bases, &lists, &counts, &candidates, any_hit, hits);

// The rays of `rows` (count of them). hits->t: where each ray ends. An any-hit query sets hits->triangle to 0 where something was
// found.
EK_FN void traverse_batch(Geometry geometry, RayOne* rays, const ushort* rows, uint count, const int any_hit, HitTable* hits) {
  BatchStack stack;
  BatchLists lists;
  BatchCandidates candidates;
  candidates.count = 0;
  uint bases[EK_ROWS];
  uint opened = min(count, (uint)BATCH_SLOTS);
  for (uint i = 0; i < opened; ++i) {
    const uint base = i * BATCH_STACK;
    bases[rows[i]] = base;
    stack.child[base] = BATCH_DONE;
    lists.node.row[i] = rows[i];
    lists.node.child[i] = 0;
    lists.node.top[i] = base + 1u;
  }
#if EK_HAS_instance
  BatchCounts counts = {opened, 0, 0, 0, 0};
  while (counts.node | counts.leaf | counts.asked | counts.place | counts.done) {
#else
  BatchCounts counts = {opened, 0, 0, 0};
  while (counts.node | counts.leaf | counts.asked | counts.done) {
#endif
    batch_candidates(geometry, rays, &stack, &lists, counts.leaf, any_hit, hits);
    const uint asked = counts.asked;
    batch_ask(&lists, &counts);
    batch_gather(geometry, &lists, asked, counts.asked, &candidates);
#if !EK_MEDIUM_TREE
    BATCH_ANSWER
#endif
    for (uint i = 0; i < counts.done; ++i) {
      const uint old = lists.done[i], base = bases[old];
      hits->t[old] = rays[old].t;
#if EK_HAS_implicit
      if (!any_hit || hits->triangle[old] == EK_NO_HIT)
        report_given_up(geometry, hits->gave_up[old], hits->gave_up_surface[old], rays[old].t);
#endif
      if (opened == count) continue;
      const uint row = rows[opened++], at = counts.node++;
      bases[row] = base;
      lists.node.row[at] = row;
      lists.node.child[at] = 0;
      lists.node.top[at] = base + 1u;
    }
    counts.done = 0;
    const uint node_count = counts.node;
    for (uint i = 0; i < node_count; ++i) {
      const RayOne* ray = rays + lists.node.row[i];
      global const float* node = wide_node(geometry, lists.node.child[i]);
      const uint top = batch_push(&stack, lists.node.top[i], node, wide_begin(node, ray), wide_end(node, ray), ray, any_hit) - 1u;
      const uint next = stack.child[top];
      wide_prefetch(geometry, next);
      lists.node.child[i] = next;
      lists.node.top[i] = top;
    }
    counts.node = 0;
    batch_distribute(&lists, &counts, &lists.node, node_count);
#if EK_MEDIUM_TREE
    BATCH_ANSWER
#endif
#if EK_HAS_instance
    if (counts.place != 0) batch_place(geometry, rays, &stack, &lists, &counts, any_hit);
#endif
  }
}

#endif
#endif
