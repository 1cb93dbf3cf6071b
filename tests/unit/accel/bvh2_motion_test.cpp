// SPDX-License-Identifier: Apache-2.0
// Boxes of nodes between poses hold the triangles below them at any time, to the last bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <random>
#include <vector>

#include "accel/accel.h"

namespace eikon {
namespace {

constexpr std::size_t kPoses = 4, kTriangles = 400;

/// The way of a plane in kernels/traverse/gpu/bvh2.h.
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

class SwarmWalk {
 public:
  SwarmWalk(const Swarm& swarm, const Accel& accel) : swarm_(swarm), accel_(accel) {}

  /// Looks at all triangles below a node, and counts the planes that cut one off at this time.
  void below(std::uint32_t node, std::size_t step, float share) {
    const std::uint32_t* const words = &accel_.nodes[16 * node];
    for (std::size_t side = 0; side < 2; ++side) {
      float box[6];
      for (std::size_t k = 0; k < 6; ++k) {
        const auto plane = [&](std::size_t record) {
          return std::bit_cast<float>(accel_.nodes[16 * record + 6 * side + k]);
        };
        box[k] = words[14] == 0 ? plane(node) : between(plane(words[14] + step), plane(words[14] + step + 1), share);
      }
      boxes_.push_back(std::to_array(box));
      const std::uint32_t word = words[12 + side];
      if ((word & kLeafBit) == 0)
        below(word, step, share);
      else
        for (std::uint32_t i = 0; i <= ((word >> 28) & 7U); ++i)
          look_at(accel_.leaves[(word & 0x0fffffffU) + i], step, share);
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

TEST(Bvh2Motion, boxes_between_poses_cut_no_corner_off) {
  for (const float far : {0.0F, 100.0F, 3e4F}) {
    const Swarm swarm(far);
    const TriangleSoup soup(swarm.soup.data(), kTriangles, 9, 0, swarm.motion.data());
    const TrianglePoses poses{.motion = swarm.motion.data(), .corners = swarm.moving.data(), .count = kPoses};
    AccelOptions options;
    options.layout = "bvh2";
    options.poses = &poses;
    const Accel accel = build_accel(soup, options);
    std::mt19937 random(9);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    SwarmWalk walk(swarm, accel);
    for (int i = 0; i < 200; ++i) walk.below(0, random() % (kPoses - 1), unit(random));
    for (const float share : {0.0F, 0x1.fffffep-1F, 1.0F}) walk.below(0, 1, share);
    EXPECT_EQ(walk.cut, 0U) << far;
    EXPECT_EQ(walk.seen, 203 * swarm.moving_count) << far;
  }
}

}  // namespace
}  // namespace eikon
