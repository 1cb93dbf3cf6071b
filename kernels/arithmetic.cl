// SPDX-License-Identifier: Apache-2.0
// Arithmetic probe: what the operations and functions that decide images give on this device, folded into words that must
// be the same everywhere. A driver that contracts, reorders or approximates shows here.
//   arithmetic_out  EK_ARITHMETIC_WORDS words, written by one work-item
#include "sampler.h"
#include "surface.h"
#include "warp.h"

// A float of random mantissa and sign and an exponent from -16 to 15: no result below is a denormal, which devices may flush.
EK_FN vf arithmetic_operand(vu bits) {
  return AS_F((bits & 0x807fffffu) | ((111u + ((bits >> 23) & 31u)) << 23));
}

kernel void arithmetic(global uint* arithmetic_out) {
  for (uint i = 0; i < EK_ARITHMETIC_WORDS; i += EK_WIDTH) {
    const vu seed = (vu)(i) + LANE_INDEX;
    vu fold = hash_bits(seed);
    for (uint round = 0; round < 16; ++round) {
      const vu key = hash_bits(seed * 64u + round);
      const vf a = arithmetic_operand(key), b = arithmetic_operand(hash_bits(key + 1u)), c = arithmetic_operand(hash_bits(key + 2u));
      fold = hash_bits(fold ^ AS_U(a + b));
      fold = hash_bits(fold ^ AS_U(a * b + c));  // differs when contracted
      fold = hash_bits(fold ^ AS_U(a / b));
      fold = hash_bits(fold ^ AS_U(sqrt(abs_f(a))));
      fold = hash_bits(fold ^ AS_U(dot3(V3(a, b, c), V3(c, a, b))));
      vf u, v, s, k;
      sample_2d(key, seed, round, &u, &v);
      sincos_2pi(u, &s, &k);
      fold = hash_bits(fold ^ AS_U(s));
      fold = hash_bits(fold ^ AS_U(k));
      const v3 w = to_world(basis_around(normalize3(V3(a, b, c))), warp_cosine_hemisphere(u, v));
      fold = hash_bits(fold ^ AS_U(w.x) ^ (AS_U(w.y) << 1) ^ (AS_U(w.z) << 2));
    }
    store_u(arithmetic_out + i, fold);
  }
}

// Sizes of the shared records and the offset of each one's last field, as this device lays them out.
kernel void record_layout(global uint* layout_out) {
  layout_out[0] = sizeof(Frame);
  layout_out[1] = (uint)(size_t)&((Frame*)0)->pixel_stride;
  layout_out[2] = sizeof(Triangle);
  layout_out[3] = (uint)(size_t)&((Triangle*)0)->node;
  layout_out[4] = sizeof(TriangleNormals);
  layout_out[5] = (uint)(size_t)&((TriangleNormals*)0)->n2_z;
  layout_out[6] = sizeof(MaterialRecord);
  layout_out[7] = (uint)(size_t)&((MaterialRecord*)0)->double_sided;
  layout_out[8] = sizeof(Light);
  layout_out[9] = (uint)(size_t)&((Light*)0)->triangle;
  layout_out[10] = sizeof(LightBucket);
  layout_out[11] = (uint)(size_t)&((LightBucket*)0)->scale_alias;
  layout_out[12] = sizeof(Diagnostics);
  layout_out[13] = (uint)(size_t)&((Diagnostics*)0)->report;
}
