// SPDX-License-Identifier: Apache-2.0
// Trees whose boxes follow triangles that move from frame to frame.
#include "accel/refit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "accel/binary_tree.h"

namespace eikon {
namespace {

constexpr std::size_t kCubeTriangles = 3000;
const std::vector<std::string> kLayouts = {"bvh2", "bvh8", "bvh16"};

/// Small triangles in a cube.
std::vector<float> scattered_cube(unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::vector<float> corners;
  for (std::size_t i = 0; i < kCubeTriangles; ++i) {
    const float at[3] = {10 * unit(random), 10 * unit(random), 10 * unit(random)};
    for (std::size_t k = 0; k < 9; ++k) corners.push_back(at[k % 3] + 0.2F * unit(random));
  }
  return corners;
}

/// The same, bent by a wave of this height.
std::vector<float> bent(std::vector<float> corners, float height) {
  for (std::size_t i = 0; i < corners.size(); i += 3) corners[i + 1] += height * std::sin(0.3F * corners[i]);
  return corners;
}

Accel built(const std::vector<float>& corners, const std::string& layout) {
  return build_accel(TriangleSoup(corners), {.accel = "bvh", .layout = layout});
}

bool same_words(const Accel& a, const Accel& b) {
  return std::ranges::equal(a.nodes, b.nodes) && std::ranges::equal(a.leaves, b.leaves);
}

TEST(Refit, to_the_same_triangles_changes_nothing_and_there_and_back_neither) {
  const std::vector<float> here = scattered_cube(), there = bent(here, 3);
  for (const std::string& layout : kLayouts) {
    const Accel tree = built(here, layout);
    const std::optional<Accel> same = refit(tree, TriangleSoup(here)), moved = refit(tree, TriangleSoup(there));
    ASSERT_TRUE(same && moved) << layout;
    EXPECT_TRUE(same_words(tree, *same)) << layout;
    EXPECT_FALSE(same_words(tree, *moved)) << layout;
    const std::optional<Accel> back = refit(*moved, TriangleSoup(here));
    ASSERT_TRUE(back) << layout;
    EXPECT_TRUE(same_words(tree, *back)) << layout;
  }
}

TEST(Refit, of_one_triangle_and_of_none_is_no_other_tree_than_a_new_one) {
  const std::vector<float> here = {0, 0, 0, 1, 0, 0, 0, 1, 0}, there = bent(here, 3);
  for (const std::string& layout : kLayouts) {
    const std::optional<Accel> moved = refit(built(here, layout), TriangleSoup(there));
    ASSERT_TRUE(moved) << layout;
    EXPECT_TRUE(same_words(*moved, built(there, layout))) << layout;
    // Nothing tells the caller to build anew.
    const std::optional<Accel> none = refit(built({}, layout), TriangleSoup(std::span<const float>()));
    EXPECT_TRUE(!none || same_words(*none, built({}, layout))) << layout;
  }
}

/// Every box of a bvh2 is the union of the boxes of the triangles below it. Returns that of a node.
Box check_node(const Accel& tree, TriangleSoup soup, std::size_t node, std::size_t& seen) {
  Box all;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::uint32_t word = tree.nodes[16 * node + 12 + side];
    Box below;
    if ((word & kLeafBit) == 0) {
      below = check_node(tree, soup, word, seen);
    } else {
      const std::uint32_t first = word & 0x0fffffffU, count = ((word >> 28U) & 7U) + 1;
      for (std::uint32_t i = first; i < first + count; ++i, ++seen) below.add(triangle_box(soup, tree.leaves[i]));
    }
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(std::bit_cast<float>(tree.nodes[16 * node + 6 * side + std::size_t(axis)]), float{below.lo[axis]});
      EXPECT_EQ(std::bit_cast<float>(tree.nodes[16 * node + 6 * side + 3 + std::size_t(axis)]), float{below.hi[axis]});
    }
    all.add(below);
  }
  return all;
}

