// SPDX-License-Identifier: Apache-2.0
// Boxes of nodes between poses hold the triangles below them at any time, to the last bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "accel/accel.h"

namespace eikon {
namespace {

constexpr std::size_t kPoses = 4, kTriangles = 400;

constexpr float kMaxOfStep = 0x1.fffff8p-1F;  // of kernels/lanes/pose_step.h

/// Two ways in which devices may round where a plane is that goes some way in a step.
enum class Sum { of_product, contracted };
float moved_by(float a, float way, float share, Sum sum) {
  return sum == Sum::contracted ? std::fma(way, share, a) : a + way * share;
}
/// The way of a coordinate in kernels/surface/motion.h.
float moved(float a, float b, float share) { return moved_by(a, b - a, share, Sum::of_product); }

/// Small triangles far from the origin, of which two of three go some way, in no order; the others
/// are in no tree.
struct Swarm {
  std::vector<float> moving, soup;
  std::vector<std::uint32_t> motion;
  std::size_t moving_count = 0;

  explicit Swarm(float far) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
    for (std::size_t i = 0; i < kTriangles; ++i) {
      std::vector<std::vector<float>> poses(kPoses);
      const float x = far + 5 * unit(random), y = far + 5 * unit(random), z = -far + 5 * unit(random);
      std::vector<float> corners;
      for (int k = 0; k < 9; ++k) corners.push_back((k % 3 == 0 ? x : k % 3 == 1 ? y : z) + 0.3F * unit(random));
      const bool moves = i % 3 != 0;
      for (std::vector<float>& pose : poses)
        for (const float c : corners) pose.push_back(c + unit(random));
      moving_count += moves ? 1 : 0;
      motion.push_back(moves ? std::uint32_t(1 + moving.size() / 9) : 0);
      std::vector<float> entry(9, std::numeric_limits<float>::quiet_NaN());
      for (std::size_t k = 0; k < 9 && moves; ++k) {
        const auto of_axis = [&](bool most) {
          float best = poses[0][k % 3];
          for (const auto& pose : poses)
            for (std::size_t c = k % 3; c < 9; c += 3) best = most ? std::max(best, pose[c]) : std::min(best, pose[c]);
          return best;
        };
        if (k < 6) entry[k] = of_axis(k >= 3);
      }
      soup.insert(soup.end(), entry.begin(), entry.end());
      for (const auto& pose : poses)
        if (moves) moving.insert(moving.end(), pose.begin(), pose.end());
    }
  }
};

/// A ray may find this below a side of a node: a box, and a node or triangles.
struct Child {
  std::array<float, 6> box{};  // at the time that is asked for
  bool is_leaf = false;
  std::uint32_t node = 0;
  std::vector<std::uint32_t> triangles;
};

/// A time within the shutter, and how planes are rounded.
struct Moment {
  std::size_t step = 0;
  float share = 0;
  Sum sum = Sum::of_product;
};

/// The children of a node at a time, as kernels read the layout.
std::vector<Child> children_of(const Accel& accel, std::uint32_t node, const Moment& at_time) {
  const auto [step, share, sum] = at_time;
  const auto plane = [&](std::size_t word) { return std::bit_cast<float>(accel.nodes[word]); };
  std::vector<Child> all;
  const bool is_bvh2 = accel.layout == "bvh2";
  const std::size_t width = is_bvh2 ? 2 : accel.layout == "bvh8" ? 8 : 16;
  for (std::size_t side = 0; side < width; ++side) {
    Child& child = all.emplace_back();
    std::uint32_t word;
    if (is_bvh2) {
      const std::uint32_t* const words = &accel.nodes[16 * node];
      for (std::size_t k = 0; k < 6; ++k) {
        const std::size_t at = 16 * (words[14] + step) + 6 * side + k;
        child.box[k] = words[14] == 0 ? plane(16 * node + 6 * side + k) : moved(plane(at), plane(at + 16), share);
      }
      word = words[12 + side];
      child.is_leaf = (word & kLeafBit) != 0;
      for (std::uint32_t i = 0; child.is_leaf && i <= ((word >> 28) & 7U); ++i)
        child.triangles.push_back(accel.leaves[(word & 0x0fffffffU) + i]);
    } else {
      const std::size_t record = 14 * width * (node + step);
      for (std::size_t k = 0; k < 6; ++k) {
        const std::size_t at = record + width * (2 * (k % 3) + k / 3) + side;
        child.box[k] = moved_by(plane(at), plane(at + 8 * width), share, sum);
      }
      word = accel.nodes[record + 6 * width + side];
      if (word == 0) {
        all.pop_back();
        continue;
      }
      child.is_leaf = (word & kLeafBit) != 0;
      for (std::size_t i = 0; child.is_leaf && i < 8; ++i) {
        const std::uint32_t triangle = accel.leaves[160 * ((word & ~kLeafBit) + step) + 72 + i];
        if (triangle != EK_NO_HIT) child.triangles.push_back(triangle);
      }
    }
    child.node = word;
  }
  return all;
}

class SwarmWalk {
 public:
  SwarmWalk(const Swarm& swarm, const Accel& accel) : swarm_(swarm), accel_(accel) {}

