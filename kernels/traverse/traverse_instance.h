// SPDX-License-Identifier: Apache-2.0
// Trees in two levels (EK_HAS_instance). Where a mesh is stored once, the scene's tree has a child
// word for each of its instances, and there the ray goes on in the mesh's own tree. Triangles are
// tested in the world, with corners of the very bits that they would have if they were stored for
// each instance (instance.h). So hits are the same too, if only every triangle is reached whose hit
// would count. For that a ray takes its boxes to the mesh's space, while t stays what it is:
//   - The test of a triangle T gives t only where the ray passes T within a few units of 2^-24 of
//     its extent, at some t' (classic/cells.h, item 3), and t lies in the interval of T's box. So
//     |t - t'| |d| is at most that box's extent and its pads on each axis, and thus on all axes the
//     least of these. (t is t' but for rounding, unless the ray sees T edge-on.)
//   - o and d in the mesh's space are o' = I (o - m(middle)) + middle and d' = I d, where I is the
//     inverse of the matrix, in floats. Within its extent the ray is off there by less than 8 units
//     of 2^-24 of the extent times the sum of |I| along a row. `pad`, which is 32 units of the
//     extent or more, is counted twice, beside the error of the corners and the rounding of o' and
//     of the planes.
//   - So boxes that grow by all this, and by |t - t'| |d'|, hold t in their intervals as computed.
//     No box above T is rejected for a best t that is not before t. In the scene's tree, each
//     instance has a box in the world around those of all its triangles.
// The child word of an instance is bits 31 and 30, and its number below them.
#ifndef EK_TRAVERSE_INSTANCE_H
#define EK_TRAVERSE_INSTANCE_H
#include "surface/instance_record.h"
#include "traverse/ray.h"
#include "lanes/simd.h"

#define INSTANCE_CHILD 0xc0000000u
#define INSTANCE_EXIT 0xfffffffeu    // in a stack: below it lie the children of the world
#define INSTANCE_SHAPE 0xffffffffu   // the instance of all shapes: at equal t, shapes are behind all triangles

EK_FN int is_instance_child(uint child) { return (child & INSTANCE_CHILD) == INSTANCE_CHILD; }

// The numbers of an instance that a ray enters it by.
typedef struct {
  InstanceTransform to_world;
  v3 middle;
  v3 ix, iy, iz;  // rows of the inverse
  v3 extent;
  vf error;
} EntryLanes;

EK_FN EntryLanes entry_of(InstanceMatrixLanes m, InstanceInverseLanes r) {
  const EntryLanes e = {instance_transform(m), m.middle, r.i_x, r.i_y, r.i_z, r.extent, r.error};
  return e;
}
EK_FN EntryLanes load_entry(global const InstanceRecord* instances, vu i) {
  return entry_of(load_instance_matrix(instances, i), load_instance_inverse(instances, i));
}
// The same of one instance, in all lanes.
EK_FN EntryLanes load_entry_one(global const InstanceRecord* instances, uint i) {
  return entry_of(broadcast_instance_matrix(instances + i), broadcast_instance_inverse(instances + i));
}

// The numbers that boxes need of a ray, as in RayLanes, in the mesh's space.
typedef struct {
  v3 rcp_d, o_near, o_far;
} EntryBoxes;

// The numbers of RayLanes that a ray enters an instance by, in the axes of the triangle test.
typedef struct {
  v3 p_o;
  vf sx, sy;
  v3 p_rcp_d;
  vf t_slack;
  vi z_is_x, z_is_y;
} RayEntry;

EK_FN EntryBoxes entry_boxes(EntryLanes e, RayEntry ray) {
  const vf one = (vf)(1.0f);
  const vf depth = div_f(one, ray.p_rcp_d.z);  // d on the longest axis
  const v3 o = unpermute3(ray.p_o, ray.z_is_x, ray.z_is_y), r = unpermute3(ray.p_rcp_d, ray.z_is_x, ray.z_is_y);
  const v3 d = unpermute3(V3(ray.sx * depth, ray.sy * depth, depth), ray.z_is_x, ray.z_is_y);
  const v3 from = sub3(o, instance_point(e.to_world, e.middle));
  const v3 own = V3(dot3(e.ix, from), dot3(e.iy, from), dot3(e.iz, from));
  const v3 own_o = add3(own, e.middle), own_d = V3(dot3(e.ix, d), dot3(e.iy, d), dot3(e.iz, d));
  const vf pad = 0.5f * ray.t_slack * abs_f(depth) * (1.0f + 0x1p-20f);
  const v3 apart = mul3(V3(e.extent.x + (pad + pad), e.extent.y + (pad + pad), e.extent.z + (pad + pad)), abs3(r));
  const vf margin = min_f(min_f(apart.x, apart.y), apart.z) * (1.0f + 0x1p-20f);
  const vf world = pad + pad + 4.0f * e.error;
  const v3 sum = V3((abs_f(e.ix.x) + abs_f(e.ix.y)) + abs_f(e.ix.z), (abs_f(e.iy.x) + abs_f(e.iy.y)) + abs_f(e.iy.z),
                    (abs_f(e.iz.x) + abs_f(e.iz.y)) + abs_f(e.iz.z));
  const v3 rounding = scale3(add3(abs3(own_o), abs3(e.middle)), (vf)(0x1p-21f));
  const v3 grown = add3(add3(scale3(sum, world), rounding), scale3(abs3(own_d), margin));
  const vf least = max_f(max_component(abs3(own_d)) * 0x1p-80f, (vf)(0x1p-126f));
  EntryBoxes b;
  b.rcp_d = V3(reciprocal_component(own_d.x, least), reciprocal_component(own_d.y, least), reciprocal_component(own_d.z, least));
  const v3 along = V3(b.rcp_d.x < 0.0f ? -grown.x : grown.x, b.rcp_d.y < 0.0f ? -grown.y : grown.y, b.rcp_d.z < 0.0f ? -grown.z : grown.z);
  b.o_near = add3(own_o, along);
  b.o_far = sub3(own_o, along);
  return b;
}