TEST(Refit, boxes_are_those_of_the_triangles_below_them) {
  const std::vector<float> there = bent(scattered_cube(), 2);
  const std::optional<Accel> moved = refit(built(scattered_cube(), "bvh2"), TriangleSoup(there));
  ASSERT_TRUE(moved);
  std::size_t seen = 0;
  (void)check_node(*moved, TriangleSoup(there), 0, seen);
  EXPECT_EQ(seen, kCubeTriangles);
}

TEST(Refit, leaves_have_the_corners_and_wide_boxes_those_of_the_binary_tree) {
  const std::vector<float> there = bent(scattered_cube(), 2);
  for (const std::size_t width : {std::size_t{8}, std::size_t{16}}) {
    const std::optional<Accel> moved = refit(built(scattered_cube(), "bvh" + std::to_string(width)), TriangleSoup(there));
    ASSERT_TRUE(moved);
    std::size_t seen = 0;
    for (std::size_t block = 0; block < moved->leaves.size(); block += 80)
      for (std::size_t i = 0; i < 8; ++i) {
        const std::uint32_t triangle = moved->leaves[block + 72 + i];
        if (triangle == EK_NO_HIT) continue;
        ++seen;
        for (std::size_t k = 0; k < 9; ++k)
          EXPECT_EQ(std::bit_cast<float>(moved->leaves[block + 8 * k + i]), there[9 * triangle + k]);
      }
    EXPECT_EQ(seen, kCubeTriangles);
    float top = -1e30F, highest = -1e30F;  // of the root's children, and of all corners
    for (std::size_t k = 0; k < width; ++k) top = std::max(top, std::bit_cast<float>(moved->nodes[3 * width + k]));
    for (std::size_t i = 1; i < there.size(); i += 3) highest = std::max(highest, there[i]);
    EXPECT_EQ(top, highest);
  }
}

TEST(Refit, is_refused_where_other_triangles_can_be_hit) {
  const std::vector<float> here = scattered_cube();
  std::vector<float> flat = here;
  std::copy_n(&flat[0], 3, &flat[3]);  // two corners of the first triangle coincide
  for (const std::string& layout : kLayouts) {
    EXPECT_FALSE(refit(built(here, layout), TriangleSoup(flat))) << layout;
    EXPECT_FALSE(refit(built(flat, layout), TriangleSoup(here))) << layout;
    EXPECT_TRUE(refit(built(flat, layout), TriangleSoup(flat))) << layout;
    const std::vector<float> fewer(here.begin(), here.end() - 9);
    EXPECT_FALSE(refit(built(here, layout), TriangleSoup(fewer))) << layout;
    EXPECT_FALSE(refit(built(fewer, layout), TriangleSoup(here))) << layout;
    std::vector<float> other = here;  // as many with area, but another one without
    std::copy_n(&other[9], 3, &other[12]);
    EXPECT_FALSE(refit(built(flat, layout), TriangleSoup(other))) << layout;
    std::vector<float> unknown = here;
    unknown[100] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(refit(built(here, layout), TriangleSoup(unknown))) << layout;
  }
  EXPECT_FALSE(refit(built(here, "cwbvh"), TriangleSoup(here)));
}

TEST(Refit, trees_follow_as_long_as_they_cost_little_more_and_are_built_anew_then) {
  const std::vector<float> here = scattered_cube(), near = bent(here, 0.05F), elsewhere = scattered_cube(2);
  for (const std::string& layout : kLayouts) {
    const AccelOptions options{.accel = "bvh", .layout = layout};
    TreeMemory memory;
    EXPECT_TRUE(same_words(memory.tree(TriangleSoup(here), options), built(here, layout))) << layout;
    const Accel followed = memory.tree(TriangleSoup(near), options);
    EXPECT_TRUE(same_words(followed, *refit(built(here, layout), TriangleSoup(near)))) << layout;
    EXPECT_FALSE(same_words(followed, built(near, layout))) << layout;
    EXPECT_LE(tree_area(followed), kMaxRefitCost * tree_area(built(here, layout))) << layout;
    EXPECT_TRUE(same_words(memory.tree(TriangleSoup(elsewhere), options), built(elsewhere, layout)))
        << layout << ": the triangles are in another order, which the old tree does not suit";
  }
}

}  // namespace
}  // namespace eikon
