// SPDX-License-Identifier: Apache-2.0
// A ray made ready for boxes and triangles. Every traversal uses these numbers and the interval rule below, which is why
// every layout, and no tree at all, gives bit-identical hits:
//   - the interval of a box is max over axes of (near plane - o_near) * r, and 0, to the min of (far plane - o_far) * r, with
//     r = 1 / d. o_near and o_far are the origin moved by `pad` against and along the ray: boxes grow by pad without a
//     change to their planes. All rounding is monotone, so the interval of a box lies inside that of any box around it;
//   - a triangle accepts t only inside the interval of its own corners' box (traverse/triangle.h), so no ancestor of it can
//     be rejected before it has been tried;
//   - a box is visited if its interval is not empty and begins at or before the best t so far: ties survive.
// r is finite: |d| counts as at least 2^-80 of the longest component. pad bounds what rounding can move a hit by: with E the
// farthest extent of the scene from the origin, shear and edge tests err by less than 8 units of 2^-24 E, the sums o +- pad by
// |o| 2^-24; each has a factor of two and more to spare. Nothing here is absolute: scene and rays times 2^k give the same bits.
#ifndef EK_RAY_H
#define EK_RAY_H
#include "surface/alpha.h"
#include "lanes/transpose.h"

// The triangles that a ray does not meet, so that they need no test: the one that it leaves, and of an any-hit query the one that it
// goes to, just before which it ends. (The test says the same but of rays along their plane, where rounding decides.) EK_NO_HIT: none;
// with EK_HAS_instance, none is known.
typedef struct {
  vu left, goal;
} RayEnds;

EK_FN RayEnds unknown_ends(void) {
  const RayEnds ends = {(vu)(EK_NO_HIT), (vu)(EK_NO_HIT)};
  return ends;
}

// o: origin, d's reciprocal r, padded origins n (near) and f (far), in world axes; the same with p_ in the axes of the
// triangle test, whose z is the longest component of d; s: shear; slack: what a corner's t on z alone may exceed the t of a hit
// by; axis: which axis that z is; key: for opacity.
typedef struct {
  vf rx, ry, rz, nx, ny, nz, fx, fy, fz;
  vf p_ox, p_oy, p_oz, sx, sy, p_rx, p_ry, p_rz, p_nx, p_ny, p_fx, p_fy, reach;
  vf slack, axis;
  OpacityKey key;
  RayEnds ends;
} RayLanes;

// Boxes of a node in the trees that store them in vectors (traverse/wide/wide.h).
#if EK_LAYOUT_bvh16
#define EK_NODE_WIDTH 16u
#define EK_ORDER_BITS 4u
#else
#define EK_NODE_WIDTH 8u
#define EK_ORDER_BITS 3u
#endif

// One ray, 16 words for boxes and 16 for triangles. near_*: offsets of the planes it meets first in a node; order: shift of the
// children's order; axis_x, axis_z: 8 times the axes x and z of the triangle test; t: where it ends so far; instance: 0, or 1 + the place
// whose mesh it is in (traverse_instance.h), with the words for boxes in the mesh's space, and those of the world kept in `world`;
// left, goal: RayEnds.
typedef struct {
  float rx, ry, rz, nx, ny, nz, fx, fy, fz;
  uint near_x, near_y, near_z, order, axis_x;
  float slack;
  uint left;
  float p_ox, p_oy, p_oz, sx, sy, p_rx, p_ry, p_rz, p_nx, p_ny, p_fx, p_fy, reach, t;
  uint axis_z;
#if EK_HAS_instance
  uint instance;
#else
  uint goal;
#endif
#if EK_HAS_opacity
  uint key, index, pad[14];
#endif
#if EK_HAS_instance
  float world[16];
#endif
} __attribute__((aligned(64))) RayOne;

// The two halves of a RayOne in lanes.
typedef struct {
  v3 r, n, f;
  vu near_x, near_y, near_z, order, axis_x;
  vf slack;
  vu left;
} RayBoxLanes;
typedef struct {
  v3 p_o;
  vf sx, sy;
  v3 p_r;
  vf p_nx, p_ny, p_fx, p_fy, reach, t;
  vu axis_z;
  vu goal;  // or `instance`
} RayTestLanes;
typedef union { Rec words; RayBoxLanes fields; } RayBoxWords;
typedef union { Rec words; RayTestLanes fields; } RayTestWords;
EK_ASSERT_SIZE(RayBoxLanes, sizeof(Rec));
EK_ASSERT_SIZE(RayTestLanes, sizeof(Rec));

// Whether rays are sorted before they go in packets (traverse/wide/sorted.h).
#define EK_SORTS (EK_SMALL_TREE && (EK_LAYOUT_bvh16 || EK_LAYOUT_bvh8) && EK_WIDTH > 1)

