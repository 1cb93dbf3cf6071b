// SPDX-License-Identifier: Apache-2.0
// The whole test of a batch's candidates (batch.h): in each lane one ray and one triangle or shape.
#ifndef EK_BATCH_TEST_H
#define EK_BATCH_TEST_H
#include "traverse/wide/batch_stack.h"

#if EK_WIDTH > 1

// The candidates that the pre-test left of all rays: the ray of row `row` may hit `triangle`.
typedef struct {
  uint row[8 * BATCH_SLOTS + EK_WIDTH], triangle[8 * BATCH_SLOTS + EK_WIDTH], count;
#if EK_HAS_moving_surface
  uint record[8 * BATCH_SLOTS + EK_WIDTH];  // over time, of the pose before the ray's time among those of all triangles
#endif
} BatchCandidates;

#if EK_HAS_moving_surface
// leaf8: the record that the ray needs (wide_record); k: place of the triangle in it
EK_FN uint candidate_record(Geometry geometry, global const float* leaf8, uint k, const RayOne* ray) {
  if (!EK_OVER_TIME(geometry)) return 0u;
  return as_uint(leaf8[LEAF8_WORDS + LEAF8_TRIANGLES + k]) + ray->step;
}

// The share of each ray's step that has passed.
EK_FN vf candidate_shares(const RayOne* rays, const uint* rows) {
  float share[EK_WIDTH] EK_ROWS_ALIGNED;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) share[lane] = rays[rows[lane]].share;
  return *(const vf*)share;
}
#endif

// Fetches what the whole test of the last candidate needs, in a tree that is larger than a core's
// caches.
EK_FN void candidate_prefetch(Geometry geometry, const BatchCandidates* candidates) {
#if EK_MEDIUM_TREE && EK_CPU
#if EK_HAS_moving_surface
  if (EK_OVER_TIME(geometry)) {
    global const Triangle* before = geometry.scene.pose_triangles + candidates->record[candidates->count - 1u];
    EK_PREFETCH(before);
    EK_PREFETCH(before + 1);
    return;
  }
#endif
  EK_PREFETCH(geometry.scene.triangles + candidates->triangle[candidates->count - 1u]);
#endif
}

// The records of EK_WIDTH triangles.
EK_FN TriangleLanes candidate_triangles(global const Triangle* triangles, const uint* indices) {
  Rec words;
#define CANDIDATE_ROW(vector, lane, offset) \
  words.w##vector = *(global const vf*)((global const float*)(triangles + indices[0x##lane]) + offset);
  EK_REC_ROWS(CANDIDATE_ROW)
#undef CANDIDATE_ROW
  return triangle_lanes(rec_transposed(words));
}

// The triangles of EK_WIDTH candidates; those that move, where they are at the time of the
// candidate's ray.
EK_FN TriangleLanes candidate_lanes(Geometry geometry, const RayOne* rays, const BatchCandidates* candidates, uint first) {
#if EK_HAS_moving_surface
  if (EK_OVER_TIME(geometry)) {
    const uint* records = candidates->record + first;
    const vf share = candidate_shares(rays, candidates->row + first);
    TriangleLanes now = candidate_triangles(geometry.scene.pose_triangles, records);
    const TriangleLanes next = candidate_triangles(geometry.scene.pose_triangles + 1, records);
    now.p0 = moved3(now.p0, next.p0, share);
    now.p1 = moved3(now.p1, next.p1, share);
    now.p2 = moved3(now.p2, next.p2, share);
    return now;
  }
#endif
  return candidate_triangles(geometry.scene.triangles, candidates->triangle + first);
}

EK_FN OpacityKey candidate_keys(const RayOne* rays, const uint* rows) {
  OpacityKey keys = {(vu)(0u), (vu)(0u)};
#if EK_HAS_opacity
  uint key[EK_WIDTH] EK_ROWS_ALIGNED, index[EK_WIDTH] EK_ROWS_ALIGNED;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) {
    key[lane] = rays[rows[lane]].key;
    index[lane] = rays[rows[lane]].index;
  }
  keys.key = *(const vu*)key;
  keys.index = *(const vu*)index;
#endif
  return keys;
}

// The stored corners of each lane's triangle. Those of an instance's triangles are in the space of
// its mesh, and are moved to the world.
EK_FN void candidate_corners(Geometry geometry, const TriangleLanes* record, vu instance, v3 corners[3]) {
  corners[0] = record->p0;
  corners[1] = record->p1;
  corners[2] = record->p2;
  const vi is_instanced = instance != 0u;
  if (!EK_HAS_instance || mask_bits(is_instanced) == 0) return;
  const InstanceTransform to_world =
      instance_transform(load_instance_matrix(geometry.scene.instances, is_instanced ? instance - 1u : (vu)(0u)));
  for (uint k = 0; k < 3u; ++k) corners[k] = select3(is_instanced, instance_point(to_world, corners[k]), corners[k]);
}

