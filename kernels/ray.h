// SPDX-License-Identifier: Apache-2.0
// A ray made ready for boxes and triangles. Every traversal uses these numbers and the interval rule below, which is why
// every layout, and no tree at all, gives bit-identical hits:
//   - the interval of a box is max over axes of (near plane - o_near) * r, and 0, to the min of (far plane - o_far) * r, with
//     r = 1 / d. o_near and o_far are the origin moved by `pad` against and along the ray: boxes grow by pad without a
//     change to their planes. All rounding is monotone, so the interval of a box lies inside that of any box around it;
//   - a triangle accepts t only inside the interval of its own corners' box (shape_triangle.h), so no ancestor of it can
//     be rejected before it has been tried;
//   - a box is visited if its interval is not empty and begins at or before the best t so far: ties survive.
// r is finite: |d| counts as at least 2^-80 of the longest component. pad bounds what rounding can move a hit by: with E the
// farthest extent of the scene from the origin, shear and edge tests err by less than 8 units of 2^-24 E, the sums o +- pad by
// |o| 2^-24; each has a factor of two and more to spare. Nothing here is absolute: scene and rays times 2^k give the same bits.
#ifndef EK_RAY_H
#define EK_RAY_H
#include "alpha.h"

// o: origin, d's reciprocal r, padded origins n (near) and f (far), in world axes; the same with p_ in the axes of the
// triangle test, whose z is the longest component of d; s: shear; axis: which axis that z is.
#define EK_RAY_FIELDS(F)                                                                                               \
  F(rx) F(ry) F(rz) F(nx) F(ny) F(nz) F(fx) F(fy) F(fz) F(p_ox) F(p_oy) F(p_oz) F(p_rx) F(p_ry) F(p_rz) F(p_nx) F(p_ny) \
  F(p_nz) F(p_fx) F(p_fy) F(p_fz) F(sx) F(sy) F(axis) F(reach)

// Words of the ray's OpacityKey (alpha.h).
#if EK_HAS_opacity
#define EK_RAY_WORDS(F) F(key) F(index)
#else
#define EK_RAY_WORDS(F)
#endif

typedef struct {
#define EK_RAY_FIELD(name) vf name;
  EK_RAY_FIELDS(EK_RAY_FIELD)
#undef EK_RAY_FIELD
#define EK_RAY_WORD(name) vu name;
  EK_RAY_WORDS(EK_RAY_WORD)
#undef EK_RAY_WORD
} RayLanes;

typedef struct {
#define EK_RAY_FIELD(name) float name;
  EK_RAY_FIELDS(EK_RAY_FIELD)
#undef EK_RAY_FIELD
#define EK_RAY_WORD(name) uint name;
  EK_RAY_WORDS(EK_RAY_WORD)
#undef EK_RAY_WORD
} RayOne;

// So many rays are traced in one go, in rows of tables.
#if EK_WIDTH == 1
#define EK_ROWS 1
#else
#define EK_ROWS 64
#endif
#define EK_ROWS_ALIGNED __attribute__((aligned(4 * EK_WIDTH)))

typedef struct {
#define EK_RAY_FIELD(name) float name[EK_ROWS] EK_ROWS_ALIGNED;
  EK_RAY_FIELDS(EK_RAY_FIELD)
#undef EK_RAY_FIELD
#define EK_RAY_WORD(name) uint name[EK_ROWS] EK_ROWS_ALIGNED;
  EK_RAY_WORDS(EK_RAY_WORD)
#undef EK_RAY_WORD
} RayTable;

