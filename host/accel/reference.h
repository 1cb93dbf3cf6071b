// SPDX-License-Identifier: Apache-2.0
// The references to triangles that the builder of trees sorts.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>

#include "accel/box.h"

namespace eikon {

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
