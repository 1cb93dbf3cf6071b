// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "accel/accel.h"
#include "support/accel_fixtures.h"
#include "support/accel_nodes.h"
#include "core/error.h"

namespace eikon {
namespace {

using fixtures::NodeChild;
using fixtures::Soup;

Accel build(const Soup& soup, const std::string& layout, unsigned threads = 0) {
  AccelOptions options;
  options.layout = layout;
  options.threads = threads;
  return build_accel({soup}, options);
}

/// What a traversal would see of the tree.
struct Walk {
  const Accel& accel;
  const Soup& soup;
  std::vector<int> seen;      // per triangle: in how many leaves
  std::uint32_t deepest = 0;  // levels of nodes
  std::uint32_t stack = 0;    // most entries that can wait
  std::uint64_t nodes = 0;
  bool boxes_hold = true;  // every triangle inside the boxes of all its ancestors

  Walk(const Accel& a, const Soup& s) : accel(a), soup(s), seen(s.size() / 9, 0) { node(0, 1, 0, {}); }

  void node(std::uint32_t index, std::uint32_t depth, std::uint32_t waiting, const std::vector<NodeChild>& ancestors) {
    ++nodes;
    deepest = std::max(deepest, depth);
    const std::vector<NodeChild> children = fixtures::node_children(accel, index);
    if (!children.empty()) waiting += fixtures::node_entries(accel, children.size());
    stack = std::max(stack, waiting + 1);  // the nearest one is there for a moment too
    for (const NodeChild& child : children) {
      auto path = ancestors;
      path.push_back(child);
      if (!child.leaf) {
        node(child.node, depth + 1, waiting, path);
        continue;
      }
      EXPECT_FALSE(child.triangles.empty());
      for (std::size_t k = 0; k < child.triangles.size(); ++k) {
        const std::size_t first = 9 * std::size_t{child.triangles[k]};
        for (std::size_t c = 0; c < 9 && !child.corners.empty(); ++c)
          EXPECT_EQ(child.corners[9 * k + c], soup[first + c]);
        leaf(child.triangles[k], path);
      }
    }
  }

