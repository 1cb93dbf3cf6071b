// SPDX-License-Identifier: Apache-2.0
// Probes of division and square root, behind the text of probes.cl.

// These tell by integers alone if a float is the quotient of two mantissas, which are integers from
// 2^23 on, or the root of one. No quotient and no root is halfway between two floats.
EK_FN bool is_rounded_quotient(uint a, uint b, float q) {
  const ulong whole = (ulong)a << (a < b ? 24 : 23), product = (ulong)((as_uint(q) & 0x7fffffu) | 0x800000u) * b;
  const ulong rest = whole > product ? whole - product : product - whole;
  return 2 * rest < b && as_uint(q) >> 23 == (a < b ? 126u : 127u);
}
EK_FN bool is_rounded_root(uint x, uint exponent, float root) {
  const ulong four = (ulong)x << (exponent == 126u ? 26 : 25),
              twice = 2 * (ulong)((as_uint(root) & 0x7fffffu) | 0x800000u);
  return (twice - 1) * (twice - 1) < four && four < (twice + 1) * (twice + 1) && as_uint(root) >> 23 == exponent;
}
EK_FN float mantissa(uint of) { return as_float((of & 0x7fffffu) | 0x3f800000u); }

// Inputs and outputs are numbers of one lane, as kernels of several divide by the driver's
// operation.
#define FOR_LANES for (uint i = item; i < item + EK_WIDTH; ++i)

// Divides four numbers by each of 1024 divisors, of which the input is the first. Output: how many
// quotients are wrong, and how many reciprocals are not as the proof in lanes/division.h needs
// them.
PROBE(probe_quotients) {
  FOR_LANES {
    uint wrong = 0;
#if EK_WIDTH == 1
    for (uint b = in_words[i]; b < in_words[i] + 1024u; ++b) {
      const uint r = as_uint(reciprocal_between_1_and_2(mantissa(b)));
      const ulong one = (ulong)1 << (173 - (r >> 23)), product = (ulong)((r & 0x7fffffu) | 0x800000u) * b;
      wrong += (product > one ? product - one : one - product) * (b + 1u) < one ? 0u : 1u;
      const uint numerators[4] = {b - 1u, 0x7fffffu, b * 0x9e3779b1u, b * 0x85ebca6bu};
      for (uint k = 0; k < 4u; ++k) {
        const uint a = (numerators[k] & 0x7fffffu) | 0x800000u;
        wrong += is_rounded_quotient(a, b, div_f(mantissa(a), mantissa(b))) ? 0u : 1u;
      }
    }
#endif
    out_words[i] = wrong;
  }
}

// Takes the root of 1024 numbers from the input on, which has the bits of a float from 1/2 to 2.
// Output: how many are wrong.
PROBE(probe_roots) {
  FOR_LANES {
    uint wrong = 0;
    for (uint x = in_words[i]; EK_WIDTH == 1 && x < in_words[i] + 1024u; ++x)
      wrong += is_rounded_root((x & 0x7fffffu) | 0x800000u, x >> 23, sqrt_f(as_float(x))) ? 0u : 1u;
    out_words[i] = wrong;
  }
}

// Devices may flush denormal numbers and have NaNs of several bits.
EK_FN bool is_denormal(float x) { return (as_uint(x) & 0x7fffffffu) - 1u < 0x7fffffu; }
EK_FN uint bits_but_of_nan(float x) { return (as_uint(x) & 0x7fffffffu) > 0x7f800000u ? 0x7fc00000u : as_uint(x); }
// A device may round a quotient as it likes if that, an operand or the reciprocal of the divisor
// may be denormal.
EK_FN bool is_free(float a, float b) {
  const int exponent_a = (int)((as_uint(a) >> 23) & 255u), exponent_b = (int)((as_uint(b) >> 23) & 255u);
  const bool finite = exponent_b != 255 && b != 0.0f;
  return is_denormal(a) || is_denormal(b) || (finite && a != 0.0f && exponent_a - exponent_b < -125) ||
         (finite && exponent_a == 255 && exponent_b >= 253);
}

PROBE(probe_division) {
  FOR_LANES {
    const float a = as_float(in_words[i]), b = as_float(in_words[count + i]);
    out_words[i] = is_free(a, b) ? 0u : bits_but_of_nan(div_f(a, b));
    out_words[count + i] = is_denormal(a) ? 0u : bits_but_of_nan(sqrt_f(a));
  }
}
