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

/// The way of a plane in kernels/traverse.
float between(float a, float b, float share) { return a + (b - a) * share; }
/// The way of a coordinate in kernels/surface/motion.h.
float moved(float a, float b, float share) { return std::clamp(between(a, b, share), std::min(a, b), std::max(a, b)); }

/// Small triangles far from the origin, of which two of three go some way, in no order; the others are in no tree.
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

/// The children of a node at a time, as kernels read the layout.
std::vector<Child> children_of(const Accel& accel, std::uint32_t node, std::size_t step, float share) {
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
        child.box[k] = words[14] == 0 ? plane(16 * node + 6 * side + k) : between(plane(at), plane(at + 16), share);
      }
      word = words[12 + side];
      child.is_leaf = (word & kLeafBit) != 0;
      for (std::uint32_t i = 0; child.is_leaf && i <= ((word >> 28) & 7U); ++i)
        child.triangles.push_back(accel.leaves[(word & 0x0fffffffU) + i]);
    } else {
      const std::size_t record = 8 * width * (node + step);
      for (std::size_t k = 0; k < 6; ++k) {
        const std::size_t at = record + width * (2 * (k % 3) + k / 3) + side;
        child.box[k] = between(plane(at), plane(at + 8 * width), share);
      }
      word = accel.nodes[record + 6 * width + side];
      if (word == 0) {
        all.pop_back();
        continue;
      }
      child.is_leaf = (word & kLeafBit) != 0;
      for (std::size_t i = 0; child.is_leaf && i < 8; ++i) {
        const std::uint32_t triangle = accel.leaves[80 * ((word & ~kLeafBit) + step) + 72 + i];
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
  void below(std::uint32_t node, std::size_t step, float share) {
    for (const Child& child : children_of(accel_, node, step, share)) {
      boxes_.push_back(child.box);
      if (!child.is_leaf) below(child.node, step, share);
      for (const std::uint32_t triangle : child.triangles) look_at(triangle, step, share);
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
      std::uniform_real_distribution<float> unit(0.0F, 1.0F);
      SwarmWalk walk(swarm, accel);
      for (int i = 0; i < 200; ++i) walk.below(0, random() % (kPoses - 1), unit(random));
      for (const float share : {0.0F, 0x1.fffffep-1F, 1.0F}) walk.below(0, 1, share);
      EXPECT_EQ(walk.cut, 0U) << layout << far;
      EXPECT_EQ(walk.seen, 203 * swarm.moving_count) << layout << far;
    }
}

TEST(MotionTrees, records_of_a_wide_leaf_hold_the_corners_of_their_pose_and_the_last_where_these_begin) {
  const Swarm swarm(1);
  for (const char* layout : {"bvh8", "bvh16"}) {
    const Accel accel = tree_over_time(swarm, layout);
    std::size_t seen = 0;
    for (std::size_t record = 0; record < accel.leaves.size() / 80; ++record)
      for (std::size_t i = 0; i < 8; ++i) {
        const std::uint32_t triangle = accel.leaves[80 * (record - record % kPoses) + 72 + i];
        const std::uint32_t index = accel.leaves[80 * record + 72 + i];
        const bool names_record = record % kPoses == kPoses - 1 && triangle != EK_NO_HIT;
        EXPECT_EQ(index, names_record ? swarm.motion[triangle] - 1 : triangle);
        for (std::size_t k = 0; k < 9; ++k) {
          const auto corner = std::bit_cast<float>(accel.leaves[80 * record + 8 * k + i]);
          if (triangle == EK_NO_HIT) {
            EXPECT_TRUE(std::isnan(corner));
          } else {
            EXPECT_EQ(corner, swarm.moving[9 * (swarm.motion[triangle] - 1 + record % kPoses) + k]);
            ++seen;
          }
        }
      }
    EXPECT_EQ(seen, 9 * kPoses * swarm.moving_count);
  }
}

}  // namespace
}  // namespace eikon
