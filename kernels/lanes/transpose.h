// SPDX-License-Identifier: Apache-2.0
// The transposition of records of 16 words per lane. rec_transposed turns vectors that each hold a
// record, as it lies in memory, into vectors that each hold a word of all records, and back. Lane
// k's record is vector k with 16 lanes; with 8 it is vectors k and 8 + k. EK_REC_ROWS is a list of
// (vector, lane, offset in the record).
#ifndef EK_TRANSPOSE_H
#define EK_TRANSPOSE_H
#include "lanes/lanes.h"

#if EK_WIDTH > 1
#if EK_WIDTH == 8
#define EK_REC_ROWS(F)                                                                                \
  F(0, 0, 0) F(1, 1, 0) F(2, 2, 0) F(3, 3, 0) F(4, 4, 0) F(5, 5, 0) F(6, 6, 0) F(7, 7, 0) F(8, 0, 8) \
  F(9, 1, 8) F(a, 2, 8) F(b, 3, 8) F(c, 4, 8) F(d, 5, 8) F(e, 6, 8) F(f, 7, 8)
#define EK_INTERLEAVE_LO(a, b) __builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11)
#define EK_INTERLEAVE_HI(a, b) __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15)
// One round of the perfect shuffle; three of them transpose 8 x 8.
#define EK_ROUND(o, i)                                                                          \
  vf o##0 = EK_INTERLEAVE_LO(i##0, i##4), o##1 = EK_INTERLEAVE_HI(i##0, i##4), o##2 = EK_INTERLEAVE_LO(i##1, i##5),   \
     o##3 = EK_INTERLEAVE_HI(i##1, i##5), o##4 = EK_INTERLEAVE_LO(i##2, i##6), o##5 = EK_INTERLEAVE_HI(i##2, i##6),   \
     o##6 = EK_INTERLEAVE_LO(i##3, i##7), o##7 = EK_INTERLEAVE_HI(i##3, i##7);
EK_FN Rec rec_transposed(Rec m) {
  Rec r;
  {
    vf a0 = m.w0, a1 = m.w1, a2 = m.w2, a3 = m.w3, a4 = m.w4, a5 = m.w5, a6 = m.w6, a7 = m.w7;
    EK_ROUND(b, a) EK_ROUND(c, b) EK_ROUND(d, c)
    r.w0 = d0; r.w1 = d1; r.w2 = d2; r.w3 = d3; r.w4 = d4; r.w5 = d5; r.w6 = d6; r.w7 = d7;
  }
  {
    vf a0 = m.w8, a1 = m.w9, a2 = m.wa, a3 = m.wb, a4 = m.wc, a5 = m.wd, a6 = m.we, a7 = m.wf;
    EK_ROUND(b, a) EK_ROUND(c, b) EK_ROUND(d, c)
    r.w8 = d0; r.w9 = d1; r.wa = d2; r.wb = d3; r.wc = d4; r.wd = d5; r.we = d6; r.wf = d7;
  }
  return r;
}
#else
#define EK_REC_ROWS(F)                                                                                \
  F(0, 0, 0) F(1, 1, 0) F(2, 2, 0) F(3, 3, 0) F(4, 4, 0) F(5, 5, 0) F(6, 6, 0) F(7, 7, 0) F(8, 8, 0) \
  F(9, 9, 0) F(a, a, 0) F(b, b, 0) F(c, c, 0) F(d, d, 0) F(e, e, 0) F(f, f, 0)
// 16 x 16 in steps that processors have: words, then pairs of words within quarters, then quarters.
#define EK_EVEN_QUARTERS(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27)
#define EK_ODD_QUARTERS(a, b) __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31)
// Rows p q r s of m: quarter k of o0 .. o3 is their columns 4 k .. 4 k + 3.
#define EK_FOUR_ROWS(o, p, q, r, s)                                                                                \
  const vf o##_l = EK_ZIP_LO(p, q), o##_h = EK_ZIP_HI(p, q), o##_m = EK_ZIP_LO(r, s), o##_n = EK_ZIP_HI(r, s); \
  const vf o##0 = EK_PAIR_LO(o##_l, o##_m), o##1 = EK_PAIR_HI(o##_l, o##_m), o##2 = EK_PAIR_LO(o##_h, o##_n),   \
           o##3 = EK_PAIR_HI(o##_h, o##_n);
#define EK_FOUR_COLUMNS(k, w, x, y, z)                                                                                     \
  const vf even##k = EK_EVEN_QUARTERS(a##k, b##k), odd##k = EK_ODD_QUARTERS(a##k, b##k), even_2##k = EK_EVEN_QUARTERS(c##k, d##k), \
           odd_2##k = EK_ODD_QUARTERS(c##k, d##k);                                                                         \
  o.w = EK_EVEN_QUARTERS(even##k, even_2##k);                                                                              \
  o.x = EK_EVEN_QUARTERS(odd##k, odd_2##k);                                                                                \
  o.y = EK_ODD_QUARTERS(even##k, even_2##k);                                                                               \
  o.z = EK_ODD_QUARTERS(odd##k, odd_2##k);
EK_FN Rec rec_transposed(Rec m) {
  Rec o;
  EK_FOUR_ROWS(a, m.w0, m.w1, m.w2, m.w3)
  EK_FOUR_ROWS(b, m.w4, m.w5, m.w6, m.w7)
  EK_FOUR_ROWS(c, m.w8, m.w9, m.wa, m.wb)
  EK_FOUR_ROWS(d, m.wc, m.wd, m.we, m.wf)
  EK_FOUR_COLUMNS(0, w0, w4, w8, wc)
  EK_FOUR_COLUMNS(1, w1, w5, w9, wd)
  EK_FOUR_COLUMNS(2, w2, w6, wa, we)
  EK_FOUR_COLUMNS(3, w3, w7, wb, wf)
  return o;
}
#endif
#endif

#endif
