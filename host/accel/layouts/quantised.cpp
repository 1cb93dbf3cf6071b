// SPDX-License-Identifier: Apache-2.0
#include "accel/layouts/quantised.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace eikon {
namespace {

float step(std::uint32_t exponent) { return std::bit_cast<float>(exponent << 23); }

}  // namespace

float QuantisedFrame::plane(std::size_t axis, int byte) const {
  return origin_[axis] + static_cast<float>(byte) * step(exponent_[axis]);
}

QuantisedFrame::QuantisedFrame(const Box& around) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    origin_[axis] = around.lo[axis];
    const double extent = double{around.hi[axis]} - double{around.lo[axis]};
    const int guess = extent > 0 ? std::ilogb(extent / 255) + 127 : 1;
    exponent_[axis] = static_cast<std::uint32_t>(std::clamp(guess, 1, 254));
    while (exponent_[axis] < 254 && plane(axis, 255) < around.hi[axis]) ++exponent_[axis];
  }
}

QuantisedBox QuantisedFrame::quantise(const Box& box) const {
  QuantisedBox q{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // Begins with a guess and corrects it by steps, because rounded planes may be equal, or lie on
    // the wrong side of the box.
    const auto guess = [&](double x) {
      return static_cast<int>(std::clamp((x - double{origin_[axis]}) / double{step(exponent_[axis])}, 0.0, 255.0));
    };
    int lo = guess(double{box.lo[axis]}), hi = guess(double{box.hi[axis]});
    while (lo < 255 && plane(axis, lo + 1) <= box.lo[axis]) ++lo;
    while (lo > 0 && plane(axis, lo) > box.lo[axis]) --lo;
    while (hi > 0 && plane(axis, hi - 1) >= box.hi[axis]) --hi;
    while (hi < 255 && plane(axis, hi) < box.hi[axis]) ++hi;
    q.lo[axis] = static_cast<std::uint8_t>(lo);
    q.hi[axis] = static_cast<std::uint8_t>(hi);
  }
  return q;
}

std::array<std::uint32_t, 4> QuantisedFrame::words(std::uint32_t top) const {
  return {std::bit_cast<std::uint32_t>(origin_[0]), std::bit_cast<std::uint32_t>(origin_[1]),
          std::bit_cast<std::uint32_t>(origin_[2]), exponent_[0] | exponent_[1] << 8 | exponent_[2] << 16 | top << 24};
}

}  // namespace eikon
