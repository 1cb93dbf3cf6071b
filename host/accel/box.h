// SPDX-License-Identifier: Apache-2.0
// Axis-aligned boxes in vector registers, for the builders.
#pragma once
#include <array>
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

}  // namespace eikon