  /// Looks at all triangles below a node, and counts the planes that cut one off at this time.
  void below(std::uint32_t node, const Moment& moment) {
    for (const Child& child : children_of(accel_, node, moment)) {
      boxes_.push_back(child.box);
      if (!child.is_leaf) below(child.node, moment);
      for (const std::uint32_t triangle : child.triangles) look_at(triangle, moment.step, moment.share);
      boxes_.pop_back();
    }
  }

  std::size_t cut = 0, seen = 0;

 private:
  void look_at(std::uint32_t triangle, std::size_t step, float share) {
    ++seen;
    for (std::size_t k = 0; k < 9; ++k) {
      const auto at = [&](std::size_t pose) { return swarm_.moving[9 * (swarm_.motion[triangle] - 1 + pose) + k]; };
      const float c = moved(at(step), at(step + 1), share);
      for (const auto& box : boxes_) cut += c < box[k % 3] || c > box[3 + k % 3] ? 1 : 0;
    }
  }

  const Swarm& swarm_;
  const Accel& accel_;
  std::vector<std::array<float, 6>> boxes_;
};

Accel tree_over_time(const Swarm& swarm, const std::string& layout) {
  const TriangleSoup soup(swarm.soup.data(), kTriangles, 9, 0, swarm.motion.data());
  const TrianglePoses poses{.motion = swarm.motion.data(), .corners = swarm.moving.data(), .count = kPoses};
  AccelOptions options;
  options.layout = layout;
  options.poses = &poses;
  return build_accel(soup, options);
}

TEST(MotionTrees, boxes_between_poses_cut_no_corner_off) {
  for (const char* layout : {"bvh2", "bvh8", "bvh16"})
    for (const float far : {0.0F, 100.0F, 3e4F}) {
      const Swarm swarm(far);
      const Accel accel = tree_over_time(swarm, layout);
      std::mt19937 random(9);
      std::uniform_real_distribution<float> unit(0.0F, kMaxOfStep);
      SwarmWalk walk(swarm, accel);
      for (const Sum sum : {Sum::of_product, Sum::contracted}) {
        for (int i = 0; i < 200; ++i) walk.below(0, {random() % (kPoses - 1), unit(random), sum});
        for (const float share : {0.0F, kMaxOfStep}) walk.below(0, {1, share, sum});
      }
      EXPECT_EQ(walk.cut, 0U) << layout << far;
      EXPECT_EQ(walk.seen, 404 * swarm.moving_count) << layout << far;
    }
}

TEST(MotionTrees, records_of_a_wide_leaf_hold_the_corners_of_their_step_and_where_those_of_its_triangles_begin) {
  constexpr std::size_t kSteps = kPoses - 1;
  const Swarm swarm(1);
  for (const char* layout : {"bvh8", "bvh16"}) {
    const Accel accel = tree_over_time(swarm, layout);
    std::size_t seen = 0;
    for (std::size_t record = 0; record < accel.leaves.size() / 160; ++record)
      for (std::size_t i = 0; i < 8; ++i) {
        const std::uint32_t* const words = &accel.leaves[160 * record];
        const auto number = [&](std::size_t at) { return std::bit_cast<float>(words[at + i]); };
        const std::uint32_t triangle = words[72 + i];
        EXPECT_EQ(triangle, accel.leaves[160 * (record - record % kSteps) + 72 + i]);
        if (triangle == EK_NO_HIT) {
          for (std::size_t k = 0; k < 9; ++k) EXPECT_TRUE(std::isnan(number(8 * k)));
          continue;
        }
        EXPECT_EQ(words[152 + i], swarm.motion[triangle] - 1);
        for (std::size_t k = 0; k < 9; ++k) {
          const auto at = [&](std::size_t pose) { return swarm.moving[9 * (swarm.motion[triangle] - 1 + pose) + k]; };
          EXPECT_EQ(number(8 * k), at(record % kSteps));
          EXPECT_EQ(number(80 + 8 * k), at(record % kSteps + 1) - at(record % kSteps));
          ++seen;
        }
      }
    EXPECT_EQ(seen, 9 * kSteps * swarm.moving_count);
  }
}

TEST(MotionTrees, rounding_takes_no_corner_past_its_next_pose) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::uniform_int_distribution<int> exponent(-149, 100);
  std::size_t passed = 0, passed_at_one = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    // Coordinates of any size, and such that differ by a few units in the last place.
    const float a = std::ldexp(unit(random), exponent(random));
    const float b = i % 2 == 0 ? std::ldexp(unit(random), exponent(random)) : a * (1 + 0x1p-20F * unit(random));
    const auto passes = [&](float share) {
      const float c = moved(a, b, share);
      return c < std::min(a, b) || c > std::max(a, b);
    };
    passed += passes(kMaxOfStep) || passes(0.5F * (kMaxOfStep + kMaxOfStep * unit(random))) ? 1 : 0;
    passed_at_one += passes(1) ? 1 : 0;
  }
  EXPECT_EQ(passed, 0U);
  EXPECT_GT(passed_at_one, 0U);  // so the limit of the share is needed
}

}  // namespace
}  // namespace eikon
