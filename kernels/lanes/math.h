// SPDX-License-Identifier: Apache-2.0
// Vector and elementary functions on lanes. Built-ins (min, dot, normalize, sin, ...) are not used:
// their rounding, their treatment of zeros and NaN, and their contraction differ between
// implementations.
#ifndef EK_MATH_H
#define EK_MATH_H
#include "lanes/division.h"
#include "lanes/lanes.h"

#define EK_PI 3.14159265358979f
#define EK_INV_PI 0.318309886183791f
#define EK_INFINITY AS_F((vu)(0x7f800000u))

EK_FN vf min_f(vf a, vf b) { return a < b ? a : b; }
EK_FN vf max_f(vf a, vf b) { return a > b ? a : b; }
EK_FN vf abs_f(vf x) { return AS_F(AS_U(x) & 0x7fffffffu); }
EK_FN vf copysign_f(vf magnitude, vf sign) {
  return AS_F((AS_U(magnitude) & 0x7fffffffu) | (AS_U(sign) & 0x80000000u));
}
/// 2^-k for 2^k <= |x| < 2^(k + 1), -126 <= k <= 126. Products with it are exact but for underflow,
/// so it scales numbers whose squares would leave the range of float.
EK_FN vf inverse_power_of_two(vf x) { return AS_F(0x7f000000u - (AS_U(x) & 0x7f800000u)); }
EK_FN vi is_finite(vf x) { return (AS_U(x) & 0x7f800000u) != 0x7f800000u; }

