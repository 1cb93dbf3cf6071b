// SPDX-License-Identifier: Apache-2.0
// Textures. Texels have 8 bits per channel, as in their files, and are decoded when they are looked
// up. There are no mipmaps: the many samples of a pixel filter the texture, and a blurred level
// would be an error that no number of samples removes.
#ifndef EK_TEXTURE_H
#define EK_TEXTURE_H
#include "surface/attributes.h"

typedef struct { vf x, y, z, w; } v4;

/// The largest integer that is not above x, |x| < 2^31.
EK_FN vf floor_f(vf x) {
  const vf whole = TO_F(TO_I(x));
  return whole > x ? whole - 1.0f : whole;
}

/// The two texels along one axis that a coordinate lies between, and the weight of the second.
typedef struct {
  vu first, second;
  vf weight;
} TexelPair;

/// The texel of index i, which may lie up to one period outside of the image.
EK_FN vu texel_wrap(vi i, vi size, vi clamp, vi mirror) {
  const vi before = clamp | mirror ? i : i + size;
  const vi inside = clamp ? size - 1 : i - size;
  const vi past = mirror ? size + size - 1 - i : inside;
  const vi k = i < 0 ? before : i >= size ? past : i;
  return AS_U(k < 0 ? (vi)(0) : k);
}

/// The texels on both sides of coordinate x, in units of the image's extent. x may be any float;
/// one that is not finite counts as 0 where the image repeats.
/// source  [OpenGL 4.6 core profile, section 8.14.2]. Whole periods are taken off first, because
///         far from 0 the fraction of a float is exact, but its product with the size is not.
EK_FN TexelPair texels_along(vf x, vu texels, vi clamp, vi mirror, vi nearest) {
  const vi size = AS_I(texels);
  const vf turns = mirror ? (vf)(2.0f) : (vf)(1.0f);
  const vf near = abs_f(x) < 0x1p24f ? x : (vf)(0.0f);  // beyond, every float is even
  const vf rest = near - turns * floor_f(mirror ? 0.5f * near : near);
  // From just below 0 the rest rounds to the whole period.
  const vf within = rest < turns ? rest : turns * 0x1.fffffep-1f;
  const vf bounded = x > 0.0f ? (x < 1.0f ? x : (vf)(1.0f)) : (vf)(0.0f);
  const vf place = (clamp ? bounded : within) * TO_F(size) - (nearest ? (vf)(0.0f) : (vf)(0.5f));
  const vf whole = floor_f(place);
  const vi i = TO_I(whole);
  TexelPair pair = {texel_wrap(i, size, clamp, mirror), texel_wrap(i + 1, size, clamp, mirror),
                    nearest ? (vf)(0.0f) : place - whole};
  return pair;
}

/// Linear values in [0, 1] for R, G, B of sRGB textures; the codes, 0 to 255, for others, and
/// always for A. The table is exact, and on CPUs no slower than a polynomial of degree 9, whose
/// error is 4e-6.
EK_FN v4 texel_decode(global const uint* texels, vu word, vi srgb) {
  const vu r = word & 255u, g = (word >> 8) & 255u, b = (word >> 16) & 255u, a = word >> 24;
  v4 c = {TO_F(AS_I(r)), TO_F(AS_I(g)), TO_F(AS_I(b)), TO_F(AS_I(a))};
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

/// Value of a texture at the mesh's coordinates, linear, [0, 1]. The texture says which of the two
/// coordinates it uses, and how it transforms them.
EK_FN v4 texture_sample(global const uint* texels, TextureLanes t, HitAttributes at) {
  vf mesh_u = at.uv0_u, mesh_v = at.uv0_v;
  if (EK_HAS_uv1) {
    const vi second = (t.flags & EK_TEXTURE_UV1) != 0u;
    mesh_u = second ? at.uv1_u : mesh_u;
    mesh_v = second ? at.uv1_v : mesh_v;
  }
  const vf u = (t.u_u * mesh_u + t.u_v * mesh_v) + t.u_1;
  const vf v = (t.v_u * mesh_u + t.v_v * mesh_v) + t.v_1;
  const vi nearest = (t.flags & EK_TEXTURE_NEAREST) != 0u, srgb = (t.flags & EK_TEXTURE_SRGB) != 0u;
  const TexelPair x = texels_along(u, t.width, (t.flags & EK_TEXTURE_CLAMP_U) != 0u,
                                   (t.flags & EK_TEXTURE_MIRROR_U) != 0u, nearest);
  const TexelPair y = texels_along(v, t.height, (t.flags & EK_TEXTURE_CLAMP_V) != 0u,
                                   (t.flags & EK_TEXTURE_MIRROR_V) != 0u, nearest);
  const vu top = t.first_texel + y.first * t.width;
  v4 c = texel_decode(texels, gather_u(texels, top + x.first), srgb);
  if (ANY(!nearest)) {
    const vu bottom = t.first_texel + y.second * t.width;
    const v4 c10 = texel_decode(texels, gather_u(texels, top + x.second), srgb);
    const v4 c01 = texel_decode(texels, gather_u(texels, bottom + x.first), srgb);
    const v4 c11 = texel_decode(texels, gather_u(texels, bottom + x.second), srgb);
    c = texture_mix(texture_mix(c, c10, x.weight), texture_mix(c01, c11, x.weight), y.weight);
  }
  c.x = srgb ? c.x : div_f(c.x, 255.0f);
  c.y = srgb ? c.y : div_f(c.y, 255.0f);
  c.z = srgb ? c.z : div_f(c.z, 255.0f);
  c.w = div_f(c.w, 255.0f);
  return c;
}

#endif
