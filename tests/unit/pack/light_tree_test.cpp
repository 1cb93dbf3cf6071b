// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/light_tree.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <random>
#include <set>

namespace eikon {
namespace {

double uniform(std::mt19937& random) { return double(random()) / 4294967296.0; }

std::vector<LightMoments> scattered_lights(std::size_t count, double decades = 4) {
  std::mt19937 random(1);
  std::vector<LightMoments> lights(count);
  for (LightMoments& l : lights) {
    l.power = std::pow(10.0, decades * uniform(random));
    l.centroid = glm::dvec3(uniform(random), uniform(random), uniform(random)) * 10.0;
    l.variance = 1e-4 * uniform(random);
    l.mean_direction = glm::normalize(glm::dvec3(uniform(random), uniform(random), uniform(random)) - 0.5);
  }
  return lights;
}

/// Follows every link. depth: of the deepest light
struct Walk {
  const LightTree& tree;
  std::set<std::uint32_t> nodes, lights;
  int depth = 0;

  explicit Walk(const LightTree& t) : tree(t) {
    if (!tree.nodes.empty()) visit(0, 0, std::uint32_t(tree.order.size()), 1);
  }
  void visit(std::uint32_t node, std::uint32_t first, std::uint32_t count, int level) {
    ASSERT_LT(node, tree.nodes.size());
    ASSERT_TRUE(nodes.insert(node).second) << "node " << node << " has two parents";
    const std::uint32_t left = tree.nodes[node].link & ~LIGHT_TREE_RIGHT_IS_LIGHT;
    ASSERT_GE(left, 1U);
    ASSERT_LT(left, count);
    ASSERT_EQ((tree.nodes[node].link & LIGHT_TREE_RIGHT_IS_LIGHT) != 0, count - left == 1);
    depth = std::max(depth, level);
    if (left == 1)
      lights.insert(first);
    else
      visit(node + 1, first, left, level + 1);
    if (count - left == 1)
      lights.insert(first + left);
    else
      visit(node + left, first + left, count - left, level + 1);
  }
};

TEST(LightTree, its_links_lead_to_every_light_once_however_lights_lie) {
  std::vector<std::vector<LightMoments>> scenes;
  for (const std::size_t count : {2U, 3U, 4U, 17U, 1000U}) scenes.push_back(scattered_lights(count));
  scenes.push_back(scattered_lights(100000, 20));  // L16
  scenes.back()[54321].power = 1e30;
  scenes.emplace_back(1000);  // all in one place
  for (LightMoments& l : scenes.back()) l.power = 3;
  scenes.emplace_back();  // ever nearer to one place: bins would take one off at a time
  for (int i = 0; i < 500; ++i) {
    LightMoments l;
    l.power = std::pow(2.0, -i);
    l.centroid = glm::dvec3(std::pow(0.25, i), 0, 0);
    scenes.back().push_back(l);
  }
  for (const auto& lights : scenes) {
    const LightTree tree = build_light_tree(lights);
    ASSERT_EQ(tree.nodes.size() + 1, lights.size());
    auto order = tree.order;
    std::sort(order.begin(), order.end());
    for (std::uint32_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], i);
    const Walk walk(tree);
    EXPECT_EQ(walk.nodes.size(), tree.nodes.size());
    EXPECT_EQ(walk.lights.size(), lights.size());
    EXPECT_LE(walk.depth, 3 * int(std::bit_width(lights.size())) + 9) << lights.size() << " lights";
    for (const LightNode& n : tree.nodes) {
      ASSERT_TRUE(n.left_share > 0 && n.left_share < 1);
      ASSERT_TRUE(n.left_variance > 0 && std::isfinite(n.left_variance) && n.right_variance > 0 &&
                  std::isfinite(n.right_variance));
      ASSERT_TRUE(std::isfinite(n.left_centroid_x + n.left_centroid_y + n.left_centroid_z + n.right_centroid_x + n.right_centroid_y + n.right_centroid_z));
    }
  }
}

TEST(LightTree, the_moments_of_its_root_are_those_of_the_lights) {
  const auto lights = scattered_lights(1000);
  const LightTree tree = build_light_tree(lights);
  const LightNode& root = tree.nodes.front();
  const std::uint32_t left = root.link & ~LIGHT_TREE_RIGHT_IS_LIGHT;
  double power = 0, all = 0;
  glm::dvec3 centroid(0), mean_direction(0);
  for (std::uint32_t i = 0; i < lights.size(); ++i) {
    const LightMoments& l = lights[tree.order[i]];
    all += l.power;
    if (i >= left) continue;
    power += l.power;
    centroid += l.power * l.centroid;
    mean_direction += l.power * l.mean_direction;
  }
  centroid /= power;
  double variance = 0;
  for (std::uint32_t i = 0; i < left; ++i) {
    const LightMoments& l = lights[tree.order[i]];
    variance += l.power / power * (l.variance + glm::dot(l.centroid - centroid, l.centroid - centroid));
  }
  const double scale = double(tree.scale);
  EXPECT_NEAR(double(root.left_share), power / all, 1e-6);
  EXPECT_NEAR(double(root.left_centroid_x), centroid.x * scale, 1e-6);
  EXPECT_NEAR(double(root.left_centroid_y), centroid.y * scale, 1e-6);
  EXPECT_NEAR(double(root.left_centroid_z), centroid.z * scale, 1e-6);
  EXPECT_NEAR(double(root.left_variance), variance * scale * scale, 1e-6);
  EXPECT_NEAR(double(root.left_mean_direction_x), mean_direction.x / power, 1e-6);
}

TEST(LightTree, is_the_same_for_a_scene_twice_and_for_one_scaled_by_a_power_of_two) {
  const auto lights = scattered_lights(5000);
  auto scaled = lights;
  for (LightMoments& l : scaled) {
    l.centroid *= 0x1p20;
    l.variance *= 0x1p40;
    l.power *= 0x1p40;
  }
  const LightTree a = build_light_tree(lights), b = build_light_tree(lights), c = build_light_tree(scaled);
  const auto same = [](const LightTree& x, const LightTree& y) {
    return x.order == y.order && std::memcmp(x.nodes.data(), y.nodes.data(), x.nodes.size() * sizeof(LightNode)) == 0;
  };
  EXPECT_TRUE(same(a, b));
  EXPECT_TRUE(same(a, c));
  EXPECT_EQ(a.scale, c.scale * 0x1p20F);
}

TEST(LightTree, does_not_depend_on_threads) {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  const std::vector<LightMoments> lights = scattered_lights(20'000);
  LightTree alone;
  for (const int threads : {1, 2, 4}) {
    LightTree tree;
    tbb::task_arena(threads).execute([&] { tree = build_light_tree(lights); });
    if (threads == 1) alone = tree;
    EXPECT_EQ(tree.order, alone.order) << threads;
    ASSERT_EQ(tree.nodes.size(), alone.nodes.size()) << threads;
    EXPECT_EQ(std::memcmp(tree.nodes.data(), alone.nodes.data(), tree.nodes.size() * sizeof(LightNode)), 0) << threads;
  }
}

TEST(LightTree, one_light_or_none_needs_no_nodes_and_nonsense_is_refused) {
  EXPECT_TRUE(build_light_tree({}).nodes.empty());
  EXPECT_TRUE(build_light_tree(scattered_lights(1)).nodes.empty());
  for (const int what : {0, 1, 2, 3}) {
    auto lights = scattered_lights(3);
    if (what == 0) lights[1].power = 0;
    if (what == 1) lights[1].power = INFINITY;
    if (what == 2) lights[1].centroid.y = NAN;
    if (what == 3) lights[1].variance = INFINITY;
    EXPECT_THROW(build_light_tree(lights), std::runtime_error) << what;
  }
}

}  // namespace
}  // namespace eikon
