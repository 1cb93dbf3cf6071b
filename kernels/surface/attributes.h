// SPDX-License-Identifier: Apache-2.0
// What the corners of a triangle say about a point of it. Each record of the triangle is loaded once; what nothing reads of
// the result costs nothing.
#ifndef EK_ATTRIBUTES_H
#define EK_ATTRIBUTES_H
#include "lanes/math.h"
#include "surface/scene_data.h"

typedef struct {
  v3 normal;                            // of the vertex normals, not unit; zero: the triangle is flat
  vf uv0_u, uv0_v, uv1_u, uv1_v;        // TEXCOORD_0 and TEXCOORD_1
  v3 tangent;                           // not unit; zero: none
  vf bitangent_sign;
  vf color_r, color_g, color_b, color_a;  // COLOR_0: linear, and opacity; 1 where the mesh has none
} HitAttributes;

// u, v: weights of b and c. What is the same at all corners comes out exactly.
EK_FN vf interpolate(vf a, vf b, vf c, vf u, vf v) { return a + (u * (b - a) + v * (c - a)); }

/// Of a triangle whose corners say nothing.
EK_FN HitAttributes no_attributes(void) {
  const vf zero = (vf)(0.0f), one = (vf)(1.0f);
  HitAttributes at = {V3(zero, zero, zero), zero, zero, zero, zero, V3(zero, zero, zero), one, one, one, one, one};
  return at;
}

/// u, v: weights of the second and third corner of `triangle`.
EK_FN HitAttributes hit_attributes(SceneData scene, vu triangle, vf u, vf v) {
  HitAttributes at = no_attributes();
  if (EK_HAS_vertex_normal | EK_HAS_uv) {
    const Rec r = rec16(scene.triangle_normals, triangle);
    if (EK_HAS_vertex_normal)
      at.normal = V3(interpolate(r.w0, r.w3, r.w6, u, v), interpolate(r.w1, r.w4, r.w7, u, v),
                     interpolate(r.w2, r.w5, r.w8, u, v));
    if (EK_HAS_uv) {
      at.uv0_u = interpolate(r.w9, r.wb, r.wd, u, v);
      at.uv0_v = interpolate(r.wa, r.wc, r.we, u, v);
    }
  }
  if (EK_HAS_tangent | EK_HAS_uv1) {
    const Rec r = rec16(scene.triangle_tangents, triangle);
    if (EK_HAS_tangent) {
      at.tangent = V3(interpolate(r.w0, r.w3, r.w6, u, v), interpolate(r.w1, r.w4, r.w7, u, v),
                      interpolate(r.w2, r.w5, r.w8, u, v));
      at.bitangent_sign = r.w9;
    }
    if (EK_HAS_uv1) {
      at.uv1_u = interpolate(r.wa, r.wc, r.we, u, v);
      at.uv1_v = interpolate(r.wb, r.wd, r.wf, u, v);
    }
  }
  if (EK_HAS_vertex_color) {
    const Rec r = rec16(scene.triangle_colors, triangle);
    at.color_r = interpolate(r.w0, r.w4, r.w8, u, v);
    at.color_g = interpolate(r.w1, r.w5, r.w9, u, v);
    at.color_b = interpolate(r.w2, r.w6, r.wa, u, v);
    at.color_a = interpolate(r.w3, r.w7, r.wb, u, v);
  }
  return at;
}

#endif
