// SPDX-License-Identifier: Apache-2.0
// The dialect of stage bodies. A lane is one path (or pixel); stage bodies are written once in the
// lane types
//   vf vi vu  float, int, uint     v3  three vf
// and compiled EK_WIDTH = 16 or 8 wide for CPU devices and 1 wide for GPUs, with the same bits at
// every width. Rules:
//   - comparisons give masks (vi: 0 / -1 per lane, 0 / 1 at width 1; never arithmetic on them); `m
//     ? a : b` selects; & | ! combine. No && || if on lane values; `if (ANY(m))` only skips work,
//     with selects inside.
//   - load first, select after; divide freely, then select the bad quotient away.
//   - no store under a mask: lanes without a path write where nobody reads: behind the paths of a
//     chunk, or to the padding behind a plane of film slots.
// Arithmetic is + - *, div_f, sqrt_f (division.h), comparisons and integers alone, without
// contraction, so that every device gives the same bits.
#ifndef EK_LANES_H
#define EK_LANES_H
#pragma OPENCL FP_CONTRACT OFF
#include "shared/records.h"

#ifdef EK_NO_AVX512  // as on a processor without it, for tests
#undef __AVX512F__
#undef __AVX512DQ__
#undef __AVX512VL__
#endif

// Without optimisation: inlining would leave notes to the optimiser that an interpreter does not
// know.
#ifdef EK_OUT_OF_LINE
#define EK_FN static
#else
#define EK_FN static inline __attribute__((always_inline))
#endif
// EK_FN_ONCE marks functions that are not inlined on CPU devices. These are the bodies of kernels,
// because PoCL compiles three copies of a kernel's own code, but one of what it calls. It inlines a
// function that asks for the work-item's place all the same, so a body gets what follows from the
// place as arguments. Stages, which run over thousands of paths at a call, and a few long functions
// are marked too, because a compiler takes longer over one large body.
#ifndef EK_FN_ONCE
#if EK_WIDTH > 1 || defined(__x86_64__) || defined(__aarch64__)
#define EK_FN_ONCE static __attribute__((noinline, unused))
#else
#define EK_FN_ONCE EK_FN
#endif
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
#define TO_F(x) __builtin_convertvector((x), vf)
#define TO_I(x) __builtin_convertvector((x), vi)
#define ANY(m) lanes_any(m)
#endif

typedef struct { vf x, y, z; } v3;

// ---- masks --------------------------------------------------------------------------------------
// EK_BUILTIN(name): this compiler has the builtin, and EK_PORTABLE does not forbid it. Builtins
// only shorten what the portable forms say; the bits are the same.
#if defined(__has_builtin) && !defined(EK_PORTABLE)
#define EK_BUILTIN(name) __has_builtin(name)
#else
#define EK_BUILTIN(name) 0
#endif

#if EK_WIDTH == 16 && defined(__AVX512F__) && defined(__AVX512DQ__) && EK_BUILTIN(__builtin_ia32_cvtd2mask512)
EK_FN int lanes_any(vi m) { return __builtin_ia32_cvtd2mask512(m) != 0; }
#elif EK_WIDTH > 1
EK_FN int lanes_any(vi m) { return any(m); }
#endif

#define ALL_LANES (LANE_INDEX == LANE_INDEX)

// ---- memory -------------------------------------------------------------------------------------
// EK_PREFETCH(p): fetches the line of a CPU's caches in which p points, to global memory. EK_CPU
// comes from the host. GPUs hide the latency of memory by other work-items, and NVIDIA's compiler
// refuses the builtin for pointers to global memory.
#if EK_CPU && EK_BUILTIN(__builtin_prefetch)
#define EK_PREFETCH(p) __builtin_prefetch(p)
#else
#define EK_PREFETCH(p) ((void)(p))
#endif

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

// Gathers from a table that is part of the program.
#if EK_WIDTH == 1
EK_FN vf table_f(constant const float* p, vu i) { return p[i]; }
#elif EK_WIDTH == 8
EK_FN vf table_f(constant const float* p, vu i) {
  return (vf)(p[i.s0], p[i.s1], p[i.s2], p[i.s3], p[i.s4], p[i.s5], p[i.s6], p[i.s7]);
}
#else
EK_FN vf table_f(constant const float* p, vu i) {
  return (vf)(p[i.s0], p[i.s1], p[i.s2], p[i.s3], p[i.s4], p[i.s5], p[i.s6], p[i.s7], p[i.s8], p[i.s9], p[i.sa],
              p[i.sb], p[i.sc], p[i.sd], p[i.se], p[i.sf]);
}
#endif

