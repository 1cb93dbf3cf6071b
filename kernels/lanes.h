// SPDX-License-Identifier: Apache-2.0
// The dialect of stage bodies. A lane is one path (or pixel); stage bodies are written once in the lane types
//   vf vi vu  float, int, uint     v3  three vf
// and compiled EK_WIDTH = 16 or 8 wide for CPU devices and 1 wide for GPUs, with the same bits at every width. Rules:
//   - comparisons give masks (vi: 0 / -1 per lane, 0 / 1 at width 1; never arithmetic on them); `m ? a : b` selects; & | !
//     combine. No && || if on lane values; `if (ANY(m))` only skips work, with selects inside.
//   - load first, select after; divide freely, then select the bad quotient away.
//   - no store under a mask: lanes without a path write where nobody reads (chunk tails, film trash slots).
// Arithmetic is + - * / sqrt, comparisons and integers alone, without contraction, so that every device gives the same bits.
#ifndef EK_LANES_H
#define EK_LANES_H
#pragma OPENCL FP_CONTRACT OFF
#include "shared/records.h"

#ifdef EK_OUT_OF_LINE  // without optimisation: inlining would leave notes to the optimiser that an interpreter does not know
#define EK_FN static
#else
#define EK_FN static inline __attribute__((always_inline))
#endif
// For the body of a large kernel on CPU devices: PoCL compiles three copies of a kernel's own code, but one of what it calls.
#if EK_WIDTH > 1
#define EK_FN_ONCE static __attribute__((noinline))
#else
#define EK_FN_ONCE EK_FN
#endif
#define EK_CAT_(a, b) a##b
#define EK_CAT(a, b) EK_CAT_(a, b)

#if EK_WIDTH == 1
typedef float vf;
typedef int vi;
typedef uint vu;
typedef float vf_unaligned;
typedef uint vu_unaligned;
#define LANE_INDEX ((vu)0)
#define AS_F as_float
#define AS_I as_int
#define AS_U as_uint
#define TO_F(x) ((float)(x))
#define TO_I(x) ((int)(x))  // callers clamp first: out of range differs between devices
#define ANY(m) (m)
#else
typedef EK_CAT(float, EK_WIDTH) vf;
typedef EK_CAT(int, EK_WIDTH) vi;
typedef EK_CAT(uint, EK_WIDTH) vu;
typedef vf __attribute__((aligned(4))) vf_unaligned;
typedef vu __attribute__((aligned(4))) vu_unaligned;
#if EK_WIDTH == 16
#define LANE_INDEX ((vu)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15))
#else
#define LANE_INDEX ((vu)(0, 1, 2, 3, 4, 5, 6, 7))
#endif
#define AS_F EK_CAT(as_float, EK_WIDTH)
#define AS_I EK_CAT(as_int, EK_WIDTH)
#define AS_U EK_CAT(as_uint, EK_WIDTH)
#define TO_F(x) EK_CAT(convert_float, EK_WIDTH)(x)
#define TO_I(x) __builtin_convertvector((x), vi)
#define ANY(m) lanes_any(m)
#endif

typedef struct { vf x, y, z; } v3;

// ---- masks ----------------------------------------------------------------------------------------------------------
// The builtins below only shorten what the portable forms say; the bits are the same.
#if defined(__AVX512F__) && defined(__AVX512DQ__) && EK_WIDTH == 16 && !defined(EK_PORTABLE)
#define EK_HAS_COMPRESS 1
EK_FN uint lanes_bits(vi m) { return (uint)(ushort)__builtin_ia32_cvtd2mask512(m); }
EK_FN int lanes_any(vi m) { return lanes_bits(m) != 0; }
#else
#define EK_HAS_COMPRESS 0
#if EK_WIDTH > 1
EK_FN int lanes_any(vi m) { return any(m); }
#endif
#endif

#define ALL_LANES (LANE_INDEX == LANE_INDEX)

// How the lanes of a mask move together: lane k of the packed vector is the k-th set lane.
typedef struct {
  uint count;
  uint bits;  // of the mask, with EK_HAS_COMPRESS
  vu source;  // lane that goes to k, without it
} Packing;

