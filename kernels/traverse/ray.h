// SPDX-License-Identifier: Apache-2.0
// A ray made ready for boxes and triangles, and the interval rule: the reason why every layout, and
// no tree at all, gives bit-identical hits.
//
// The rule has three parts:
//   - The interval of a box reaches from the maximum over the axes of (near plane - o_near) * r,
//     and 0, to the minimum of (far plane - o_far) * r, where r = 1 / d. o_near and o_far are the
//     origin moved by `pad` against and along the ray. So boxes grow by pad without a change to
//     their planes. All rounding is monotone, so the interval of a box lies inside that of any box
//     around it.
//   - A triangle accepts t only inside the interval of its own corners' box (triangle.h). So no
//     ancestor of it can be rejected before it has been tried.
//   - A box is visited if its interval is not empty and begins at or before the best t so far. So
//     ties survive.
//
// r is finite, because |d| counts as at least 2^-80 of the longest component. pad bounds what
// rounding can move a hit by. With E the farthest extent of the scene from the origin, shear and
// edge tests err by less than 8 units of 2^-24 E, and the sums o +- pad by |o| 2^-24; pad has a
// factor of two and more to spare over each. Nothing here is absolute: a scene and rays times 2^k
// give the same bits.
#ifndef EK_RAY_H
#define EK_RAY_H
#include "surface/alpha.h"
#include "lanes/transpose.h"

// The triangles that a ray is known not to meet, so that they need no test: the one that it starts
// from, and for an any-hit query the one just before which it ends. (The test says the same, except
// for rays along their plane, where rounding decides.) EK_NO_HIT: none. With EK_HAS_instance no
// ends are known.
typedef struct {
  vu origin_prim, target_prim;
} RayEnds;

EK_FN RayEnds unknown_ends(void) {
  const RayEnds ends = {(vu)(EK_NO_HIT), (vu)(EK_NO_HIT)};
  return ends;
}

// Rays to trace: the first `count` lanes are the rows from `row` on of a Tracing (traverse.h).
// coherent: the rays are neighbours, as camera rays are, and tracing them together may pay; it does
// not change the hits
typedef struct {
  uint row, count;
  int coherent;
  v3 origin, dir;
  vf t_max;
  RayEnds ends;
  OpacityKey key;  // read only with EK_HAS_opacity
  vf time;         // read only with EK_HAS_moving_surface
} TracedRays;

// Rays in lanes. rcp_d: r above. p_: the same in the axes of the triangle test, whose z is the
// longest component of d.
typedef struct {
  v3 rcp_d, o_near, o_far;
  v3 p_o;     // the origin
  vf sx, sy;  // shear: d.x / d.z and d.y / d.z in those axes
  v3 p_rcp_d;
  vf p_near_x, p_near_y, p_far_x, p_far_y;
  vf extent;   // E above
  vf t_slack;  // how much the t of a corner on z alone may exceed the t of a hit
  vf axis;     // 0, 1 or 2: the world axis that z of the triangle test is
  OpacityKey key;
#if EK_HAS_moving_surface
  vu step;   // of the shutter's time, and
  vf share;  // the share of it that has passed (lanes/pose_step.h)
#endif
  RayEnds ends;
} RayLanes;

// Boxes of a node in the trees that store them in vectors (wide/wide.h).
#if EK_LAYOUT_bvh16
#define EK_NODE_WIDTH 16u
#define EK_ORDER_BITS 4u
#else
#define EK_NODE_WIDTH 8u
#define EK_ORDER_BITS 3u
#endif

#if EK_WIDTH == 1
typedef v3 Packed3;
#else
typedef struct { float x, y, z; } Packed3;
#endif

// One ray: 16 words for boxes and 16 for triangles.
// near_x, near_y, near_z  offsets of the planes that the ray meets first in a node
// order                   shift of the order of the children for the ray's octant
// axis_x, axis_z          8 times the world axes that x and z of the triangle test are
// t                       where the ray ends so far
// instance_or_target      see ray_instance() and ray_target()
// world                   the words for boxes in the world, while the ray is in the space of an
//                         instance's mesh (traverse_instance.h)
typedef struct {
  Packed3 rcp_d, o_near, o_far;
  uint near_x, near_y, near_z, order, axis_x;
  float t_slack;
  uint origin_prim;
  Packed3 p_o;
  float sx, sy;
  Packed3 p_rcp_d;
  float p_near_x, p_near_y, p_far_x, p_far_y, extent, t;
  uint axis_z, instance_or_target;
#if EK_HAS_opacity
  uint key, index;
#endif
#if EK_HAS_moving_surface
  uint step;  // as in RayLanes
  float share;
#endif
#if EK_HAS_instance
  float world[16] __attribute__((aligned(64)));
#endif
} __attribute__((aligned(64))) RayOne;