EK_FN void ray_store(RayTable* table, uint row, RayLanes ray) {
#define EK_RAY_FIELD(name) *(vf*)(table->name + row) = ray.name;
  EK_RAY_FIELDS(EK_RAY_FIELD)
#undef EK_RAY_FIELD
#define EK_RAY_WORD(name) *(vu*)(table->name + row) = ray.name;
  EK_RAY_WORDS(EK_RAY_WORD)
#undef EK_RAY_WORD
}
EK_FN OpacityKey ray_key(const RayLanes* ray) {
  OpacityKey key = {(vu)(0u), (vu)(0u)};
#define EK_RAY_WORD(name) key.name = ray->name;
  EK_RAY_WORDS(EK_RAY_WORD)
#undef EK_RAY_WORD
  return key;
}
EK_FN OpacityKey ray_key_one(const RayOne* ray) {  // in all lanes
  OpacityKey key = {(vu)(0u), (vu)(0u)};
#define EK_RAY_WORD(name) key.name = (vu)(ray->name);
  EK_RAY_WORDS(EK_RAY_WORD)
#undef EK_RAY_WORD
  return key;
}
EK_FN RayOne ray_pick(const RayTable* table, uint row) {
  RayOne ray;
#define EK_RAY_FIELD(name) ray.name = table->name[row];
  EK_RAY_FIELDS(EK_RAY_FIELD)
#undef EK_RAY_FIELD
#define EK_RAY_WORD(name) ray.name = table->name[row];
  EK_RAY_WORDS(EK_RAY_WORD)
#undef EK_RAY_WORD
  return ray;
}

// Components of `a` in the axes of the triangle test: z is the longest of d (the last of equals), x and y follow cyclically.
EK_FN v3 permute3(v3 a, vi z_is_x, vi z_is_y) {
  return V3(z_is_x ? a.y : z_is_y ? a.z : a.x, z_is_x ? a.z : z_is_y ? a.x : a.y, z_is_x ? a.x : z_is_y ? a.y : a.z);
}

EK_FN vf reciprocal_component(vf d, vf least) {
  return (vf)(1.0f) / (abs_f(d) < least ? (d < 0.0f ? -least : least) : d);
}

// `d` need not be unit; t counts in its lengths.
EK_FN RayLanes ray_lanes(constant Frame* frame, v3 o, v3 d, OpacityKey key) {
  const v3 size = abs3(d);
  const vf least = max_f(max_component(size) * 0x1p-80f, (vf)(0x1p-126f));
  const v3 r = V3(reciprocal_component(d.x, least), reciprocal_component(d.y, least), reciprocal_component(d.z, least));

  const v3 extent = add3(abs3(sub3(o, splat3(frame->scene_center))), splat3(frame->scene_half));
  const vf reach = max_component(extent);
  const vf pad = reach * 0x1p-19f + max_component(abs3(o)) * 0x1p-23f;
  const v3 along = V3(r.x < 0.0f ? -pad : pad, r.y < 0.0f ? -pad : pad, r.z < 0.0f ? -pad : pad);
  const v3 n = add3(o, along), f = sub3(o, along);

  const vi z_is_x = (size.x > size.y) & (size.x > size.z);
  const vi z_is_y = (!z_is_x) & (size.y > size.z);
  const v3 pd = permute3(d, z_is_x, z_is_y), po = permute3(o, z_is_x, z_is_y), pr = permute3(r, z_is_x, z_is_y);
  const v3 pn = permute3(n, z_is_x, z_is_y), pf = permute3(f, z_is_x, z_is_y);

  RayLanes ray;
#define EK_RAY_WORD(name) ray.name = key.name;
  EK_RAY_WORDS(EK_RAY_WORD)
#undef EK_RAY_WORD
  ray.rx = r.x; ray.ry = r.y; ray.rz = r.z;
  ray.nx = n.x; ray.ny = n.y; ray.nz = n.z;
  ray.fx = f.x; ray.fy = f.y; ray.fz = f.z;
  ray.p_ox = po.x; ray.p_oy = po.y; ray.p_oz = po.z;
  ray.p_rx = pr.x; ray.p_ry = pr.y; ray.p_rz = pr.z;
  ray.p_nx = pn.x; ray.p_ny = pn.y; ray.p_nz = pn.z;
  ray.p_fx = pf.x; ray.p_fy = pf.y; ray.p_fz = pf.z;
  ray.sx = pd.x / pd.z;
  ray.sy = pd.y / pd.z;
  ray.reach = reach;
  ray.axis = z_is_x ? (vf)(0.0f) : z_is_y ? (vf)(1.0f) : (vf)(2.0f);
  return ray;
}

#endif