EK_FN Packing packing(vi m) {
  Packing p;
#if EK_HAS_COMPRESS
  p.bits = lanes_bits(m);
  p.count = (uint)popcount(p.bits);
  p.source = (vu)(0);
#elif EK_WIDTH == 1
  p.bits = 0;
  p.count = m ? 1u : 0u;
  p.source = 0;
#else
  int flags[EK_WIDTH];
  uint source[EK_WIDTH];
  *(vi*)flags = m;
  *(vu*)source = (vu)(0);
  p.count = 0;
  for (uint lane = 0; lane < EK_WIDTH; ++lane) {
    source[p.count] = lane;
    p.count += flags[lane] != 0 ? 1u : 0u;
    if (p.count == EK_WIDTH) break;
  }
  p.source = *(vu*)source;
  p.bits = 0;
#endif
  return p;
}
EK_FN vu packed(Packing p, vu x) {
#if EK_HAS_COMPRESS
  return AS_U(__builtin_ia32_compresssi512_mask(AS_I(x), AS_I(x), (ushort)p.bits));
#elif EK_WIDTH == 1
  return x;
#else
  return shuffle(x, p.source);
#endif
}

// ---- memory ---------------------------------------------------------------------------------------------------------
EK_FN vf load_f(global const float* p) { return *(global const vf_unaligned*)p; }
EK_FN vu load_u(global const uint* p) { return *(global const vu_unaligned*)p; }
EK_FN void store_f(global float* p, vf x) { *(global vf_unaligned*)p = x; }
EK_FN void store_u(global uint* p, vu x) { *(global vu_unaligned*)p = x; }

#if EK_WIDTH == 1
EK_FN vf gather_f(global const float* p, vu i) { return p[i]; }
EK_FN vu gather_u(global const uint* p, vu i) { return p[i]; }
EK_FN void scatter_f(global float* p, vu i, vf x) { p[i] = x; }
#elif EK_WIDTH == 8
EK_FN vf gather_f(global const float* p, vu i) {
  return (vf)(p[i.s0], p[i.s1], p[i.s2], p[i.s3], p[i.s4], p[i.s5], p[i.s6], p[i.s7]);
}
EK_FN vu gather_u(global const uint* p, vu i) {
  return (vu)(p[i.s0], p[i.s1], p[i.s2], p[i.s3], p[i.s4], p[i.s5], p[i.s6], p[i.s7]);
}
EK_FN void scatter_f(global float* p, vu i, vf x) {
  p[i.s0] = x.s0; p[i.s1] = x.s1; p[i.s2] = x.s2; p[i.s3] = x.s3;
  p[i.s4] = x.s4; p[i.s5] = x.s5; p[i.s6] = x.s6; p[i.s7] = x.s7;
}
#else
EK_FN vf gather_f(global const float* p, vu i) {
  return (vf)(p[i.s0], p[i.s1], p[i.s2], p[i.s3], p[i.s4], p[i.s5], p[i.s6], p[i.s7], p[i.s8], p[i.s9], p[i.sa],
              p[i.sb], p[i.sc], p[i.sd], p[i.se], p[i.sf]);
}
EK_FN vu gather_u(global const uint* p, vu i) {
  return (vu)(p[i.s0], p[i.s1], p[i.s2], p[i.s3], p[i.s4], p[i.s5], p[i.s6], p[i.s7], p[i.s8], p[i.s9], p[i.sa],
              p[i.sb], p[i.sc], p[i.sd], p[i.se], p[i.sf]);
}
EK_FN void scatter_f(global float* p, vu i, vf x) {
  p[i.s0] = x.s0; p[i.s1] = x.s1; p[i.s2] = x.s2; p[i.s3] = x.s3; p[i.s4] = x.s4; p[i.s5] = x.s5;
  p[i.s6] = x.s6; p[i.s7] = x.s7; p[i.s8] = x.s8; p[i.s9] = x.s9; p[i.sa] = x.sa; p[i.sb] = x.sb;
  p[i.sc] = x.sc; p[i.sd] = x.sd; p[i.se] = x.se; p[i.sf] = x.sf;
}
#endif

// A 64-byte record per lane, as 16 vectors. Whole records are loaded and transposed: half the time of gathers by field.
typedef struct { vf w0, w1, w2, w3, w4, w5, w6, w7, w8, w9, wa, wb, wc, wd, we, wf; } Rec;

#if EK_WIDTH == 1
EK_FN Rec rec16(global const void* records, vu i) {
  global const float* p = (global const float*)records + (size_t)i * 16;
  Rec r = {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11], p[12], p[13], p[14], p[15]};
  return r;
}
#elif EK_WIDTH == 8
#define EK_ZIP_LO(a, b) ((vf)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3))
#define EK_ZIP_HI(a, b) ((vf)(a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7))
// One round of the perfect shuffle; three of them transpose 8 x 8.
#define EK_ROUND(o, i)                                                                          \
  vf o##0 = EK_ZIP_LO(i##0, i##4), o##1 = EK_ZIP_HI(i##0, i##4), o##2 = EK_ZIP_LO(i##1, i##5),   \
     o##3 = EK_ZIP_HI(i##1, i##5), o##4 = EK_ZIP_LO(i##2, i##6), o##5 = EK_ZIP_HI(i##2, i##6),   \
     o##6 = EK_ZIP_LO(i##3, i##7), o##7 = EK_ZIP_HI(i##3, i##7);
