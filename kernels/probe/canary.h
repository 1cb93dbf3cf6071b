// SPDX-License-Identifier: Apache-2.0
// Memory probe: it reads several buffers in the ways that stages do, at offsets that depend on what
// was read before, and folds what it gets into words that host/device/probes.cpp computes as well.
// A driver is known that reads element 0 for every record although its arithmetic is right.
//   canary_triangles, canary_other  EK_CANARY_RECORDS records of 16 words each
//   canary_words, canary_floats     EK_CANARY_RECORDS words each
//   canary_out                      EK_CANARY_WORDS words, written by one work-item
#ifndef EK_CANARY_H
#define EK_CANARY_H
#include "lanes/record_lanes.h"
#include "shared/canary.h"
#include "shared/records.h"

EK_FN vu canary_mix(vu x) {
  x = (x ^ (x >> 15)) * 2654435761u;
  return x ^ (x >> 13);
}
EK_FN vu canary_record(vu x) { return x & (EK_CANARY_RECORDS - 1u); }

EK_FN_ONCE void canary_run(global uint* canary_out, global const Triangle* canary_triangles,
                           global const uint* canary_other, global const uint* canary_words,
                           global const float* canary_floats) {
  for (uint i = 0; i < EK_CANARY_WORDS; i += EK_WIDTH) {
    vu fold = canary_mix((vu)(i) + LANE_INDEX);
    for (uint round = 0; round < 4; ++round) {
      const Rec r = rec16(canary_triangles, canary_record(fold));
      fold = canary_mix(fold ^ AS_U(r.w0) ^ (AS_U(r.w6) << 3) ^ (AS_U(r.wf) << 6));
      fold = canary_mix(fold ^ load_word_u(Triangle, canary_triangles, canary_record(fold), material));
      fold = canary_mix(fold ^ gather_u(canary_words, canary_record(fold)));
      fold = canary_mix(fold ^ AS_U(gather_f(canary_floats, canary_record(fold))));
      const Rec s = rec16(canary_other, canary_record(fold));
      fold = canary_mix(fold ^ AS_U(s.w1) ^ (AS_U(s.w7) << 3) ^ (AS_U(s.wc) << 6));
      fold = canary_mix(fold ^ (vu)(canary_triangles[round * 1021u + 5u].flags));
    }
    store_u(canary_out + i, fold);
  }
}

#endif
