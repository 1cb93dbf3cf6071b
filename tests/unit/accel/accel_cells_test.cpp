// SPDX-License-Identifier: Apache-2.0
// Grids, octrees, kd-trees and BSP trees: nothing is left out of a cell that it is in, held against
// whole numbers; the same arrays for any number of threads; bounded lists, whatever the triangles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "accel/accel.h"
#include "accel/classic/cells.h"
#include "support/accel_fixtures.h"
#include "core/error.h"
#include "support/messages.h"

namespace eikon {
namespace {

using fixtures::Soup;
using test::contains;
using test::message_of;
using Whole = std::int64_t;
using WholeVector = std::array<Whole, 3>;

WholeVector minus(const WholeVector& a, const WholeVector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
WholeVector cross(const WholeVector& a, const WholeVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Whole dot(const WholeVector& a, const WholeVector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Whether triangle and box (both closed) share a point: exactly, by all 13 axes that can part
/// them.
bool overlap(const std::array<WholeVector, 3>& p, const WholeVector& lo, const WholeVector& hi) {
  std::vector<WholeVector> axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, cross(minus(p[1], p[0]), minus(p[2], p[0]))};
  for (std::size_t edge = 0; edge < 3; ++edge)
    for (std::size_t k = 0; k < 3; ++k) axes.push_back(cross(minus(p[(edge + 1) % 3], p[edge]), axes[k]));
  for (const WholeVector& axis : axes) {
    Whole box_lo = 0, box_hi = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      box_lo += axis[k] * (axis[k] < 0 ? hi[k] : lo[k]);
      box_hi += axis[k] * (axis[k] < 0 ? lo[k] : hi[k]);
    }
    const auto [low, high] = std::minmax({dot(axis, p[0]), dot(axis, p[1]), dot(axis, p[2])});
    if (high < box_lo || low > box_hi) return false;
  }
  return true;
}

/// Random triangles of small whole numbers, in which touching is common; `scale` and `shift` are
/// exact in floats.
struct WholeTriangles {
  std::vector<std::array<WholeVector, 3>> corners;
  Soup soup;
  WholeTriangles(std::size_t count, int range, float scale, float shift) {
    std::mt19937 random(5);
    std::uniform_int_distribution<int> whole(-range, range);
    while (corners.size() < count) {
      std::array<WholeVector, 3> p{};
      for (auto& corner : p)
        for (Whole& x : corner) x = whole(random);
      if (cross(minus(p[1], p[0]), minus(p[2], p[0])) == WholeVector{}) continue;
      corners.push_back(p);
      for (const auto& corner : p)
        for (const Whole x : corner) soup.push_back(shift + scale * static_cast<float>(x));
    }
  }
};

TEST(Cells, no_part_of_a_box_that_its_triangle_is_in_is_left_out) {
  for (const auto& [scale, shift] : {std::pair{1.0F, 0.0F}, {0x1p-60F, 0.0F}, {0x1p60F, 0.0F}, {0x1p-8F, 0x1p13F}}) {
    const WholeTriangles triangles(400, 8, scale, shift);
    const CellScene scene({triangles.soup});
    const CellReferences references = scene.references();
    ASSERT_EQ(references.size(), triangles.corners.size());
    std::mt19937 random(6);
    std::uniform_int_distribution<int> whole(-8, 8);
    std::size_t meet = 0, kept_apart = 0, left_out = 0;
    for (const CellReference& reference : references) {
      for (int box = 0; box < 200; ++box) {
        WholeVector lo{}, hi{};
        for (std::size_t k = 0; k < 3; ++k) {
          lo[k] = whole(random), hi[k] = whole(random);
          if (hi[k] < lo[k]) std::swap(lo[k], hi[k]);
        }
        CellReference part = reference;
        bool there = true;
        for (std::size_t k = 0; k < 3; ++k) {
          part.lo[k] = std::max(part.lo[k], shift + scale * static_cast<float>(lo[k]));
          part.hi[k] = std::min(part.hi[k], shift + scale * static_cast<float>(hi[k]));
          there = there && part.lo[k] <= part.hi[k];
        }
        const bool meets = overlap(triangles.corners[reference.triangle], lo, hi);
        if (meets) {
          ASSERT_TRUE(there && scene.may_be_hit(part));
          ++meet;
        } else if (there) {
          ++(scene.may_be_hit(part) ? kept_apart : left_out);
        }
      }
    }
    EXPECT_GT(meet, 10'000U);
    EXPECT_GT(left_out, kept_apart / 2) << scale;  // it is of use, too
  }
}

TEST(Cells, a_region_reaches_all_of_its_triangle) {
  const WholeTriangles triangles(300, 8, 1.0F, 0.0F);
  const CellScene scene({triangles.soup});
  std::size_t polygons = 0;
  for (std::uint32_t i = 0; i < scene.size(); ++i) {
    const CellScene::Region region = scene.region(i);
    if (region.polygon.empty()) continue;
    ++polygons;
    ASSERT_GE(region.polygon.size(), 3U);
    // As far in every direction as the triangle, and no further than its box but for the slack.
    for (int x = -2; x <= 2; ++x) {
      for (int y = -2; y <= 2; ++y) {
        for (int z = -2; z <= 2; ++z) {
          const HalfSpace half{{double(x), double(y), double(z)}, 0};
          double of_polygon = -1e30, of_triangle = -1e30;
          for (const Point3& p : region.polygon) of_polygon = std::max(of_polygon, half.height(p));
          for (const Point3& p : scene.corners(i)) of_triangle = std::max(of_triangle, half.height(p));
          EXPECT_GE(of_polygon, of_triangle - 1e-9);
          if (std::abs(x) + std::abs(y) + std::abs(z) == 1) {
            EXPECT_LE(of_polygon, of_triangle + 2 * region.slack);
          }
        }
      }
    }
  }
  EXPECT_GT(polygons, 200U);
}

TEST(Cells, a_solid_is_cut_into_two_whose_surfaces_are_known) {
  const Solid cube = box_solid({0, 0, 0}, {2, 2, 2});
  EXPECT_DOUBLE_EQ(cube.area(), 24);
  const HalfSpace middle{{1, 0, 0}, 1};
  EXPECT_DOUBLE_EQ(cut_areas(cube, middle).front, 16);
  EXPECT_DOUBLE_EQ(clipped(cube, middle).area(), 16);
  const double root = std::sqrt(0.5);
  const HalfSpace diagonal{{root, root, 0}, 2 * root};  // half a cube: 2 triangles of 2, 2 faces of 4, and 2 x 2 sqrt 2
  EXPECT_NEAR(cut_areas(cube, diagonal).behind, 12 + 4 * std::sqrt(2), 1e-12);
  EXPECT_NEAR(clipped(cube, diagonal.opposite()).area(), 12 + 4 * std::sqrt(2), 1e-12);
  const HalfSpace beyond{{0, 0, 1}, 3};
  EXPECT_DOUBLE_EQ(cut_areas(cube, beyond).front, 0);
  EXPECT_DOUBLE_EQ(cut_areas(cube, beyond).behind, 24);
}

class Accelerators : public testing::TestWithParam<std::string> {
 protected:
  static Accel build(const Soup& soup, unsigned threads = 0) {
    AccelOptions options;
    options.accel = GetParam();
    options.layout = "bvh2";
    options.threads = threads;
    return build_accel({soup}, options);
  }
};
std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(All, Accelerators, testing::ValuesIn(accelerator_names()), test_name);

TEST_P(Accelerators, are_the_same_for_any_number_of_threads) {
  const Soup soup = fixtures::room();
  const Accel one = build(soup, 1);
  EXPECT_EQ(one.name, GetParam());
  for (const unsigned threads : {2U, 5U}) {
    const Accel other = build(soup, threads);
    EXPECT_EQ(other.nodes, one.nodes);
    EXPECT_EQ(other.leaves, one.leaves);
    EXPECT_EQ(other.stack_size, one.stack_size);
  }
}

TEST_P(Accelerators, are_built_with_bounded_lists_over_whatever_triangles) {
  const auto with = [](Soup soup, const Soup& more) {
    soup.insert(soup.end(), more.begin(), more.end());
    return soup;
  };
  Soup copies, needles, far_apart, fan;
  std::mt19937 random(9);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  for (int i = 0; i < 3000; ++i) {
    fixtures::add_triangle(copies, {0, 0, 0}, {1, 0, 0}, {0, 1, 0.5F});
    const float x = unit(random), y = unit(random), z = unit(random);
    fixtures::add_triangle(needles, {-x, -y, -z}, {x, y, z}, {x, y + 1e-6F, z});
    fixtures::add_triangle(fan, {0, 0, 0}, {x, y, z},
                           {unit(random), unit(random), unit(random)});  // all share a corner
    const float s = std::exp2(60 * unit(random));
    fixtures::add_triangle(far_apart, {s * x, s * y, s * z}, {s, s * y, s * z}, {s * x, s, s * z});
  }
  const Soup huge_among_small = with(fixtures::scattered(3000, 0.01F, 4), {-100, -90, -80, 100, 80, 90, -70, 100, 95});
  Soup flat = fixtures::scattered(3000, 1.0F, 6);
  for (std::size_t i = 1; i < flat.size(); i += 3) flat[i] = 0.25F;
  for (const Soup& soup :
       {Soup{}, copies, needles, fan, far_apart, huge_among_small, flat, fixtures::scattered(1, 1, 1),
        Soup{-1e38F, -1e38F, -1e38F, 1e38F, 1e38F, -1e38F, 0, 1e38F, 1e38F},
        Soup{1e-40F, 0, 0, 0, 1e-40F, 0, 0, 0, 1e-40F}}) {
    const Accel accel = build(soup);
    const std::size_t triangles = soup.size() / 9;
    EXPECT_LE(accel.leaves.size(), 17 * triangles + 2 * accel.node_count + 4096 + 16);
    EXPECT_LE(accel.stack_size, 256U);
    if (accel.layout == "octree") continue;  // numbers of triangles lie between them
    std::set<std::uint32_t> listed(accel.leaves.begin(), accel.leaves.end());
    for (std::uint32_t i = 0; i < triangles; ++i) {
      if (!is_degenerate(&soup[9 * i])) {
        EXPECT_EQ(listed.count(i), 1U);
      }
    }
  }
}

TEST(AcceleratorNames, an_unknown_name_is_told_the_known_ones) {
  AccelOptions options;
  options.accel = "quadtree";
  const Soup soup = fixtures::scattered(1, 1, 1);
  const std::string message = message_of<UsageError>([&] { (void)build_accel({soup}, options); });
  EXPECT_TRUE(contains(message, "kdtree-rotate"));
}

}  // namespace
}  // namespace eikon
