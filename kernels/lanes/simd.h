// SPDX-License-Identifier: Apache-2.0
// The bits of vector masks as an integer. The builtins only shorten what the portable forms say.
#ifndef EK_SIMD_H
#define EK_SIMD_H
#include "lanes/lanes.h"

// Bit k: lane k of the mask is set.
EK_FN uint mask_bits8(int8 m) {
#if defined(__AVX512VL__) && defined(__AVX512DQ__) && EK_BUILTIN(__builtin_ia32_cvtd2mask256)
  return (uint)(uchar)__builtin_ia32_cvtd2mask256(m);
#elif defined(__AVX__) && EK_BUILTIN(__builtin_ia32_movmskps256)
  return (uint)__builtin_ia32_movmskps256(as_float8(m));
#else
  // Each lane's byte keeps its own bit; the product gathers the eight of them in the top byte.
  const ulong own = as_ulong(convert_char8(m)) & 0x8040201008040201ul;
  return (uint)((own * 0x0101010101010101ul) >> 56);
#endif
}

EK_FN uint mask_bits16(int16 m) {
#if defined(__AVX512F__) && defined(__AVX512DQ__) && EK_BUILTIN(__builtin_ia32_cvtd2mask512)
  return (uint)(ushort)__builtin_ia32_cvtd2mask512(m);
#else
  return mask_bits8(m.lo) | mask_bits8(m.hi) << 8;
#endif
}

#if EK_WIDTH == 1
EK_FN uint mask_bits(vi m) { return m ? 1u : 0u; }
#elif EK_WIDTH == 8
EK_FN uint mask_bits(vi m) { return mask_bits8(m); }
#else
EK_FN uint mask_bits(vi m) { return mask_bits16(m); }
#endif

// Index of the lowest set bit; bits is not 0.
EK_FN uint lowest_bit(uint bits) {
#if EK_BUILTIN(__builtin_ctz)
  return (uint)__builtin_ctz(bits);
#else
  return 31u - clz(bits & (0u - bits));
#endif
}

#endif