// So many rays are traced in one go: sorted, all of a chunk; otherwise more than 512 gain nothing (measured).
#if EK_WIDTH == 1
#define EK_ROWS 1
#elif !defined(EK_ROWS)
#define EK_ROWS (EK_SORTS ? 4096 : 512)
#endif
#define EK_ROWS_ALIGNED __attribute__((aligned(4 * EK_WIDTH)))

// Components of `a` in the axes of the triangle test: z is the longest of d (the last of equals), x and y follow cyclically.
EK_FN v3 permute3(v3 a, vi z_is_x, vi z_is_y) {
  return V3(z_is_x ? a.y : z_is_y ? a.z : a.x, z_is_x ? a.z : z_is_y ? a.x : a.y, z_is_x ? a.x : z_is_y ? a.y : a.z);
}

// The vector whose permute3 is `a`.
EK_FN v3 unpermute3(v3 a, vi z_is_x, vi z_is_y) {
  return V3(z_is_x ? a.z : z_is_y ? a.y : a.x, z_is_x ? a.x : z_is_y ? a.z : a.y, z_is_x ? a.y : z_is_y ? a.x : a.z);
}

EK_FN vf reciprocal_component(vf d, vf least) {
  return (vf)(1.0f) / (abs_f(d) < least ? (d < 0.0f ? -least : least) : d);
}

EK_FN vf ray_pad(vf reach, vf farthest) { return reach * 0x1p-19f + farthest * 0x1p-23f; }

// `d` need not be unit; t counts in its lengths. Its ends are unknown.
EK_FN RayLanes ray_lanes(constant Frame* frame, v3 o, v3 d, OpacityKey key) {
  const v3 size = abs3(d);
  const vf least = max_f(max_component(size) * 0x1p-80f, (vf)(0x1p-126f));
  const v3 r = V3(reciprocal_component(d.x, least), reciprocal_component(d.y, least), reciprocal_component(d.z, least));

  const v3 extent = add3(abs3(sub3(o, splat3(frame->scene_center))), splat3(frame->scene_half));
  const vf reach = max_component(extent);
  const vf pad = ray_pad(reach, max_component(abs3(o)));
  const v3 along = V3(r.x < 0.0f ? -pad : pad, r.y < 0.0f ? -pad : pad, r.z < 0.0f ? -pad : pad);
  const v3 n = add3(o, along), f = sub3(o, along);

  const vi z_is_x = (size.x > size.y) & (size.x > size.z);
  const vi z_is_y = (!z_is_x) & (size.y > size.z);
  const v3 pd = permute3(d, z_is_x, z_is_y), po = permute3(o, z_is_x, z_is_y), pr = permute3(r, z_is_x, z_is_y);
  const v3 pn = permute3(n, z_is_x, z_is_y), pf = permute3(f, z_is_x, z_is_y);

  RayLanes ray;
  ray.key = key;
  ray.ends = unknown_ends();
  ray.rx = r.x; ray.ry = r.y; ray.rz = r.z;
  ray.nx = n.x; ray.ny = n.y; ray.nz = n.z;
  ray.fx = f.x; ray.fy = f.y; ray.fz = f.z;
  ray.p_ox = po.x; ray.p_oy = po.y; ray.p_oz = po.z;
  ray.p_rx = pr.x; ray.p_ry = pr.y; ray.p_rz = pr.z;
  ray.p_nx = pn.x; ray.p_ny = pn.y;
  ray.p_fx = pf.x; ray.p_fy = pf.y;
  ray.sx = pd.x / pd.z;
  ray.sy = pd.y / pd.z;
  ray.reach = reach;
  ray.slack = (pad + pad) * abs_f(pr.z);
  ray.axis = z_is_x ? (vf)(0.0f) : z_is_y ? (vf)(1.0f) : (vf)(2.0f);
  return ray;
}

// What of a RayOne hangs on the signs of its direction alone.
typedef struct {
  vu near_x, near_y, near_z, order;
} RaySigns;

EK_FN RaySigns ray_signs(vf rx, vf ry, vf rz) {
  const vu one = (vu)(1u), none = (vu)(0u);
  const vu x = rx < 0.0f ? one : none, y = ry < 0.0f ? one : none, z = rz < 0.0f ? one : none;
  const RaySigns signs = {x * EK_NODE_WIDTH, (y + 2u) * EK_NODE_WIDTH, (z + 4u) * EK_NODE_WIDTH, (x + y * 2u + z * 4u) * EK_ORDER_BITS};
  return signs;
}

