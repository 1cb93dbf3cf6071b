// SPDX-License-Identifier: Apache-2.0
// Trees in two levels (EK_HAS_instance): where a mesh is stored once, the scene's tree has a child word for each of its places, and there
// the ray goes on in the mesh's own tree. Triangles are tested in the world, with corners that have the bits that they would have if they
// were stored for each place (instance.h); so hits do too, if only every triangle is reached whose hit would count. A ray takes its boxes
// to the mesh's space for that; t stays what it is:
//   - The test of triangle T gives t only where the ray passes T within a few units of 2^-24 of its reach, at some t' (traverse/classic/cells.h,
//     3), and t lies in the interval of T's box. So |t - t'| |d| is at most that box's extent and its pads, on each axis: hence on all, with
//     the axis on which that is least. (t is t' but for rounding, unless the ray sees T edge-on.)
//   - o and d in the mesh's space are o' = I (o - m(middle)) + middle and d' = I d, with I the inverse of the matrix, in floats. Up to its
//     reach the ray is off there by less than 8 units of 2^-24 of reach times the sum of |I| along a row; `pad`, which is 32 units of the
//     reach and more, is counted twice, beside the corners' own error, and the rounding of o' and of the planes.
//   - So boxes that grow by all this, and by |t - t'| |d'|, hold t in their intervals as computed: no box above T is rejected for a best t
//     that is not before t. In the scene's tree each place has a box in the world around those of all its triangles.
// Child words of places have bits 31 and 30; below them is the place's number.
#ifndef EK_TRAVERSE_INSTANCE_H
#define EK_TRAVERSE_INSTANCE_H
#include "surface/instance_record.h"
#include "traverse/ray.h"
#include "lanes/simd.h"

#if EK_HAS_instance
#define INSTANCE_CHILD 0xc0000000u
#define INSTANCE_EXIT 0xfffffffeu    // on a stack: below this the ray is back in the world
#define INSTANCE_SHAPE 0xffffffffu   // stands for the place of shapes, which are behind all triangles among equals

EK_FN int is_instance_child(uint child) { return (child & INSTANCE_CHILD) == INSTANCE_CHILD; }

// What a ray needs of a place.
typedef struct {
  Placing to_world;
  v3 middle;
  v3 ix, iy, iz;  // rows of the inverse
  v3 extent;
  vf error;
} EntryLanes;

EK_FN EntryLanes entry_of(InstanceMatrixLanes m, InstanceInverseLanes r) {
  const EntryLanes e = {instance_placing(m), m.middle, r.i_x, r.i_y, r.i_z, r.extent, r.error};
  return e;
}
EK_FN EntryLanes load_entry(global const InstanceRecord* instances, vu i) {
  return entry_of(load_instance_matrix(instances, i), load_instance_inverse(instances, i));
}
// The same of one place for all lanes.
EK_FN EntryLanes load_entry_one(global const InstanceRecord* instances, uint i) {
  return entry_of(broadcast_instance_matrix(instances + i), broadcast_instance_inverse(instances + i));
}

// What boxes need of a ray, as in RayLanes, in the mesh's space.
typedef struct {
  v3 r, n, f;
} EntryBoxes;

// A ray by what the test of triangles has of it: p_o, s, p_r and slack of RayLanes, in the axes of that test.
EK_FN EntryBoxes entry_boxes(EntryLanes e, v3 p_o, vf sx, vf sy, v3 p_r, vf slack, vi z_is_x, vi z_is_y) {
  const vf one = (vf)(1.0f);
  const vf depth = one / p_r.z;  // d on the longest axis
  const v3 o = unpermute3(p_o, z_is_x, z_is_y), r = unpermute3(p_r, z_is_x, z_is_y);
  const v3 d = unpermute3(V3(sx * depth, sy * depth, depth), z_is_x, z_is_y);
  const v3 from = sub3(o, placed_point(e.to_world, e.middle));
  const v3 own = V3(dot3(e.ix, from), dot3(e.iy, from), dot3(e.iz, from));
  const v3 own_o = add3(own, e.middle), own_d = V3(dot3(e.ix, d), dot3(e.iy, d), dot3(e.iz, d));
  const vf pad = 0.5f * slack * abs_f(depth) * (1.0f + 0x1p-20f);
  const v3 apart = mul3(V3(e.extent.x + (pad + pad), e.extent.y + (pad + pad), e.extent.z + (pad + pad)), abs3(r));
  const vf margin = min_f(min_f(apart.x, apart.y), apart.z) * (1.0f + 0x1p-20f);
  const vf world = pad + pad + 4.0f * e.error;
  const v3 sum = V3((abs_f(e.ix.x) + abs_f(e.ix.y)) + abs_f(e.ix.z), (abs_f(e.iy.x) + abs_f(e.iy.y)) + abs_f(e.iy.z),
                    (abs_f(e.iz.x) + abs_f(e.iz.y)) + abs_f(e.iz.z));
  const v3 rounding = scale3(add3(abs3(own_o), abs3(e.middle)), (vf)(0x1p-21f));
  const v3 grown = add3(add3(scale3(sum, world), rounding), scale3(abs3(own_d), margin));
  const vf least = max_f(max_component(abs3(own_d)) * 0x1p-80f, (vf)(0x1p-126f));
  EntryBoxes b;
  b.r = V3(reciprocal_component(own_d.x, least), reciprocal_component(own_d.y, least), reciprocal_component(own_d.z, least));
  const v3 along = V3(b.r.x < 0.0f ? -grown.x : grown.x, b.r.y < 0.0f ? -grown.y : grown.y, b.r.z < 0.0f ? -grown.z : grown.z);
  b.n = add3(own_o, along);
  b.f = sub3(own_o, along);
  return b;
}