// The two halves of a RayOne in lanes.
typedef struct {
  v3 rcp_d, o_near, o_far;
  vu near_x, near_y, near_z, order, axis_x;
  vf t_slack;
  vu origin_prim;
} RayBoxLanes;
typedef struct {
  v3 p_o;
  vf sx, sy;
  v3 p_rcp_d;
  vf p_near_x, p_near_y, p_far_x, p_far_y, extent, t;
  vu axis_z, instance_or_target;
} RayTestLanes;
typedef union { Rec words; RayBoxLanes fields; } RayBoxWords;
typedef union { Rec words; RayTestLanes fields; } RayTestWords;
EK_ASSERT_SIZE(RayBoxLanes, sizeof(Rec));
EK_ASSERT_SIZE(RayTestLanes, sizeof(Rec));

// 0: the ray is in the world; else 1 + the instance whose mesh it is in.
EK_FN uint ray_instance(const RayOne* ray) { return EK_HAS_instance ? ray->instance_or_target : 0u; }
// RayEnds.target_prim
EK_FN uint ray_target(const RayOne* ray) { return EK_HAS_instance ? EK_NO_HIT : ray->instance_or_target; }

// 1 where rays are sorted before they go in packets (wide/sorted.h).
#define EK_SORTS (EK_SMALL_TREE && (EK_LAYOUT_bvh16 || EK_LAYOUT_bvh8) && EK_WIDTH > 1 && !EK_HAS_moving_surface)

// The number of rays that are traced in one go: a whole chunk where they are sorted. Otherwise more
// than 512 gain nothing (measured).
#if EK_WIDTH == 1
#define EK_ROWS 1
#elif !defined(EK_ROWS)
#define EK_ROWS (EK_SORTS ? 4096 : 512)
#endif
#define EK_ROWS_ALIGNED __attribute__((aligned(4 * EK_WIDTH)))

// EK_COUNT 1 (`bench rays`): searches count their tests of triangles and their steps.
#ifndef EK_COUNT
#define EK_COUNT 0
#endif
#if EK_COUNT
#define EK_COUNT_TEST(hit) (++(hit)->tests)
#define EK_COUNT_STEP(hit) (++(hit)->steps)
#else
#define EK_COUNT_TEST(hit)
#define EK_COUNT_STEP(hit)
#endif

// Components of `a` in the axes of the triangle test: z is the longest of d (the last of equals); x
// and y follow cyclically.
EK_FN v3 permute3(v3 a, vi z_is_x, vi z_is_y) {
  return V3(z_is_x ? a.y : z_is_y ? a.z : a.x, z_is_x ? a.z : z_is_y ? a.x : a.y, z_is_x ? a.x : z_is_y ? a.y : a.z);
}

// The vector whose permute3 is `a`.
EK_FN v3 unpermute3(v3 a, vi z_is_x, vi z_is_y) {
  return V3(z_is_x ? a.z : z_is_y ? a.y : a.x, z_is_x ? a.x : z_is_y ? a.z : a.y, z_is_x ? a.y : z_is_y ? a.x : a.z);
}

EK_FN vf reciprocal_component(vf d, vf least) {
  return div_f((vf)(1.0f), abs_f(d) < least ? (d < 0.0f ? -least : least) : d);
}

EK_FN vf ray_pad(vf extent, vf farthest) { return extent * 0x1p-19f + farthest * 0x1p-23f; }

// Prepares rays of unknown ends. `d` need not be unit; t counts in its lengths.
EK_FN RayLanes ray_lanes(constant Frame* frame, v3 o, v3 d, OpacityKey key) {
  const v3 size = abs3(d);
  const vf least = max_f(max_component(size) * 0x1p-80f, (vf)(0x1p-126f));
  const v3 r = V3(reciprocal_component(d.x, least), reciprocal_component(d.y, least), reciprocal_component(d.z, least));

  const vf extent = max_component(add3(abs3(sub3(o, splat3(frame->scene_center))), splat3(frame->scene_half)));
  const vf pad = ray_pad(extent, max_component(abs3(o)));
  const v3 along = V3(r.x < 0.0f ? -pad : pad, r.y < 0.0f ? -pad : pad, r.z < 0.0f ? -pad : pad);

  const vi z_is_x = (size.x > size.y) & (size.x > size.z);
  const vi z_is_y = (!z_is_x) & (size.y > size.z);

  RayLanes ray;
  ray.key = key;
  ray.ends = unknown_ends();
  ray.rcp_d = r;
  ray.o_near = add3(o, along);
  ray.o_far = sub3(o, along);
  const v3 pd = permute3(d, z_is_x, z_is_y), p_near = permute3(ray.o_near, z_is_x, z_is_y), p_far = permute3(ray.o_far, z_is_x, z_is_y);
  ray.p_o = permute3(o, z_is_x, z_is_y);
  ray.p_rcp_d = permute3(r, z_is_x, z_is_y);
  ray.p_near_x = p_near.x; ray.p_near_y = p_near.y;
  ray.p_far_x = p_far.x; ray.p_far_y = p_far.y;
  ray.sx = div_f(pd.x, pd.z);
  ray.sy = div_f(pd.y, pd.z);
  ray.extent = extent;
  ray.t_slack = (pad + pad) * abs_f(ray.p_rcp_d.z);
  ray.axis = z_is_x ? (vf)(0.0f) : z_is_y ? (vf)(1.0f) : (vf)(2.0f);
  return ray;
}

