// SPDX-License-Identifier: Apache-2.0
// The transformation of the corners, normals and tangents of a mesh that has many instances and is
// stored once: each is that of the instance, in the world. The host compiles this file too
// (host/gltf/geometry/instance_transform.cpp), for meshes that could be stored once but are stored
// for each instance after all. The operations and their order are the same, so every number of a
// hit has the same bits either way.
#ifndef EK_INSTANCE_H
#define EK_INSTANCE_H
#include "lanes/math.h"

// World from mesh: the rows of the matrix, and the translation.
typedef struct {
  v3 x, y, z, t;
} InstanceTransform;

EK_FN v3 instance_direction(InstanceTransform m, v3 d) { return V3(dot3(m.x, d), dot3(m.y, d), dot3(m.z, d)); }
EK_FN v3 instance_point(InstanceTransform m, v3 p) { return add3(instance_direction(m, p), m.t); }

// a / |a| for any finite a, and zero for zero. Scaling by a power of two keeps the square in range.
EK_FN v3 unit_or_zero(v3 a) {
  const vf size = max_component(abs3(a));
  const vi some = (size > 0x1p-100f) & (size < 0x1p+100f);
  const v3 unit = normalize3(scale3(a, inverse_power_of_two(some ? size : (vf)(1.0f))));
  return select3(some, unit, V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f)));
}

/// A normal of the mesh, unit or zero, in the world. The matrix of cofactors takes it there: it is
/// the inverse transpose times the determinant, and is defined for flat instances too.
/// facing  as in InstanceRecord: -1 where the matrix mirrors, else 1
EK_FN v3 instance_normal(InstanceTransform m, vf facing, v3 n) {
  const v3 turned = V3(dot3(cross3(m.y, m.z), n), dot3(cross3(m.z, m.x), n), dot3(cross3(m.x, m.y), n));
  return unit_or_zero(scale3(turned, facing));
}

// a b - c d, whose relative error is some 2^-24 however near the products are, because their
// rounding errors are found exactly [Dekker 1971].
EK_FN vf exact_product_error(vf a, vf b, vf product) {
  const vf a_hi = AS_F(AS_U(a) & 0xfffff000u), b_hi = AS_F(AS_U(b) & 0xfffff000u), a_lo = a - a_hi, b_lo = b - b_hi;
  return (((a_hi * b_hi - product) + a_hi * b_lo) + a_lo * b_hi) + a_lo * b_lo;
}
EK_FN vf products_difference(vf a, vf b, vf c, vf d) {
  const vf ab = a * b, cd = c * d;
  return (ab - cd) + (exact_product_error(a, b, ab) - exact_product_error(c, d, cd));
}

/// (p1 - p0) x (p2 - p0), unit, of products_difference; zero where the triangle has no area.
EK_FN v3 accurate_triangle_normal(v3 p0, v3 p1, v3 p2) {
  const v3 a = sub3(p1, p0), b = sub3(p2, p0);
  return unit_or_zero(V3(products_difference(a.y, b.z, a.z, b.y), products_difference(a.z, b.x, a.x, b.z),
                         products_difference(a.x, b.y, a.y, b.x)));
}

#endif