  void leaf(std::uint32_t triangle, const std::vector<NodeChild>& path) {
    ++seen[triangle];
    for (const NodeChild& box : path) {
      for (std::size_t c = 0; c < 9; ++c) {
        const float x = soup[9 * std::size_t{triangle} + c];
        boxes_hold = boxes_hold && box.lo[c % 3] <= x && x <= box.hi[c % 3];
      }
    }
  }
};

class Tree : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Layouts, Tree, testing::ValuesIn(tree_layouts()), [](const auto& p) { return p.param; });

TEST_P(Tree, holds_every_triangle_once_inside_the_boxes_of_its_ancestors) {
  for (const Soup& soup : {fixtures::scattered(5000, 3.0F, 1), fixtures::scattered(7, 1.0F, 2),
                           fixtures::scattered(9, 1e8F, 3), fixtures::scattered(2, 1e-8F, 4)}) {
    const Accel accel = build(soup, GetParam());
    const Walk walk(accel, soup);
    EXPECT_TRUE(std::all_of(walk.seen.begin(), walk.seen.end(), [](int n) { return n == 1; }));
    EXPECT_TRUE(walk.boxes_hold);
    EXPECT_EQ(walk.nodes, accel.node_count);
  }
}

TEST_P(Tree, is_the_same_to_the_bit_for_any_number_of_threads) {
  const Soup soup = fixtures::scattered(150'000, 10.0F, 5);  // enough for the parallel paths of the builder
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism,
                                  4);  // also on a machine with fewer cores
  const Accel one = build(soup, GetParam(), 1);
  for (unsigned threads : {2U, 4U}) {
    const Accel more = build(soup, GetParam(), threads);
    EXPECT_EQ(one.nodes, more.nodes);
    EXPECT_EQ(one.leaves, more.leaves);
    EXPECT_EQ(one.stack_size, more.stack_size);
  }
}

TEST_P(Tree, stack_size_holds_what_the_deepest_path_can_leave_waiting) {
  for (std::uint32_t seed = 10; seed < 14; ++seed) {
    const Soup soup = fixtures::scattered(3000, 1.0F, seed);
    const Accel accel = build(soup, GetParam());
    const std::uint32_t needed = Walk(accel, soup).stack;
    EXPECT_GE(accel.stack_size, needed);
    EXPECT_LT(accel.stack_size, needed + 64);
  }
}

TEST_P(Tree, G15_copies_of_one_triangle_make_a_shallow_tree) {
  Soup soup;
  for (int i = 0; i < 10'000; ++i) fixtures::add_triangle(soup, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const Accel accel = build(soup, GetParam());
  const Walk walk(accel, soup);
  EXPECT_TRUE(std::all_of(walk.seen.begin(), walk.seen.end(), [](int n) { return n == 1; }));
  EXPECT_LE(walk.deepest, 16U);
}

TEST_P(Tree, G15_sizes_in_geometric_progression_do_not_make_a_deep_tree) {
  Soup soup;  // each triangle 1.5 times as far and as large as the last: a greedy builder peels them off one by one
  for (int i = 0; i < 200; ++i) {
    const auto s = std::pow(1.5F, static_cast<float>(i - 100));
    fixtures::add_triangle(soup, {s, 0, 0}, {1.4F * s, 0, 0}, {s, 0.4F * s, 0});
  }
  for (int i = 0; i < 2000; ++i) fixtures::add_triangle(soup, {0, 0, 0}, {1e-30F, 0, 0}, {0, 1e-30F, 0});
  const Accel accel = build(soup, GetParam());
  const Walk walk(accel, soup);
  EXPECT_TRUE(std::all_of(walk.seen.begin(), walk.seen.end(), [](int n) { return n == 1; }));
  EXPECT_LE(walk.deepest, 64U + 12U);
}

TEST_P(Tree, G15_one_triangle_and_none_make_a_tree) {
  const Soup none;
  EXPECT_TRUE(Walk(build(none, GetParam()), none).seen.empty());
  const Soup one = fixtures::scattered(1, 1.0F, 6);
  EXPECT_EQ(Walk(build(one, GetParam()), one).seen, std::vector<int>{1});
}

TEST_P(Tree, G11_triangles_without_area_are_left_out) {
  Soup soup = fixtures::scattered(100, 1.0F, 7);
  fixtures::add_triangle(soup, {1, 2, 3}, {1, 2, 3}, {1, 2, 3});        // a point
  fixtures::add_triangle(soup, {1, 2, 3}, {4, 5, 6}, {1, 2, 3});        // a repeated corner
  fixtures::add_triangle(soup, {0, 0, 0}, {1, 1, 1}, {0.5, 0.5, 0.5});  // collinear
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  fixtures::add_triangle(soup, {0, 0, 0}, {1, nan, 1}, {0, 1, 0});
  fixtures::add_triangle(soup, {0, 0, 0}, {1, inf, 1}, {0, 1, 0});
  const Accel accel = build(soup, GetParam());
  const Walk walk(accel, soup);
  std::vector<int> expected(100, 1);
  expected.resize(105, 0);
  EXPECT_EQ(walk.seen, expected);
}

TEST_P(Tree, separates_two_clusters_that_bins_cannot_tell_apart) {
  Soup soup;  // two heaps of coincident centroids 1e-3 apart, and one triangle 1e9 away that stretches the bins
  for (int i = 0; i < 64; ++i) {
    const float x = i % 2 == 0 ? 0.0F : 1e-3F;
    fixtures::add_triangle(soup, {x, 0, 0}, {x + 1e-4F, 0, 0}, {x, 1e-4F, 0});
  }
  fixtures::add_triangle(soup, {1e9F, 0, 0}, {1.1e9F, 0, 0}, {1e9F, 1e8F, 0});
  const Accel accel = build(soup, GetParam());
  EXPECT_TRUE(Walk(accel, soup).boxes_hold);
  EXPECT_LE(Walk(accel, soup).deepest, 12U);
}

TEST(Accel, a_dense_mesh_takes_less_than_72_bytes_per_triangle) {
  // 64 for the triangle's record and 64 for its normals remain within 200 together.
  const Soup soup = fixtures::bumpy_sphere(150);
  const Accel accel = build(soup, "bvh8");
  EXPECT_LT(static_cast<double>(accel.bytes()), 72.0 * static_cast<double>(soup.size()) / 9);
}

TEST(Accel, wide_nodes_list_their_children_from_far_to_near_for_every_octant) {
  for (const std::uint32_t width : {8U, 16U}) {
    const Accel accel = build(fixtures::scattered(3000, 1.0F, 15), width == 8 ? "bvh8" : "bvh16");
    const std::uint32_t bits = width == 8 ? 3 : 4;
    for (std::size_t n = 0; n < accel.node_count; ++n) {
      const std::uint32_t* words = accel.nodes.data() + 8 * width * n;
      const auto plane = [&](std::size_t i) { return std::bit_cast<float>(words[i]); };
      for (std::uint32_t octant = 0; octant < 8; ++octant) {
        std::uint32_t listed = 0;
        float last = std::numeric_limits<float>::infinity();
        for (std::size_t i = 0; i < width; ++i) {
          const std::uint32_t child = words[7 * width + i] >> bits * octant & (width - 1);
          listed |= 1U << child;
          if (!(plane(child) <= plane(width + child))) continue;  // missing
          float along = 0;
          for (std::uint32_t axis = 0; axis < 3; ++axis) {
            const float center = plane(2 * width * axis + child) + plane((2 * axis + 1) * width + child);
            along += (octant >> axis & 1U) != 0 ? -center : center;
          }
          EXPECT_LE(along, last);
          last = along;
        }
        EXPECT_EQ(listed, (1U << width) - 1U);
      }
    }
  }
}

TEST(Accel, none_lists_what_can_be_hit) {
  Soup soup = fixtures::scattered(2, 1.0F, 8);
  fixtures::add_triangle(soup, {1, 2, 3}, {1, 2, 3}, {1, 2, 3});
  const Soup more = fixtures::scattered(1, 1.0F, 9);
  soup.insert(soup.end(), more.begin(), more.end());
  AccelOptions options;
  options.accel = "none";
  const Accel accel = build_accel({soup}, options);
  EXPECT_EQ(accel.layout, "none");
  EXPECT_EQ(accel.nodes[0], 3U);
  EXPECT_EQ(accel.leaves, (DeviceVector<std::uint32_t>{0, 1, 3}));
}

TEST(Accel, expected_bytes_are_within_a_fifth_of_those_of_a_tree) {
  const Soup soup = fixtures::bumpy_sphere(64);
  for (const std::string& layout : tree_layouts()) {
    const double expected = double(expected_tree_bytes(layout, soup.size() / 9));
    EXPECT_NEAR(double(build(soup, layout).bytes()) / expected, 1, 0.2) << layout;
  }
}

TEST(Accel, unknown_names_are_usage_errors) {
  AccelOptions options;
  options.accel = "quadtree";
  EXPECT_THROW(build_accel({{}}, options), UsageError);
  options.accel = "bvh";
  options.layout = "bvh3";
  EXPECT_THROW(build_accel({{}}, options), UsageError);
}

}  // namespace
}  // namespace eikon
