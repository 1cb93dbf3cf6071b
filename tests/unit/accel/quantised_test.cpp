// SPDX-License-Identifier: Apache-2.0
// Boxes in bytes hold the boxes that they stand for, in the kernels' arithmetic.
#include <gtest/gtest.h>

#include <bit>
#include <cfloat>
#include <cmath>
#include <random>
#include <vector>

#include "accel/layouts/quantised.h"
#include "support/accel_nodes.h"

namespace eikon {
namespace {

Box box_of(const float (&lo)[3], const float (&hi)[3]) {
  return {Float4{lo[0], lo[1], lo[2], 0}, Float4{hi[0], hi[1], hi[2], 0}};
}

/// `boxes` in the frame around all of them.
void expect_held(const std::vector<Box>& boxes, const std::string& what) {
  Box around;
  for (const Box& box : boxes) around.add(box);
  const QuantisedFrame frame(around);
  const auto words = frame.words(0x5a);
  EXPECT_EQ(words[3] >> 24, 0x5aU) << what;
  for (const Box& box : boxes) {
    const QuantisedBox q = frame.quantise(box);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto plane = [&](std::uint32_t byte) { return fixtures::node_reader::quantised(words.data(), axis, byte); };
      const std::string where = what + ", axis " + std::to_string(axis);
      ASSERT_LE(plane(q.lo[axis]), box.lo[axis]) << where;
      ASSERT_GE(plane(q.hi[axis]), box.hi[axis]) << where;
      // The next byte would not do.
      if (q.lo[axis] < 255) {
        ASSERT_GT(plane(q.lo[axis] + 1U), box.lo[axis]) << where;
      }
      if (q.hi[axis] > 0) {
        ASSERT_LT(plane(q.hi[axis] - 1U), box.hi[axis]) << where;
      }
      // A step half as large would not reach the end, but for the smallest that there is.
      const std::uint32_t exponent = words[3] >> 8 * axis & 255U;
      ASSERT_GE(exponent, 1U) << where;
      ASSERT_LE(exponent, 254U) << where;
      if (exponent > 1) {
        const double reach = double{around.lo[axis]} + 255 * std::ldexp(1.0, int(exponent) - 129);
        ASSERT_LT(reach, double{around.hi[axis]}) << where;
      }
    }
  }
}

TEST(Quantised, random_boxes_are_held_at_every_scale_and_place) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::uniform_int_distribution<int> place(-140, 126), extent(-149, 126);
  for (int round = 0; round < 20'000; ++round) {
    std::vector<Box> boxes(8);
    float center[3], size[3];
    for (int axis = 0; axis < 3; ++axis) {
      center[axis] = std::ldexp(unit(random), place(random));
      size[axis] = std::ldexp(1.0F, extent(random));
    }
    for (Box& box : boxes) {
      for (int axis = 0; axis < 3; ++axis) {
        const float a = center[axis] + size[axis] * unit(random), b = center[axis] + size[axis] * unit(random);
        box.lo[axis] = std::min(a, b);
        box.hi[axis] = std::max(a, b);
      }
    }
    expect_held(boxes, "round " + std::to_string(round));
    if (HasFatalFailure()) return;
  }
}

TEST(Quantised, boxes_of_one_float_and_of_the_next_are_held) {
  std::mt19937 random(2);
  for (int round = 0; round < 20'000; ++round) {
    // Any finite float and what lies up to some hundred floats above it: most steps round to
    // nothing.
    std::vector<Box> boxes(4);
    for (int axis = 0; axis < 3; ++axis) {
      float x = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
      if (!std::isfinite(x) || std::fabs(x) > FLT_MAX / 2) x = 1e6F;
      for (Box& box : boxes) {
        box.lo[axis] = x;
        for (std::uint32_t n = static_cast<std::uint32_t>(random()) % 200; n > 0; --n) x = std::nextafter(x, INFINITY);
        box.hi[axis] = x;
      }
    }
    expect_held(boxes, "round " + std::to_string(round));
    if (HasFatalFailure()) return;
  }
}

TEST(Quantised, hard_boxes_are_held) {
  const float tiny = 1e-45F, huge = FLT_MAX;
  expect_held({box_of({0, 0, 0}, {0, 0, 0})}, "a point");
  expect_held({box_of({1e6F, 1e6F, 1e6F}, {1e6F, 1e6F, 1e6F})}, "a point far away");
  expect_held({box_of({1e6F, -1e6F, 0}, {1e6F + 0.0625F, -1e6F, 1}), box_of({1e6F, -1e6F, 0.3F}, {1e6F, -1e6F, 0.3F})},
              "flat, far away");
  expect_held({box_of({-tiny, 0, -tiny}, {tiny, tiny, -tiny}), box_of({0, 0, -tiny}, {0, 0, 0})}, "denormal");
  expect_held({box_of({-huge, -huge, 0}, {huge, 0, huge}), box_of({-1, -1, 0}, {1, -tiny, tiny})}, "all numbers");
  expect_held({box_of({-1e6F, 0, 0}, {1e6F, 1e-6F, 1e-30F}), box_of({-1e-30F, 0, 0}, {1e-30F, 1e-7F, 1e-38F})},
              "2e6 m long and thin");
}

}  // namespace
}  // namespace eikon