// Tests EK_WIDTH candidates from `first` on, of which those below candidates->count count, and
// leaves in `rays` and `hits` what traverse_batch leaves.
EK_FN void test_candidates(Geometry geometry, RayOne* rays, const BatchCandidates* candidates, uint first, const int any_hit,
                           HitTable* hits) {
  const uint *rows = candidates->row + first, *triangles = candidates->triangle + first;
  const uint count = min(candidates->count - first, (uint)EK_WIDTH);
  const vi here = LANE_INDEX < (vu)(count);
  const RayTestLanes test = ray_test_lanes(rays, rows);
  const TriangleLanes record = candidate_lanes(geometry, rays, candidates, first);
  RayLanes ray;
  ray.p_o = test.p_o; ray.sx = test.sx; ray.sy = test.sy; ray.p_rcp_d = test.p_rcp_d; ray.extent = test.extent;
  ray.p_near_x = test.p_near_x; ray.p_near_y = test.p_near_y; ray.p_far_x = test.p_far_x; ray.p_far_y = test.p_far_y;
  const vf end = test.t;
  const vi z_is_x = test.axis_z == 0u, z_is_y = test.axis_z == 8u;
  const vu instance = EK_HAS_instance ? test.instance_or_target : (vu)(0u);
  v3 stored[3];
  candidate_corners(geometry, &record, instance, stored);
  const v3 a = permute3(stored[0], z_is_x, z_is_y), b = permute3(stored[1], z_is_x, z_is_y), c = permute3(stored[2], z_is_x, z_is_y);
  const Corners_lanes corners = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};
  const vi is_shape = EK_HAS_shape ? is_shape_record(record) : (vi)(0);
  TriangleHit_lanes found = {(vi)(0), end, end, end, (vi)(0)};
  if (!EK_HAS_shape || mask_bits(!is_shape) != 0) found = triangle_hit_lanes(&ray, corners);
  if (EK_CULLS(any_hit)) found.hit = found.hit & !culls_lanes(geometry, found.back, record.flags);
  if (EK_HAS_opacity) {
    const vi ask = found.hit & here & ((record.flags & (vu)(EK_TRIANGLE_ALPHA_TESTED)) != 0u);
    if (mask_bits(ask) != 0) {
      const OpacityKey keys = candidate_keys(rays, rows);
      found.hit = found.hit & !(ask & alpha_test_rejects(geometry.scene, *(const vu_unaligned*)triangles, found.u, found.v, keys));
    }
  }
#if EK_HAS_shape
  if (mask_bits(is_shape & here) != 0) {
    ray.axis = z_is_x ? (vf)(0.0f) : z_is_y ? (vf)(1.0f) : (vf)(2.0f);
    ray.key = candidate_keys(rays, rows);
    const ShapeInterval within = shape_interval_permuted(&ray, a, b);
    const vu number = is_shape ? AS_U(record.n.x) : (vu)(0u);
    const ShapeHit shape = shape_hit_within(geometry.scene, &ray, is_shape & here & (within.begin <= within.end),
                                            *(const vu_unaligned*)triangles, number, load_shape(geometry.scene.shapes, number),
                                            within, end);
    if (EK_HAS_implicit && mask_bits(shape.gave_up < EK_INFINITY) != 0) {
      float gave_up[EK_WIDTH] EK_ROWS_ALIGNED;
      uint surface[EK_WIDTH] EK_ROWS_ALIGNED;
      *(vf*)gave_up = shape.gave_up;
      *(vu*)surface = AS_U(record.n.x);
      for (uint lane = 0; lane < count; ++lane)
        keep_given_up(gave_up[lane], surface[lane], hits->gave_up + rows[lane], hits->gave_up_surface + rows[lane]);
    }
    found.hit = found.hit | (is_shape & shape.hit);
    found.t = is_shape ? shape.t : found.t;
    found.u = is_shape ? shape.part : found.u;
    found.v = is_shape ? (vf)(0.0f) : found.v;
  }
#endif
  uint bits = mask_bits(found.hit & here & (any_hit ? found.t < end : found.t <= end));
  if (any_hit) {
    for (; bits != 0; bits &= bits - 1u) hits->triangle[rows[lowest_bit(bits)]] = 0u;
    return;
  }
  float t[EK_WIDTH] EK_ROWS_ALIGNED, u[EK_WIDTH] EK_ROWS_ALIGNED, v[EK_WIDTH] EK_ROWS_ALIGNED;
  uint instances[EK_WIDTH] EK_ROWS_ALIGNED;
  *(vf*)t = found.t;
  *(vf*)u = found.u;
  *(vf*)v = found.v;
  *(vu*)instances = is_shape ? (vu)(INSTANCE_SHAPE) : instance;
  for (; bits != 0; bits &= bits - 1u) {  // several lanes may be of one ray
    const uint lane = lowest_bit(bits), row = rows[lane];
    Hit best = table_hit(hits, row, rays[row].t);
    const int closer = is_closer(&best, t[lane], triangles[lane], instances[lane]);
    rays[row].t = closer ? t[lane] : best.t;
    hits->u[row] = closer ? u[lane] : hits->u[row];
    hits->v[row] = closer ? v[lane] : hits->v[row];
    hits->triangle[row] = closer ? triangles[lane] : best.triangle;
    if (EK_HAS_instance) hits->instance[row] = closer ? instances[lane] : best.instance;
  }
}

#endif
#endif
