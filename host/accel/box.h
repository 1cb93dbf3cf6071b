// SPDX-License-Identifier: Apache-2.0
// Axis-aligned boxes in vector registers, for the builders.
#pragma once
#include <cstdint>
#include <limits>

namespace eikon {

/// x, y, z and a fourth lane that is carried along and means nothing to a box.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

inline Float4 min4(Float4 a, Float4 b) { return a < b ? a : b; }
inline Float4 max4(Float4 a, Float4 b) { return a > b ? a : b; }
inline Float4 splat4(float x) { return Float4{x, x, x, x}; }

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

}  // namespace eikon