// A 64-byte record per lane, as 16 vectors. Whole records are loaded and transposed: half the time
// of gathers by field.
typedef struct { vf w0, w1, w2, w3, w4, w5, w6, w7, w8, w9, wa, wb, wc, wd, we, wf; } Rec;

#if EK_WIDTH == 1
EK_FN Rec rec16(global const void* records, vu i) {
  global const float* p = (global const float*)records + (size_t)i * 16;
  Rec r = {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11], p[12], p[13], p[14], p[15]};
  return r;
}
#else
// Four words of each record at a time: 16 bytes per lane, then 4 x 4 transposes within 128 bits,
// which every shuffle unit does at once and whatever of the words is used; transposing 16 x 16
// across the register costs twice the time where some are not.
typedef struct { vf w0, w1, w2, w3; } Quad;

// Each of these is one instruction of the compiler's intermediate code. If a vector is put together
// from parts, it becomes up to fifteen of them, which no pass joins; they were a quarter of all
// instructions of a simple scene.
#if EK_WIDTH == 8
#define EK_ZIP_LO(a, b) __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define EK_ZIP_HI(a, b) __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#define EK_PAIR_LO(a, b) __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define EK_PAIR_HI(a, b) __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15)
#else
#define EK_ZIP_LO(a, b) __builtin_shufflevector(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29)
#define EK_ZIP_HI(a, b) __builtin_shufflevector(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31)
#define EK_PAIR_LO(a, b) __builtin_shufflevector(a, b, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29)
#define EK_PAIR_HI(a, b) __builtin_shufflevector(a, b, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31)
#endif
#define EK_JOIN_4(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7)
#define EK_JOIN_8(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)

// Words 4 * quad .. 4 * quad + 3 of the records.
EK_FN Quad rec_quad(global const void* records, vu i, uint quad) {
  global const float* p = (global const float*)records + 4 * quad;
#define EK_ROW(lane) (*(global const float4*)(p + (size_t)i.s##lane * 16))
#if EK_WIDTH == 8
  const vf a = EK_JOIN_4(EK_ROW(0), EK_ROW(4)), b = EK_JOIN_4(EK_ROW(1), EK_ROW(5)), c = EK_JOIN_4(EK_ROW(2), EK_ROW(6)),
           d = EK_JOIN_4(EK_ROW(3), EK_ROW(7));
#else
#define EK_FOUR_ROWS(p, q, r, s) EK_JOIN_8(EK_JOIN_4(EK_ROW(p), EK_ROW(q)), EK_JOIN_4(EK_ROW(r), EK_ROW(s)))
  const vf a = EK_FOUR_ROWS(0, 4, 8, c), b = EK_FOUR_ROWS(1, 5, 9, d), c = EK_FOUR_ROWS(2, 6, a, e), d = EK_FOUR_ROWS(3, 7, b, f);
#undef EK_FOUR_ROWS
#endif
#undef EK_ROW
  const vf ab = EK_ZIP_LO(a, b), cd = EK_ZIP_LO(c, d), ab_hi = EK_ZIP_HI(a, b), cd_hi = EK_ZIP_HI(c, d);
  const Quad quad_of = {EK_PAIR_LO(ab, cd), EK_PAIR_HI(ab, cd), EK_PAIR_LO(ab_hi, cd_hi), EK_PAIR_HI(ab_hi, cd_hi)};
  return quad_of;
}
EK_FN Rec rec16(global const void* records, vu i) {
  const Quad a = rec_quad(records, i, 0), b = rec_quad(records, i, 1), c = rec_quad(records, i, 2),
             d = rec_quad(records, i, 3);
  const Rec r = {a.w0, a.w1, a.w2, a.w3, b.w0, b.w1, b.w2, b.w3, c.w0, c.w1, c.w2, c.w3, d.w0, d.w1, d.w2, d.w3};
  return r;
}
#endif

#endif
