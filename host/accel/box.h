// SPDX-License-Identifier: Apache-2.0
// Axis-aligned boxes in vector registers, for the builders.
#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

namespace eikon {

/// x, y, z and a fourth lane, which boxes carry along and ignore.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

inline Float4 min4(Float4 a, Float4 b) { return a < b ? a : b; }  // b where either is NaN
inline Float4 max4(Float4 a, Float4 b) { return a > b ? a : b; }  // b where either is NaN
inline Float4 splat4(float x) { return Float4{x, x, x, x}; }
inline Float4 load4(const float* from) {
  Float4 x;
  std::memcpy(&x, from, sizeof(x));
  return x;
}
inline void store4(float* to, Float4 x) { std::memcpy(to, &x, sizeof(x)); }

struct Box {
  Float4 lo = splat4(std::numeric_limits<float>::infinity());
  Float4 hi = splat4(-std::numeric_limits<float>::infinity());

  void add(const Box& other) {
    lo = min4(lo, other.lo);
    hi = max4(hi, other.hi);
  }
  void add(Float4 point) {
    lo = min4(lo, point);
    hi = max4(hi, point);
  }
  /// Half the surface; 0 for an empty box.
  [[nodiscard]] float half_area() const {
    const Float4 d = hi - lo;
    return d[0] >= 0 ? d[0] * (d[1] + d[2]) + d[1] * d[2] : 0.0F;
  }
};

/// A box for each of three axes, such as the box of everything left of a plane across the axis.
using Box3 = std::array<Box, 3>;

/// Half the surface of each in the first three lanes, to the bit as half_area(); infinite for an
/// empty box.
inline Float4 half_areas(const Box3& boxes) {
  const Float4 a = boxes[0].hi - boxes[0].lo, b = boxes[1].hi - boxes[1].lo, c = boxes[2].hi - boxes[2].lo;
  const Float4 xy = __builtin_shufflevector(a, b, 0, 4, 1, 5);
  const Float4 x = __builtin_shufflevector(xy, c, 0, 1, 4, 4), y = __builtin_shufflevector(xy, c, 2, 3, 5, 5);
  const Float4 z = __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 6, 2, 6), c, 0, 1, 6, 6);
  return x * (y + z) + y * z;
}

/// A triangle's box, with the triangle's index in the fourth lane of `lo`. The index is stored as
/// the bits of a normal float, so that vector arithmetic on whole registers meets neither denormals
/// nor NaN. New references are unset, as there are millions.
struct Reference {
  Float4 lo, hi;
  static constexpr std::uint32_t kNormal = 0x40000000;
  static constexpr std::uint32_t kLimit = 1U << 28;
  void set(const Box& box, std::uint32_t triangle_index) {
    lo = box.lo;
    hi = box.hi;
    lo[3] = std::bit_cast<float>(triangle_index | kNormal);
  }
  [[nodiscard]] Box box() const { return {lo, hi}; }
  [[nodiscard]] std::uint32_t triangle() const { return std::bit_cast<std::uint32_t>(float{lo[3]}) & ~kNormal; }
};

/// Twice the centre of a box. Never NaN; it may overflow to an infinity.
inline Float4 centroid2(const Reference& r) { return r.lo + r.hi; }

/// The expected cost of n triangles below a child, for three counts at once. Leaves hold 8
/// triangles that are tested at once; the second term favours small numbers among equals.
inline Float4 count_costs(Int4 n) {
  return 8.0F * __builtin_convertvector((n + 7) >> 3, Float4) + 0.5F * __builtin_convertvector(n, Float4);
}

}  // namespace eikon