#define EK_ROW(lane, offset) (*(global const vf_unaligned*)(p + (size_t)i.s##lane * 16 + offset))
EK_FN Rec rec16(global const void* records, vu i) {
  global const float* p = (global const float*)records;
  Rec r;
  {
    vf a0 = EK_ROW(0, 0), a1 = EK_ROW(1, 0), a2 = EK_ROW(2, 0), a3 = EK_ROW(3, 0), a4 = EK_ROW(4, 0), a5 = EK_ROW(5, 0),
       a6 = EK_ROW(6, 0), a7 = EK_ROW(7, 0);
    EK_ROUND(b, a) EK_ROUND(c, b) EK_ROUND(d, c)
    r.w0 = d0; r.w1 = d1; r.w2 = d2; r.w3 = d3; r.w4 = d4; r.w5 = d5; r.w6 = d6; r.w7 = d7;
  }
  {
    vf a0 = EK_ROW(0, 8), a1 = EK_ROW(1, 8), a2 = EK_ROW(2, 8), a3 = EK_ROW(3, 8), a4 = EK_ROW(4, 8), a5 = EK_ROW(5, 8),
       a6 = EK_ROW(6, 8), a7 = EK_ROW(7, 8);
    EK_ROUND(b, a) EK_ROUND(c, b) EK_ROUND(d, c)
    r.w8 = d0; r.w9 = d1; r.wa = d2; r.wb = d3; r.wc = d4; r.wd = d5; r.we = d6; r.wf = d7;
  }
  return r;
}
#else
#define EK_ZIP_LO(a, b) \
  ((vf)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3, a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7))
#define EK_ZIP_HI(a, b) \
  ((vf)(a.s8, b.s8, a.s9, b.s9, a.sa, b.sa, a.sb, b.sb, a.sc, b.sc, a.sd, b.sd, a.se, b.se, a.sf, b.sf))
// One round of the perfect shuffle; four of them transpose 16 x 16.
#define EK_ROUND(o, i)                                                                                                 \
  vf o##0 = EK_ZIP_LO(i##0, i##8), o##1 = EK_ZIP_HI(i##0, i##8), o##2 = EK_ZIP_LO(i##1, i##9),                          \
     o##3 = EK_ZIP_HI(i##1, i##9), o##4 = EK_ZIP_LO(i##2, i##a), o##5 = EK_ZIP_HI(i##2, i##a),                          \
     o##6 = EK_ZIP_LO(i##3, i##b), o##7 = EK_ZIP_HI(i##3, i##b), o##8 = EK_ZIP_LO(i##4, i##c),                          \
     o##9 = EK_ZIP_HI(i##4, i##c), o##a = EK_ZIP_LO(i##5, i##d), o##b = EK_ZIP_HI(i##5, i##d),                          \
     o##c = EK_ZIP_LO(i##6, i##e), o##d = EK_ZIP_HI(i##6, i##e), o##e = EK_ZIP_LO(i##7, i##f),                          \
     o##f = EK_ZIP_HI(i##7, i##f);
#define EK_ROW(lane) (*(global const vf_unaligned*)(p + (size_t)i.s##lane * 16))
EK_FN Rec rec16(global const void* records, vu i) {
  global const float* p = (global const float*)records;
  vf a0 = EK_ROW(0), a1 = EK_ROW(1), a2 = EK_ROW(2), a3 = EK_ROW(3), a4 = EK_ROW(4), a5 = EK_ROW(5), a6 = EK_ROW(6),
     a7 = EK_ROW(7), a8 = EK_ROW(8), a9 = EK_ROW(9), aa = EK_ROW(a), ab = EK_ROW(b), ac = EK_ROW(c), ad = EK_ROW(d),
     ae = EK_ROW(e), af = EK_ROW(f);
  EK_ROUND(b, a) EK_ROUND(c, b) EK_ROUND(d, c) EK_ROUND(e, d)
  Rec r = {e0, e1, e2, e3, e4, e5, e6, e7, e8, e9, ea, eb, ec, ed, ee, ef};
  return r;
}
#endif

#endif