// Writes EK_WIDTH rays that end at t.
EK_FN void ray_store(RayOne* rays, RayLanes ray, vf t) {
  const vu none = (vu)(0u);
  const RaySigns signs = ray_signs(ray.rx, ray.ry, ray.rz);
  const vu axis_z = AS_U(TO_I(ray.axis)) * 8u, axis_x = axis_z == 16u ? none : axis_z + 8u;
#if EK_WIDTH == 1
  rays->rx = ray.rx; rays->ry = ray.ry; rays->rz = ray.rz;
  rays->nx = ray.nx; rays->ny = ray.ny; rays->nz = ray.nz;
  rays->fx = ray.fx; rays->fy = ray.fy; rays->fz = ray.fz;
  rays->t = t;
  rays->near_x = signs.near_x; rays->near_y = signs.near_y; rays->near_z = signs.near_z; rays->order = signs.order;
  rays->p_ox = ray.p_ox; rays->p_oy = ray.p_oy; rays->p_oz = ray.p_oz; rays->sx = ray.sx; rays->sy = ray.sy;
  rays->p_rx = ray.p_rx; rays->p_ry = ray.p_ry; rays->p_rz = ray.p_rz;
  rays->p_nx = ray.p_nx; rays->p_ny = ray.p_ny; rays->p_fx = ray.p_fx; rays->p_fy = ray.p_fy;
  rays->reach = ray.reach; rays->slack = ray.slack;
  rays->axis_x = axis_x; rays->axis_z = axis_z;
  rays->left = ray.ends.left;
#if !EK_HAS_instance
  rays->goal = ray.ends.goal;
#else
  rays->instance = 0u;
  rays->world[0] = ray.rx; rays->world[1] = ray.ry; rays->world[2] = ray.rz;
  rays->world[3] = ray.nx; rays->world[4] = ray.ny; rays->world[5] = ray.nz;
  rays->world[6] = ray.fx; rays->world[7] = ray.fy; rays->world[8] = ray.fz;
#endif
#else
  const RayBoxWords boxes = {.fields = {.r = V3(ray.rx, ray.ry, ray.rz),
                                        .n = V3(ray.nx, ray.ny, ray.nz),
                                        .f = V3(ray.fx, ray.fy, ray.fz),
                                        .near_x = signs.near_x,
                                        .near_y = signs.near_y,
                                        .near_z = signs.near_z,
                                        .order = signs.order,
                                        .axis_x = axis_x,
                                        .slack = ray.slack,
                                        .left = ray.ends.left}};
  const RayTestWords test = {.fields = {.p_o = V3(ray.p_ox, ray.p_oy, ray.p_oz),
                                        .sx = ray.sx,
                                        .sy = ray.sy,
                                        .p_r = V3(ray.p_rx, ray.p_ry, ray.p_rz),
                                        .p_nx = ray.p_nx,
                                        .p_ny = ray.p_ny,
                                        .p_fx = ray.p_fx,
                                        .p_fy = ray.p_fy,
                                        .reach = ray.reach,
                                        .t = t,
                                        .axis_z = axis_z,
                                        .goal = EK_HAS_instance ? none : ray.ends.goal}};
  const Rec first = rec_transposed(boxes.words), second = rec_transposed(test.words);
#define EK_RAY_ROW(vector, lane, offset)                          \
  *(vf*)((float*)(rays + 0x##lane) + offset) = first.w##vector;       \
  *(vf*)((float*)(rays + 0x##lane) + 16 + offset) = second.w##vector;
  EK_REC_ROWS(EK_RAY_ROW)
#undef EK_RAY_ROW
#if EK_HAS_instance
#define EK_RAY_ROW(vector, lane, offset) *(vf*)(rays[0x##lane].world + offset) = first.w##vector;
  EK_REC_ROWS(EK_RAY_ROW)
#undef EK_RAY_ROW
#endif
#endif
#if EK_HAS_opacity
  uint key[EK_WIDTH] EK_ROWS_ALIGNED, index[EK_WIDTH] EK_ROWS_ALIGNED;
  *(vu*)key = ray.key.key;
  *(vu*)index = ray.key.index;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) {
    rays[lane].key = key[lane];
    rays[lane].index = index[lane];
  }
#endif
}

#if EK_WIDTH > 1
// The words for triangles of EK_WIDTH of the rays.
EK_FN RayTestLanes ray_test_lanes(const RayOne* rays, const uint* rows) {
  RayTestWords ray;
#define EK_RAY_ROW(vector, lane, offset) ray.words.w##vector = *(const vf*)((const float*)(rays + rows[0x##lane]) + 16 + offset);
  EK_REC_ROWS(EK_RAY_ROW)
#undef EK_RAY_ROW
  ray.words = rec_transposed(ray.words);
  return ray.fields;
}
#endif

EK_FN OpacityKey ray_key(const RayOne* ray) {  // in all lanes
#if EK_HAS_opacity
  const OpacityKey key = {(vu)(ray->key), (vu)(ray->index)};
#else
  const OpacityKey key = {(vu)(0u), (vu)(0u)};
#endif
  return key;
}

#endif
