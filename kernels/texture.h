// SPDX-License-Identifier: Apache-2.0
// Images: 8 bits per channel as their files have them, decoded where they are looked up. There are no mipmaps: the many
// samples of a pixel are the filter, and a blurred level would be an error that no number of samples removes.
#ifndef EK_TEXTURE_H
#define EK_TEXTURE_H
#include "math.h"
#include "scene_data.h"

typedef struct { vf x, y, z, w; } v4;

// Index of a texel along one axis. i: any integer as float; NaN and what is beyond 2^30 give texel 0.
EK_FN vu texture_wrap(vf i, vu size, vi clamp, vi mirror) {
  const vf n = TO_F(AS_I(size));
  const vf period = mirror ? n + n : n;
  const vi sane = abs_f(i) < 0x1p30f;
  const vf bounded = sane ? i : (vf)(0.0f);
  const vf turns = TO_F(TO_I(bounded / period));
  vf k = bounded - turns * period;        // exact: a multiple of 1 below 2^24, but for far away coordinates
  k = k < 0.0f ? k + period : k;          // [0, period)
  k = (mirror & (k >= n)) ? (period - 1.0f) - k : k;
  const vf ends = bounded < 0.0f ? (vf)(0.0f) : bounded;
  k = clamp ? ends : k;
  k = k > n - 1.0f ? n - 1.0f : k;
  k = k > 0.0f ? k : (vf)(0.0f);
  return AS_U(TO_I(k));
}

EK_FN vf floor_f(vf x) {
  const vf whole = TO_F(TO_I(x));
  return whole > x ? whole - 1.0f : whole;
}

EK_FN v4 texel_decode(global const uint* texels, vu word, vi srgb) {
  const vu r = word & 255u, g = (word >> 8) & 255u, b = (word >> 16) & 255u, a = word >> 24;
  v4 c = {TO_F(AS_I(r)) / 255.0f, TO_F(AS_I(g)) / 255.0f, TO_F(AS_I(b)) / 255.0f, TO_F(AS_I(a)) / 255.0f};
  if (ANY(srgb)) {
    global const float* table = (global const float*)texels;
    c.x = srgb ? gather_f(table, r) : c.x;
    c.y = srgb ? gather_f(table, g) : c.y;
    c.z = srgb ? gather_f(table, b) : c.z;
  }
  return c;
}

EK_FN v4 texture_mix(v4 a, v4 b, vf t) {
  v4 c = {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t, a.w + (b.w - a.w) * t};
  return c;
}

/// Value of texture `texture` (a valid index) at the mesh's coordinates: linear, [0, 1].
/// uv0_u ...  TEXCOORD_0 and TEXCOORD_1; the texture says which of them counts, and how it is transformed
EK_FN v4 texture_sample(global const TextureRecord* textures, global const uint* texels, vu texture, vf uv0_u, vf uv0_v,
                        vf uv1_u, vf uv1_v) {
  const Rec r = rec16(textures, texture);
  const vu first = AS_U(r.w0), width = AS_U(r.w1), height = AS_U(r.w2), flags = AS_U(r.w3);
  vf mesh_u = uv0_u, mesh_v = uv0_v;
  if (EK_HAS_uv1) {
    const vi second = (flags & EK_TEXTURE_UV1) != 0u;
    mesh_u = second ? uv1_u : mesh_u;
    mesh_v = second ? uv1_v : mesh_v;
  }
  const vf u = (r.w4 * mesh_u + r.w5 * mesh_v) + r.w6;
  const vf v = (r.w7 * mesh_u + r.w8 * mesh_v) + r.w9;
  const vi nearest = (flags & EK_TEXTURE_NEAREST) != 0u, srgb = (flags & EK_TEXTURE_SRGB) != 0u;
  const vi clamp_u = (flags & EK_TEXTURE_CLAMP_U) != 0u, mirror_u = (flags & EK_TEXTURE_MIRROR_U) != 0u;
  const vi clamp_v = (flags & EK_TEXTURE_CLAMP_V) != 0u, mirror_v = (flags & EK_TEXTURE_MIRROR_V) != 0u;
  vf x = u * TO_F(AS_I(width)), y = v * TO_F(AS_I(height));
  x = abs_f(x) < 0x1p30f ? x : (vf)(0.0f);  // NaN too
  y = abs_f(y) < 0x1p30f ? y : (vf)(0.0f);
  x = nearest ? x : x - 0.5f;
  y = nearest ? y : y - 0.5f;
  const vf x0 = floor_f(x), y0 = floor_f(y);
  const vu left = texture_wrap(x0, width, clamp_u, mirror_u), right = texture_wrap(x0 + 1.0f, width, clamp_u, mirror_u);
  const vu top = texture_wrap(y0, height, clamp_v, mirror_v), bottom = texture_wrap(y0 + 1.0f, height, clamp_v, mirror_v);
  const vu row0 = first + top * width, row1 = first + bottom * width;
  const v4 c00 = texel_decode(texels, gather_u(texels, row0 + left), srgb);
  if (!ANY(!nearest)) return c00;
  const v4 c10 = texel_decode(texels, gather_u(texels, row0 + right), srgb);
  const v4 c01 = texel_decode(texels, gather_u(texels, row1 + left), srgb);
  const v4 c11 = texel_decode(texels, gather_u(texels, row1 + right), srgb);
  const vf tx = nearest ? (vf)(0.0f) : x - x0, ty = nearest ? (vf)(0.0f) : y - y0;
  return texture_mix(texture_mix(c00, c10, tx), texture_mix(c01, c11, tx), ty);
}

#endif
