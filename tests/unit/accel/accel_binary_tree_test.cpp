// SPDX-License-Identifier: Apache-2.0
// The binary tree from which layouts are made: as built, and improved by reinsertion.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <bit>
#include <cmath>
#include <limits>

#include "accel/layouts/layouts.h"
#include "accel/reinsertion.h"
#include "support/accel_fixtures.h"
#include "pack/settings.h"

namespace eikon {
namespace {

using fixtures::room;
using fixtures::Soup;

Soup repeated(int count, float size) {
  Soup soup;
  for (int i = 0; i < count; ++i) fixtures::add_triangle(soup, {0, 0, 0}, {size, 0, 0}, {0, size, 0});
  return soup;
}

/// Checks all that the header promises. returns the number of levels
std::uint32_t check(const BinaryTree& tree, const Soup& soup) {
  std::vector<int> seen(soup.size() / 9, 0);
  std::vector<std::array<std::uint32_t, 3>> todo;  // node, first triangle, level
  if (!tree.nodes.empty()) todo.push_back({0, 0, 1});
  std::uint32_t levels = 0, visited = 0;
  while (!todo.empty()) {
    const auto [n, first, level] = todo.back();
    todo.pop_back();
    levels = std::max(levels, level);
    ++visited;
    const BinaryNode& node = tree.nodes.at(n);
    EXPECT_EQ(node.first, first);
    Box box;
    if (node.count == 1) {
      const std::uint32_t triangle = tree.triangles.at(first);
      ++seen.at(triangle);
      box = triangle_box(&soup[9 * std::size_t{triangle}]);
    } else {
      const std::uint32_t left = left_child(n), right = right_child(tree, n), lefts = tree.nodes.at(left).count;
      EXPECT_EQ(lefts + tree.nodes.at(right).count, node.count);
      box = tree.nodes.at(left).box();
      box.add(tree.nodes.at(right).box());
      todo.push_back({left, first, level + 1});
      todo.push_back({right, first + lefts, level + 1});
    }
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(node.lo[axis], box.lo[axis]);
      EXPECT_EQ(node.hi[axis], box.hi[axis]);
    }
  }
  EXPECT_EQ(visited, tree.nodes.size());
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i], is_degenerate(&soup[9 * i]) ? 0 : 1);
  return levels;
}

void expect_same(const BinaryTree& a, const BinaryTree& b) {
  EXPECT_EQ(a.triangles, b.triangles);
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    using Words = std::array<std::uint32_t, sizeof(BinaryNode) / 4>;
    ASSERT_EQ(std::bit_cast<Words>(a.nodes[i]), std::bit_cast<Words>(b.nodes[i])) << i;
  }
}

double cost(const BinaryTree& tree, const Soup& soup) { return lay_out(tree, {soup}, "bvh8").sah_cost; }

std::vector<Soup> hard_soups() {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  std::vector<Soup> soups{repeated(3000, 1.0F), repeated(3000, 1e-20F), repeated(1, 1.0F), {}};
  soups.push_back(Soup(900, 2.5F));  // all at one point: none has area
  for (const float scale : {1e-12F, 1e8F, 1e16F, 1e25F, 3e37F}) soups.push_back(fixtures::scattered(2000, scale, 9));
  soups.push_back(fixtures::scattered(2000, 1.0F, 10));
  for (std::size_t i = 0; i < soups.back().size(); i += 90) soups.back()[i] = i % 180 == 0 ? nan : inf;
  soups.push_back(fixtures::scattered(2000, 1.0F, 11));  // and one that stretches every bin
  fixtures::add_triangle(soups.back(), {1e30F, 0, 0}, {2e30F, 0, 0}, {1e30F, 1e30F, 0});
  soups.emplace_back();  // long ones that all overlap: no split separates them, no bound ends a search early
  for (int i = 0; i < 2000; ++i) {
    const float x = 1e-3F * static_cast<float>(i);
    fixtures::add_triangle(soups.back(), {-9, x, -9 - x}, {9, 2 - x, 9}, {x, -9, 9});
  }
  return soups;
}

TEST(BinaryTree, is_whole_for_degenerate_coincident_huge_and_tiny_triangles) {
  for (const Soup& soup : hard_soups()) {
    BinaryTree tree = build_binary_tree({soup});
    const double limit = 65 + std::log2(1.0 + static_cast<double>(tree.triangles.size()));
    EXPECT_LE(check(tree, soup), limit);
    const BinaryTree before = tree;
    if (!reinsert(tree)) expect_same(tree, before);
    EXPECT_LE(check(tree, soup), limit);
  }
}

TEST(BinaryTree, reinsertion_makes_a_room_cheaper) {
  const Soup soup = room();
  BinaryTree tree = build_binary_tree({soup});
  const double before = cost(tree, soup);
  ASSERT_TRUE(reinsert(tree));
  check(tree, soup);
  EXPECT_LT(cost(tree, soup), 0.95 * before);
}

TEST(BinaryTree, reinsertion_keeps_subtrees_that_layouts_test_at_once) {
  const Soup soup = room();
  const BinaryTree before = build_binary_tree({soup});
  BinaryTree after = before;
  ASSERT_TRUE(reinsert(after));
  const auto units = [](const BinaryTree& tree) {  // sorted triangles of each largest subtree of at most 8
    std::vector<std::vector<std::uint32_t>> all;
    for (std::uint32_t n = 0; n < tree.nodes.size();) {
      const BinaryNode& node = tree.nodes[n];
      if (node.count > 8) {
        ++n;
        continue;
      }
      all.emplace_back(tree.triangles.begin() + node.first, tree.triangles.begin() + node.first + node.count);
      std::sort(all.back().begin(), all.back().end());
      n += 2 * node.count - 1;
    }
    return all;
  };
  // Two units may become neighbours and one larger subtree of at most 8; none is torn apart.
  std::vector<std::size_t> unit_of(soup.size() / 9);
  const auto now = units(after);
  for (std::size_t u = 0; u < now.size(); ++u) {
    for (const std::uint32_t triangle : now[u]) unit_of[triangle] = u;
  }
  for (const auto& unit : units(before)) {
    for (const std::uint32_t triangle : unit) EXPECT_EQ(unit_of[triangle], unit_of[unit.front()]);
  }
}

TEST(BinaryTree, reinsertion_does_not_depend_on_threads) {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  const Soup soup = room();
  std::vector<BinaryTree> trees;
  for (const int threads : {1, 2, 4}) {
    tbb::task_arena(threads).execute([&] {
      trees.push_back(build_binary_tree({soup}));
      ASSERT_TRUE(reinsert(trees.back()));
    });
  }
  expect_same(trees[0], trees[1]);
  expect_same(trees[0], trees[2]);
}

TEST(BinaryTree, reinsertion_pays_for_many_rays_and_few_triangles) {
  EXPECT_FALSE(reinsertion_pays(1000, 0));
  EXPECT_FALSE(reinsertion_pays(2'000'000, 1e7));
  EXPECT_TRUE(reinsertion_pays(2'000'000, 1e8));
  EXPECT_TRUE(reinsertion_pays(10'000, 1e7));
  EXPECT_FALSE(reinsertion_pays(10'000, 1e6));
  Settings settings;
  settings.crop = {0, 0, 256, 256};
  settings.sample_end = 16;
  EXPECT_EQ(expected_rays(settings), 256 * 256 * 16 * 10);
  settings.max_depth = 2;
  EXPECT_EQ(expected_rays(settings), 256 * 256 * 16 * 4);
}

}  // namespace
}  // namespace eikon
