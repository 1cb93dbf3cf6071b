// SPDX-License-Identifier: Apache-2.0
// Light from infinitely far away by an equirectangular map: its value in a direction, and its
// sampling.
//   In the map's own axes the centre of the picture is -Z, +Y is up, and u grows towards +X. The
//   world is that turned about +Y by the angle of environment_sin and environment_cos:
//   world = R map, R (x, z) = (cos x + sin z, -sin x + cos z).
//   Positions are counted in texels: x = width (1/2 + turns of azimuth) in [0, width], y = height
//   polar angle / pi from the top. Texel (i, j) is the cell [i, i+1) x [j, j+1). Radiance is
//   interpolated bilinearly between the cells' centres. It is periodic in x, and constant within
//   half a texel of a pole.
//   Sampling chooses a cell by the mean of the interpolated radiance over it times its exact solid
//   angle (host/pack/lights/pack_environment.cpp), and in the cell a direction uniform in solid
//   angle: azimuth and cosine of the polar angle are linear. So the density, which is stored with
//   each texel, is constant over the cell, and exact up to the poles.
#ifndef EK_ENVIRONMENT_MAP_H
#define EK_ENVIRONMENT_MAP_H
#include "lanes/math.h"
#include "lights/alias_table.h"

typedef struct { vf x, y; } MapPlace;

typedef struct {
  v3 radiance;  // W / (sr m^2)
  vf pdf;       // of light sampling, per sr, selection of the map included
} MapValue;

EK_FN v3 map_from_world(constant Frame* frame, v3 d) {
  const float s = frame->environment_sin, c = frame->environment_cos;
  return V3(d.x * c - d.z * s, d.y, d.x * s + d.z * c);
}
EK_FN v3 world_from_map(constant Frame* frame, v3 d) {
  const float s = frame->environment_sin, c = frame->environment_cos;
  return V3(d.x * c + d.z * s, d.y, d.z * c - d.x * s);
}

// x where it lies in [0, size], else 0, so that indices made of it are valid.
EK_FN vf within(vf x, float size) { return ((x >= 0.0f) & (x <= size)) ? x : (vf)(0.0f); }

EK_FN MapPlace map_place(constant Frame* frame, v3 dir) {
  const v3 d = map_from_world(frame, dir);
  const float width = (float)frame->environment_width, height = (float)frame->environment_height;
  // The polar angle comes from its sine and cosine, since its cosine alone is flat near the poles.
  const vf polar = atan2_turns(sqrt_f(d.x * d.x + d.z * d.z), d.y);
  MapPlace place = {within((atan2_turns(d.x, -d.z) + 0.5f) * width, width), within((polar * 2.0f) * height, height)};
  return place;
}

/// Index of the texel whose cell holds a place.
EK_FN vu map_texel(constant Frame* frame, MapPlace place) {
  const vu width = (vu)(frame->environment_width), height = (vu)(frame->environment_height);
  const vu i = AS_U(TO_I(place.x)), j = AS_U(TO_I(place.y));  // rounds down: neither is negative
  return (j < height ? j : height - 1u) * width + (i < width ? i : (vu)(0u));
}

EK_FN v3 map_texel_radiance(global const float4* texels, vu texel) {
  global const float* words = (global const float*)texels;
  return V3(gather_f(words, texel * 4u), gather_f(words, texel * 4u + 1u), gather_f(words, texel * 4u + 2u));
}

EK_FN v3 mix3(v3 a, v3 b, vf t) { return add3(scale3(a, 1.0f - t), scale3(b, t)); }

EK_FN v3 map_radiance(constant Frame* frame, global const float4* texels, MapPlace place) {
  const vu width = (vu)(frame->environment_width), last_row = (vu)(frame->environment_height - 1u);
  // The cells whose centres are left of and above the place, plus 1, so that they are not negative.
  const vf x = place.x + 0.5f, y = place.y + 0.5f;
  const vi right = TO_I(x), below = TO_I(y);
  const vf tx = x - TO_F(right), ty = y - TO_F(below);
  const vu i1 = AS_U(right) < width ? AS_U(right) : (vu)(0u);
  const vu i0 = right > 0 ? AS_U(right) - 1u : width - 1u;
  const vu j1 = AS_U(below) < last_row ? AS_U(below) : last_row;
  const vu j0 = below > 0 ? AS_U(below) - 1u : (vu)(0u);
  const vu row0 = j0 * width, row1 = j1 * width;
  return mix3(mix3(map_texel_radiance(texels, row0 + i0), map_texel_radiance(texels, row0 + i1), tx),
              mix3(map_texel_radiance(texels, row1 + i0), map_texel_radiance(texels, row1 + i1), tx), ty);
}

/// Radiance from the unit world direction `dir`, and the density with which environment_map_sample
/// chooses it.
EK_FN MapValue environment_map_value(constant Frame* frame, global const float4* texels, v3 dir) {
  const MapPlace place = map_place(frame, dir);
  MapValue value = {map_radiance(frame, texels, place),
                    gather_f((global const float*)texels, map_texel(frame, place) * 4u + 3u)};
  return value;
}

/// Samples a direction: world, unit, in the cell of density value->pdf.
/// a, b  pair of sample_2d_bits
// The density is that of the chosen cell, and not of the cell in which the rounded direction may
// lie: beside a bright cell the latter would weight a few samples thousands of times too much.
EK_FN v3 environment_map_sample(constant Frame* frame, global const float4* texels, global const AliasEntry* table, vu a,
                                vu b, MapValue* value) {
  const uint width = frame->environment_width, height = frame->environment_height;
  const AliasSample choice = alias_table_sample(table, width * height, a, b);
  // row = texel / width; the quotient of floats is off by at most 1.
  vu row = AS_U(TO_I(div_f(TO_F(AS_I(choice.index)), (float)width)));
  row = row * width > choice.index ? row - 1u : row;
  row = choice.index - row * width >= width ? row + 1u : row;
  const vu column = choice.index - row * width;
  // 1 - |cos| = 2 sin^2 of half the angle from the nearer pole, which is exact near it.
  const vi south = row + row >= height;
  const vf from_pole = TO_F(AS_I(south ? (height - 1u) - row : row));
  vf inner, outer, unused;
  sincos_2pi(div_f(from_pole, 4.0f * (float)height), &inner, &unused);
  sincos_2pi(div_f(from_pole + 1.0f, 4.0f * (float)height), &outer, &unused);
  const vf least = 2.0f * (inner * inner);
  const vf versine = least + choice.v * (2.0f * (outer * outer) - least);
  const vf cos_polar = south ? versine - 1.0f : 1.0f - versine;
  const vf sin_polar = sqrt_f(versine * (2.0f - versine));
  MapPlace place;
  place.x = TO_F(AS_I(column)) + choice.u;
  place.y = within((atan2_turns(sin_polar, cos_polar) * 2.0f) * (float)height, (float)height);
  value->radiance = map_radiance(frame, texels, place);
  value->pdf = gather_f((global const float*)texels, choice.index * 4u + 3u);
  vf s, c;
  sincos_2pi(div_f(place.x, (float)width) - 0.5f, &s, &c);
  return world_from_map(frame, V3(sin_polar * s, cos_polar, -(sin_polar * c)));
}

#endif