// The words of a RayOne that depend on the signs of its direction alone.
typedef struct {
  vu near_x, near_y, near_z, order;
} RaySigns;

EK_FN RaySigns ray_signs(v3 rcp_d) {
  const vu one = (vu)(1u), none = (vu)(0u);
  const vu x = rcp_d.x < 0.0f ? one : none, y = rcp_d.y < 0.0f ? one : none, z = rcp_d.z < 0.0f ? one : none;
  const RaySigns signs = {x * EK_NODE_WIDTH, (y + 2u) * EK_NODE_WIDTH, (z + 4u) * EK_NODE_WIDTH, (x + y * 2u + z * 4u) * EK_ORDER_BITS};
  return signs;
}

// Stores the words of EK_WIDTH rays that few programs have.
EK_FN void ray_store_rest(RayOne* rays, RayLanes ray) {
#if EK_HAS_opacity
  uint key[EK_WIDTH] EK_ROWS_ALIGNED, index[EK_WIDTH] EK_ROWS_ALIGNED;
  *(vu*)key = ray.key.key;
  *(vu*)index = ray.key.index;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) {
    rays[lane].key = key[lane];
    rays[lane].index = index[lane];
  }
#endif
#if EK_HAS_moving_surface
  uint step[EK_WIDTH] EK_ROWS_ALIGNED;
  float share[EK_WIDTH] EK_ROWS_ALIGNED;
  *(vu*)step = ray.step;
  *(vf*)share = ray.share;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) {
    rays[lane].step = step[lane];
    rays[lane].share = share[lane];
  }
#endif
}

// Stores EK_WIDTH rays that end at t.
EK_FN void ray_store(RayOne* rays, RayLanes ray, vf t) {
  const RaySigns signs = ray_signs(ray.rcp_d);
  const vu axis_z = AS_U(TO_I(ray.axis)) * 8u, axis_x = axis_z == 16u ? (vu)(0u) : axis_z + 8u;
  const RayBoxWords boxes = {.fields = {.rcp_d = ray.rcp_d,
                                        .o_near = ray.o_near,
                                        .o_far = ray.o_far,
                                        .near_x = signs.near_x,
                                        .near_y = signs.near_y,
                                        .near_z = signs.near_z,
                                        .order = signs.order,
                                        .axis_x = axis_x,
                                        .t_slack = ray.t_slack,
                                        .origin_prim = ray.ends.origin_prim}};
  const RayTestWords test = {.fields = {.p_o = ray.p_o,
                                        .sx = ray.sx,
                                        .sy = ray.sy,
                                        .p_rcp_d = ray.p_rcp_d,
                                        .p_near_x = ray.p_near_x,
                                        .p_near_y = ray.p_near_y,
                                        .p_far_x = ray.p_far_x,
                                        .p_far_y = ray.p_far_y,
                                        .extent = ray.extent,
                                        .t = t,
                                        .axis_z = axis_z,
                                        .instance_or_target = EK_HAS_instance ? (vu)(0u) : ray.ends.target_prim}};
#if EK_WIDTH == 1
  *(RayBoxLanes*)&rays->rcp_d = boxes.fields;
  *(RayTestLanes*)&rays->p_o = test.fields;
#if EK_HAS_instance
  *(RayBoxLanes*)rays->world = boxes.fields;
#endif
#else
  const Rec first = rec_transposed(boxes.words), second = rec_transposed(test.words);
#define EK_RAY_ROW(vector, lane, offset)                        \
  *(vf*)((float*)(rays + 0x##lane) + offset) = first.w##vector; \
  *(vf*)((float*)(rays + 0x##lane) + 16 + offset) = second.w##vector;
  EK_REC_ROWS(EK_RAY_ROW)
#undef EK_RAY_ROW
#if EK_HAS_instance
#define EK_RAY_ROW(vector, lane, offset) *(vf*)(rays[0x##lane].world + offset) = first.w##vector;
  EK_REC_ROWS(EK_RAY_ROW)
#undef EK_RAY_ROW
#endif
#endif
  ray_store_rest(rays, ray);
}

// The words for triangles of EK_WIDTH of the rays.
EK_FN RayTestLanes ray_test_lanes(const RayOne* rays, const uint* rows) {
#if EK_WIDTH == 1
  return *(const RayTestLanes*)&rays[rows[0]].p_o;
#else
  RayTestWords ray;
#define EK_RAY_ROW(vector, lane, offset) ray.words.w##vector = *(const vf*)((const float*)(rays + rows[0x##lane]) + 16 + offset);
  EK_REC_ROWS(EK_RAY_ROW)
#undef EK_RAY_ROW
  ray.words = rec_transposed(ray.words);
  return ray.fields;
#endif
}

// What the boxes of nodes need of one ray.
typedef struct {
  Packed3 rcp_d, o_near, o_far;
} RayBoxes;

// The ray's key in all lanes.
EK_FN OpacityKey ray_key(const RayOne* ray) {
  OpacityKey key = {(vu)(0u), (vu)(0u)};
#if EK_HAS_opacity
  key.key = (vu)(ray->key);
  key.index = (vu)(ray->index);
#endif
  return key;
}

#endif