EK_FN v3 V3(vf x, vf y, vf z) {
  v3 r = {x, y, z};
  return r;
}
EK_FN v3 splat3(float4 a) { return V3((vf)(a.x), (vf)(a.y), (vf)(a.z)); }
EK_FN v3 add3(v3 a, v3 b) { return V3(a.x + b.x, a.y + b.y, a.z + b.z); }
EK_FN v3 sub3(v3 a, v3 b) { return V3(a.x - b.x, a.y - b.y, a.z - b.z); }
EK_FN v3 mul3(v3 a, v3 b) { return V3(a.x * b.x, a.y * b.y, a.z * b.z); }
EK_FN v3 scale3(v3 a, vf s) { return V3(a.x * s, a.y * s, a.z * s); }
EK_FN v3 neg3(v3 a) { return V3(-a.x, -a.y, -a.z); }
EK_FN v3 abs3(v3 a) { return V3(abs_f(a.x), abs_f(a.y), abs_f(a.z)); }
EK_FN vf dot3(v3 a, v3 b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
EK_FN v3 cross3(v3 a, v3 b) {
  return V3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
EK_FN v3 normalize3(v3 a) { return scale3(a, div_f((vf)(1.0f), sqrt_f(dot3(a, a)))); }
EK_FN v3 select3(vi m, v3 a, v3 b) { return V3(m ? a.x : b.x, m ? a.y : b.y, m ? a.z : b.z); }
EK_FN vf luminance(v3 a) { return (a.x * 0.2126f + a.y * 0.7152f) + a.z * 0.0722f; }  // of linear Rec. 709
EK_FN vf max_component(v3 a) { return max_f(max_f(a.x, a.y), a.z); }

/// sin and cos of r turns, |r| <= 1/8: minimax polynomials, the first coefficient of sin in two
/// parts. Errors as for sincos_2pi.
EK_FN void sincos_2pi_octant(vf r, vf* s, vf* c) {
  const vf z = r * r;
  const vf s_tail = -0x1.4abbcep+5f + z * (0x1.466bbcp+6f + z * (-0x1.32cb24p+6f + z * 0x1.4be68ep+5f));
  *s = r * 0x1.921fb6p+2f + r * (-0x1.777a5cp-23f + z * s_tail);
  *c = 1.0f + z * (-0x1.3bd3ccp+4f +
                   z * (0x1.03c1f0p+6f + z * (-0x1.55d3bcp+6f + z * (0x1.e1e85cp+5f + z * -0x1.a1084cp+4f))));
}

/// sin and cos of u turns, that is of 2 pi u, |u| < 2^20. Each within 1.6 ulp, and within 1e-7
/// absolute.
EK_FN void sincos_2pi(vf u, vf* s, vf* c) {
  const vf quarters = (4.0f * u + 12582912.0f) - 12582912.0f;  // to the nearest integer, for |4 u| < 2^22
  vf s_octant, c_octant;
  sincos_2pi_octant(u - 0.25f * quarters, &s_octant, &c_octant);  // the difference is exact
  const vi quadrant = TO_I(quarters);
  const vi odd = (quadrant & 1) != 0;
  const vf s_near = odd ? c_octant : s_octant;
  const vf c_near = odd ? s_octant : c_octant;
  *s = (quadrant & 2) != 0 ? -s_near : s_near;
  *c = ((quadrant + 1) & 2) != 0 ? -c_near : c_near;
}

/// Angle of the point (x, y) about the origin in turns, [-1/2, 1/2]: atan2(y, x) / (2 pi). It has
/// the sign of y, is exact on the axes and diagonals, 0 at the origin and where both are denormal,
/// and within 2.2 ulp. |x|, |y| < 2^126.
EK_FN vf atan2_turns(vf y, vf x) {
  const vf ax = abs_f(x), ay = abs_f(y);
  const vi steep = ay > ax;
  const vf lesser = steep ? ax : ay, greater = steep ? ay : ax;
  // Beyond tan(pi / 8) as an angle from the diagonal, so that one polynomial serves |q| <= tan(pi /
  // 8).
  const vi near_diagonal = lesser > greater * 0.414213562f;
  const vf q = div_f(near_diagonal ? lesser - greater : lesser, near_diagonal ? lesser + greater : greater);
  const vf z = q * q;
  const vf tail = -0x1.b29948p-5f +
                  z * (0x1.04bc78p-5f + z * (-0x1.7352dap-6f + z * (0x1.13b6a6p-6f + z * -0x1.3ab9c6p-7f)));
  const vf angle = q * 0x1.45f306p-3f + q * (0x1.b29fcep-28f + z * tail);  // the first coefficient in two parts
  vf turns = near_diagonal ? 0.125f + angle : angle;
  turns = steep ? 0.25f - turns : turns;
  turns = x < 0.0f ? 0.5f - turns : turns;
  turns = greater >= 0x1p-126f ? turns : (vf)(0.0f);
  return copysign_f(turns, y);
}

/// 2^x, within 1.3 ulp; 0 below -126 (denormal numbers differ between devices), infinite from 128
/// on.
EK_FN vf exp2_f(vf x) {
  const vf bounded = max_f(min_f(x, (vf)(128.0f)), (vf)(-127.0f));
  const vf whole = (bounded + 12582912.0f) - 12582912.0f;  // to the nearest integer
  const vf f = bounded - whole;                            // [-1/2, 1/2], exact
  const vf q = 0x1.62e430p-1f +
               f * (0x1.ebfbdcp-3f +
                    f * (0x1.c6aee8p-5f + f * (0x1.3b2d4cp-7f + f * (0x1.5f3e56p-10f + f * 0x1.41fbb8p-13f))));
  // In two steps: 2^128 is not a float.
  const vi half_exponent = TO_I(whole) / 2;
  const vf a = AS_F(AS_U(half_exponent + 127) << 23), b = AS_F(AS_U(TO_I(whole) - half_exponent + 127) << 23);
  const vf y = ((1.0f + f * q) * a) * b;
  return x < -126.0f ? (vf)(0.0f) : y;
}

/// log2(x) of a normal x > 0, within 3 ulp (of the five roundings that count each is at most half a
/// unit, twice that for small mantissas); -126 of anything less, zero and denormals included.
EK_FN vf log2_f(vf x) {
  const vf bounded = max_f(x, (vf)(0x1p-126f));
  // x = 2^e m with m in [sqrt(1/2), sqrt(2)), so that neither part cancels the other where the
  // logarithm is small.
  const vi shifted = AS_I(AS_U(bounded) - 0x3f3504f3u) >> 23;
  const vf m = AS_F(AS_U(bounded) - AS_U(shifted << 23));
  const vf f = m - 1.0f;  // exact
  const vf s = div_f(f, 2.0f + f), z = s * s;  // log2(m) = 2 log2(e) artanh(s), |s| < 0.172
  const vf tail = 0x1.ec709ep-1f + z * (0x1.2776c6p-1f + z * (0x1.a61762p-2f + z * 0x1.484b14p-2f));
  return TO_F(shifted) + (s * 0x1.715476p+1f + s * (z * tail));
}

#endif