// Takes EK_WIDTH rays of `rays` to places; the first `count` of `rows` and `places` count, and the others repeat one of them.
EK_FN void rays_enter(global const InstanceRecord* instances, RayOne* rays, const uint* rows, const uint* places) {
#if EK_WIDTH == 1
  RayOne* ray = rays + rows[0];
  const vi z_is_x = ray->axis_z == 0u, z_is_y = ray->axis_z == 8u;
  const EntryBoxes b = entry_boxes(load_entry(instances, places[0]), V3(ray->p_ox, ray->p_oy, ray->p_oz), ray->sx, ray->sy,
                                   V3(ray->p_rx, ray->p_ry, ray->p_rz), ray->slack, z_is_x, z_is_y);
  ray->rx = b.r.x; ray->ry = b.r.y; ray->rz = b.r.z;
  ray->nx = b.n.x; ray->ny = b.n.y; ray->nz = b.n.z;
  ray->fx = b.f.x; ray->fy = b.f.y; ray->fz = b.f.z;
  const RaySigns signs = ray_signs(b.r.x, b.r.y, b.r.z);
  ray->near_x = signs.near_x; ray->near_y = signs.near_y; ray->near_z = signs.near_z; ray->order = signs.order;
  ray->instance = places[0] + 1u;
#else
  const RayTestLanes ray = ray_test_lanes(rays, rows);
  float slacks[EK_WIDTH] EK_ROWS_ALIGNED;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) slacks[lane] = rays[rows[lane]].slack;
  const vf slack = *(const vf*)slacks;
  const EntryBoxes b = entry_boxes(load_entry(instances, *(const vu_unaligned*)places), ray.p_o, ray.sx, ray.sy, ray.p_r, slack,
                                   ray.axis_z == 0u, ray.axis_z == 8u);
  const RaySigns signs = ray_signs(b.r.x, b.r.y, b.r.z);
  const RayBoxWords boxes = {.fields = {.r = b.r,
                                        .n = b.n,
                                        .f = b.f,
                                        .near_x = signs.near_x,
                                        .near_y = signs.near_y,
                                        .near_z = signs.near_z,
                                        .order = signs.order,
                                        .axis_x = ray.axis_z == 16u ? (vu)(0u) : ray.axis_z + 8u,
                                        .slack = slack,
                                        .left = (vu)(EK_NO_HIT)}};
  const Rec words = rec_transposed(boxes.words);
#define ENTRY_ROW(vector, lane, offset) *(vf*)((float*)(rays + rows[0x##lane]) + offset) = words.w##vector;
  EK_REC_ROWS(ENTRY_ROW)
#undef ENTRY_ROW
  for (uint lane = 0; lane < EK_WIDTH; ++lane) rays[rows[lane]].instance = places[lane] + 1u;
#endif
}

EK_FN void ray_enter(global const InstanceRecord* instances, RayOne* ray, uint place) {
  uint rows[EK_WIDTH] EK_ROWS_ALIGNED, places[EK_WIDTH] EK_ROWS_ALIGNED;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) {
    rows[lane] = 0u;
    places[lane] = place;
  }
  rays_enter(instances, ray, rows, places);
}

EK_FN void ray_exit(RayOne* ray) {
  const float* w = ray->world;
  ray->rx = w[0]; ray->ry = w[1]; ray->rz = w[2];
  ray->nx = w[3]; ray->ny = w[4]; ray->nz = w[5];
  ray->fx = w[6]; ray->fy = w[7]; ray->fz = w[8];
  // Not as floats: compilers may take it that those leave integers as they are.
  const uint x = ray->rx < 0.0f ? 1u : 0u, y = ray->ry < 0.0f ? 1u : 0u, z = ray->rz < 0.0f ? 1u : 0u;
  ray->near_x = x * EK_NODE_WIDTH; ray->near_y = (y + 2u) * EK_NODE_WIDTH; ray->near_z = (z + 4u) * EK_NODE_WIDTH;
  ray->order = (x + y * 2u + z * 4u) * EK_ORDER_BITS;
  ray->instance = 0u;
}

// Which of two places' triangles are before the others among hits at the same t; within one place, the smaller index is.
EK_FN int is_before(uint instance, uint triangle, uint other_instance, uint other_triangle) {
  return (instance < other_instance) | ((instance == other_instance) & (triangle < other_triangle));
}

// Corner p of a triangle of a place, for one ray; a: which axis.
EK_FN float placed_corner(global const InstanceRecord* instances, uint instance, uint a, float x, float y, float z) {
  global const float* m = (global const float*)(instances + (instance - 1u)) + 4u * a;
  return ((m[0] * x + m[1] * y) + m[2] * z) + m[3];
}
#endif

#endif