// Takes EK_WIDTH of the rays into instances. Rows beyond those that count repeat one that does.
EK_FN void rays_enter(global const InstanceRecord* records, RayOne* rays, const uint* rows, const uint* instances) {
  const RayTestLanes ray = ray_test_lanes(rays, rows);
  float slacks[EK_WIDTH] EK_ROWS_ALIGNED;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) slacks[lane] = rays[rows[lane]].t_slack;
  const vf t_slack = *(const vf*)slacks;
  const RayEntry entry = {.p_o = ray.p_o,
                          .sx = ray.sx,
                          .sy = ray.sy,
                          .p_rcp_d = ray.p_rcp_d,
                          .t_slack = t_slack,
                          .z_is_x = ray.axis_z == 0u,
                          .z_is_y = ray.axis_z == 8u};
  const EntryBoxes b = entry_boxes(load_entry(records, *(const vu_unaligned*)instances), entry);
  const RaySigns signs = ray_signs(b.rcp_d);
  const RayBoxWords boxes = {.fields = {.rcp_d = b.rcp_d,
                                        .o_near = b.o_near,
                                        .o_far = b.o_far,
                                        .near_x = signs.near_x,
                                        .near_y = signs.near_y,
                                        .near_z = signs.near_z,
                                        .order = signs.order,
                                        .axis_x = ray.axis_z == 16u ? (vu)(0u) : ray.axis_z + 8u,
                                        .t_slack = t_slack,
                                        .origin_prim = (vu)(EK_NO_HIT)}};
#if EK_WIDTH == 1
  *(RayBoxLanes*)&rays[rows[0]].rcp_d = boxes.fields;
#else
  const Rec words = rec_transposed(boxes.words);
#define ENTRY_ROW(vector, lane, offset) *(vf*)((float*)(rays + rows[0x##lane]) + offset) = words.w##vector;
  EK_REC_ROWS(ENTRY_ROW)
#undef ENTRY_ROW
#endif
  for (uint lane = 0; lane < EK_WIDTH; ++lane) rays[rows[lane]].instance_or_target = instances[lane] + 1u;
}

EK_FN void ray_enter(global const InstanceRecord* records, RayOne* ray, uint instance) {
  uint rows[EK_WIDTH] EK_ROWS_ALIGNED, instances[EK_WIDTH] EK_ROWS_ALIGNED;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) {
    rows[lane] = 0u;
    instances[lane] = instance;
  }
  rays_enter(records, ray, rows, instances);
}

EK_FN void ray_exit(RayOne* ray) {
#if EK_HAS_instance
  const float* w = ray->world;
  ray->rcp_d.x = w[0]; ray->rcp_d.y = w[1]; ray->rcp_d.z = w[2];
  ray->o_near.x = w[3]; ray->o_near.y = w[4]; ray->o_near.z = w[5];
  ray->o_far.x = w[6]; ray->o_far.y = w[7]; ray->o_far.z = w[8];
  // Copied as floats, the integers among the words could change: a compiler may alter a NaN.
  const uint x = w[0] < 0.0f ? 1u : 0u, y = w[1] < 0.0f ? 1u : 0u, z = w[2] < 0.0f ? 1u : 0u;
  ray->near_x = x * EK_NODE_WIDTH; ray->near_y = (y + 2u) * EK_NODE_WIDTH; ray->near_z = (z + 4u) * EK_NODE_WIDTH;
  ray->order = (x + y * 2u + z * 4u) * EK_ORDER_BITS;
  ray->instance_or_target = 0u;
#endif
}

// Axis `a` of a corner (x, y, z) of an instance's triangle, in the world.
EK_FN float instance_corner(global const InstanceRecord* instances, uint instance, uint a, float x, float y, float z) {
  global const float* m = (global const float*)(instances + (instance - 1u)) + 4u * a;
  return ((m[0] * x + m[1] * y) + m[2] * z) + m[3];
}

#endif
