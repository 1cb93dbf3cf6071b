// SPDX-License-Identifier: Apache-2.0
// Compaction: the lanes of a mask, moved together. This file alone knows how a processor does that:
// AVX-512 has an instruction for it, AVX2 permutes by a table, and others go lane by lane. The
// words are the same. Vectors of 8 and of 16 words each have
//   permuteN(x, order)         lane i is x[order[i]], of which the lowest 3 or 4 bits count
//   compressN(x, bits)         lane k is the k-th lane of x whose bit is set; the lanes behind
//                              those are arbitrary
//   appendN(list, x, bits)     stores that; up to N words of `list` are written
#ifndef EK_COMPACT_H
#define EK_COMPACT_H
#include "lanes/simd.h"

typedef uint8 __attribute__((aligned(4))) uint8_unaligned;
typedef uint16 __attribute__((aligned(4))) uint16_unaligned;

#if defined(__AVX2__) && EK_BUILTIN(__builtin_ia32_permvarsi256)
EK_FN uint8 permute8(uint8 x, uint8 order) { return as_uint8(__builtin_ia32_permvarsi256(as_int8(x), as_int8(order))); }
#if defined(__AVX512VL__) && EK_BUILTIN(__builtin_ia32_compresssi256_mask)
EK_FN uint8 compress8(uint8 x, uint bits) {
  return as_uint8(__builtin_ia32_compresssi256_mask(as_int8(x), as_int8(x), (uchar)bits));
}
#else
#include "lanes/compress_table.h"
EK_FN uint8 compress8(uint8 x, uint bits) { return permute8(x, convert_uint8(compress_order(bits))); }
#endif
EK_FN void append8(uint* list, uint8 x, uint bits) { *(uint8_unaligned*)list = compress8(x, bits); }
#else
EK_FN uint8 permute8(uint8 x, uint8 order) { return shuffle(x, order); }
EK_FN void append8(uint* list, uint8 x, uint bits) {
  uint words[8] __attribute__((aligned(32)));
  *(uint8*)words = x;
  uint at = 0;
  for (uint lane = 0; lane < 8u; ++lane) {  // a word whose bit is not set is overwritten by the next
    list[at] = words[lane];
    at += bits >> lane & 1u;
  }
}
EK_FN uint8 compress8(uint8 x, uint bits) {
  uint words[8] __attribute__((aligned(32)));
  *(uint8*)words = x;
  append8(words, x, bits);
  return *(const uint8*)words;
}
#endif

#if defined(__AVX512F__) && EK_BUILTIN(__builtin_ia32_permvarsi512) && EK_BUILTIN(__builtin_ia32_compresssi512_mask)
EK_FN uint16 permute16(uint16 x, uint16 order) { return as_uint16(__builtin_ia32_permvarsi512(as_int16(x), as_int16(order))); }
EK_FN uint16 compress16(uint16 x, uint bits) {
  return as_uint16(__builtin_ia32_compresssi512_mask(as_int16(x), as_int16(x), (ushort)bits));
}
EK_FN void append16(uint* list, uint16 x, uint bits) { *(uint16_unaligned*)list = compress16(x, bits); }
#else
EK_FN uint16 permute16(uint16 x, uint16 order) { return shuffle(x, order); }
EK_FN void append16(uint* list, uint16 x, uint bits) {
  append8(list, x.lo, bits & 0xffu);
  append8(list + popcount(bits & 0xffu), x.hi, bits >> 8);
}
EK_FN uint16 compress16(uint16 x, uint bits) {
  uint words[16] __attribute__((aligned(64)));
  *(uint16*)words = x;
  append16(words, x, bits);
  return *(const uint16*)words;
}
#endif

// The lanes of a mask that are to move together: bit k says that lane k is one of them.
typedef struct {
  uint bits, count;
} Packing;

EK_FN Packing packing(vi m) {
  const uint bits = mask_bits(m);
  const Packing p = {bits, (uint)popcount(bits)};
  return p;
}

/// The packing that leaves every lane where it is.
EK_FN Packing packing_all(void) {
  const Packing p = {(1u << EK_WIDTH) - 1u, EK_WIDTH};
  return p;
}

#if EK_WIDTH == 1
EK_FN vu packed(Packing p, vu x) { return x; }
#else
/// Lane k of the result is the k-th lane of the mask; the lanes behind those are arbitrary.
EK_FN vu packed(Packing p, vu x) { return EK_CAT(compress, EK_WIDTH)(x, p.bits); }
/// Stores packed(p, x); up to EK_WIDTH words of `list` are written.
EK_FN void append(uint* list, Packing p, vu x) { EK_CAT(append, EK_WIDTH)(list, x, p.bits); }
/// Lane i is x[index[i]].
EK_FN vf lanes_of(vf x, vu index) { return AS_F(EK_CAT(permute, EK_WIDTH)(AS_U(x), index)); }
#endif

#endif
