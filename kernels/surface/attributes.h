// SPDX-License-Identifier: Apache-2.0
// Vertex attributes of a triangle, interpolated at a point of it. Each record of the triangle is
// loaded once; a field of the result that nothing reads costs nothing.
#ifndef EK_ATTRIBUTES_H
#define EK_ATTRIBUTES_H
#include "lanes/math.h"
#include "surface/scene_data.h"

typedef struct {
  v3 normal;                      // of the vertex normals, not unit; zero: the triangle is flat
  vf uv0_u, uv0_v, uv1_u, uv1_v;  // TEXCOORD_0 and TEXCOORD_1
  v3 tangent;                     // not unit; zero: none
  vf bitangent_sign;
  // COLOR_0, linear, and opacity; 1 where the mesh has none.
  vf color_r, color_g, color_b, color_a;
} HitAttributes;

// u, v: weights of b and c. A value that is the same at all corners comes out exactly.
EK_FN vf interpolate(vf a, vf b, vf c, vf u, vf v) { return a + (u * (b - a) + v * (c - a)); }
EK_FN v3 interpolate3(v3 a, v3 b, v3 c, vf u, vf v) {
  return V3(interpolate(a.x, b.x, c.x, u, v), interpolate(a.y, b.y, c.y, u, v), interpolate(a.z, b.z, c.z, u, v));
}

/// The attributes of a triangle without vertex attributes.
EK_FN HitAttributes no_attributes(void) {
  const vf zero = (vf)(0.0f), one = (vf)(1.0f);
  HitAttributes at = {V3(zero, zero, zero), zero, zero, zero, zero, V3(zero, zero, zero), one, one, one, one, one};
  return at;
}

/// The attributes of `triangle` where its second and third corner have weights u and v.
EK_FN HitAttributes hit_attributes(SceneData scene, vu triangle, vf u, vf v) {
  HitAttributes at = no_attributes();
  if (EK_HAS_vertex_normal | EK_HAS_uv) {
    const TriangleNormalsLanes r = load_triangle_normals(scene.triangle_normals, triangle);
    if (EK_HAS_vertex_normal) at.normal = interpolate3(r.n0, r.n1, r.n2, u, v);
    if (EK_HAS_uv) {
      at.uv0_u = interpolate(r.u0, r.u1, r.u2, u, v);
      at.uv0_v = interpolate(r.v0, r.v1, r.v2, u, v);
    }
  }
  if (EK_HAS_tangent | EK_HAS_uv1) {
    const TriangleTangentsLanes r = load_triangle_tangents(scene.triangle_tangents, triangle);
    if (EK_HAS_tangent) {
      at.tangent = interpolate3(r.t0, r.t1, r.t2, u, v);
      at.bitangent_sign = r.bitangent_sign;
    }
    if (EK_HAS_uv1) {
      at.uv1_u = interpolate(r.u0, r.u1, r.u2, u, v);
      at.uv1_v = interpolate(r.v0, r.v1, r.v2, u, v);
    }
  }
  if (EK_HAS_vertex_color) {
    const TriangleColorsLanes r = load_triangle_colors(scene.triangle_colors, triangle);
    at.color_r = interpolate(r.rgb0.x, r.rgb1.x, r.rgb2.x, u, v);
    at.color_g = interpolate(r.rgb0.y, r.rgb1.y, r.rgb2.y, u, v);
    at.color_b = interpolate(r.rgb0.z, r.rgb1.z, r.rgb2.z, u, v);
    at.color_a = interpolate(r.a0, r.a1, r.a2, u, v);
  }
  return at;
}

#endif
