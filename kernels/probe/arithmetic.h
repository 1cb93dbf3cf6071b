// SPDX-License-Identifier: Apache-2.0
// Arithmetic probe: it folds the results of the operations and functions on which images depend
// into words that must be the same on all devices. A driver that contracts, reorders or
// approximates gives other words.
//   arithmetic_out      EK_ARITHMETIC_WORDS words, written by one work-item
//   arithmetic_records  64 records of 16 words, any bits: whether records arrive whole
#ifndef EK_ARITHMETIC_H
#define EK_ARITHMETIC_H
#include "lanes/basis.h"
#include "lanes/sampler.h"
#include "lanes/warp.h"
#include "surface/surface.h"

// A float of random mantissa and sign and an exponent from -16 to 15: no result below is a
// denormal, which devices may flush.
EK_FN vf arithmetic_operand(vu bits) {
  return AS_F((bits & 0x807fffffu) | ((111u + ((bits >> 23) & 31u)) << 23));
}

EK_FN_ONCE void arithmetic_run(global uint* arithmetic_out, global const uint* arithmetic_records) {
  for (uint i = 0; i < EK_ARITHMETIC_WORDS; i += EK_WIDTH) {
    const vu seed = (vu)(i) + LANE_INDEX;
    vu fold = hash_bits(seed);
    const Rec r = rec16(arithmetic_records, fold & 63u);
    fold = hash_bits(fold ^ AS_U(r.w0) ^ (AS_U(r.w1) << 1) ^ (AS_U(r.w7) << 2) ^ (AS_U(r.w8) << 3) ^ (AS_U(r.wf) << 4));
    for (uint round = 0; round < 16; ++round) {
      const vu key = hash_bits(seed * 64u + round);
      const vf a = arithmetic_operand(key), b = arithmetic_operand(hash_bits(key + 1u)), c = arithmetic_operand(hash_bits(key + 2u));
      fold = hash_bits(fold ^ AS_U(a + b));
      fold = hash_bits(fold ^ AS_U(a * b + c));  // differs when contracted
      fold = hash_bits(fold ^ AS_U(div_f(a, b)));
      fold = hash_bits(fold ^ AS_U(sqrt_f(abs_f(a))));
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

#endif
