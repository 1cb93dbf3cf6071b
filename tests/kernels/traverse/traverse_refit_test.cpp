// SPDX-License-Identifier: Apache-2.0
// Hits do not depend on the tree: neither on reinsertion, nor on a refit to triangles that moved.
#include <gtest/gtest.h>

#include <cstring>

#include "accel/binary_tree.h"
#include "accel/layouts/layouts.h"
#include "accel/refit.h"
#include "accel/reinsertion.h"
#include "support/accel_fixtures.h"
#include "kernels/traverse/traverse_probe.h"

namespace eikon {
namespace {

class Refit : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Layouts, Refit, testing::ValuesIn(tree_layouts()), [](const auto& p) { return p.param; });

/// The tree with the boxes of triangles that have moved: sound, but as no builder would make it.
BinaryTree with_boxes_of(TriangleSoup moved, BinaryTree tree) {
  for (auto n = std::uint32_t(tree.nodes.size()); n-- > 0;) {  // children come after their parents
    BinaryNode& node = tree.nodes[n];
    Box box;
    if (node.count == 1) {
      box = triangle_box(moved, tree.triangles[node.first]);
    } else {
      box = tree.nodes[left_child(n)].box();
      box.add(tree.nodes[right_child(tree, n)].box());
    }
    node = BinaryNode(box, node.count, node.first);
  }
  return tree;
}

/// The tree over `soup`, improved by reinsertion, with the boxes of the moved triangles; by refit()
/// if it knows the layout.
Accel followed_tree(const fixtures::Soup& soup, const fixtures::Soup& moved, const std::string& layout) {
  BinaryTree tree = build_binary_tree({soup});
  EXPECT_TRUE(reinsert(tree));
  const std::optional<Accel> refitted = refit(lay_out(tree, {soup}, layout), {moved});
  EXPECT_EQ(refitted.has_value(), layout == "bvh2" || layout == "bvh8" || layout == "bvh16") << layout;
  return refitted ? *refitted : lay_out(with_boxes_of({moved}, std::move(tree)), {moved}, layout);
}

TEST_P(Refit, hits_are_those_of_a_new_tree_to_the_bit) {
  Device& device = *test::devices().front();
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  const fixtures::Soup soup = fixtures::room();
  fixtures::Soup now = soup;
  for (float& x : now) x += 0.1F * unit(random);  // boxes overlap many times as much
  std::vector<ProbeRay> rays(20'000);
  for (ProbeRay& ray : rays) {
    for (float& x : ray.o) x = 5.0F * unit(random);
    for (float& x : ray.d) x = unit(random);
  }
  TraverseProbe::Options options;
  options.layout = GetParam();
  TraverseProbe fresh(device, now, options);
  options.accel = followed_tree(soup, now, GetParam());
  TraverseProbe followed(device, now, options);
  const auto expected = fresh.closest(rays), hits = followed.closest(rays);
  std::size_t hit_count = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(std::memcmp(&hits[i], &expected[i], sizeof(ProbeHit)), 0) << i;
    hit_count += hits[i].triangle != EK_NO_HIT ? 1 : 0;
  }
  EXPECT_GT(hit_count, rays.size() / 10);
  EXPECT_EQ(followed.any(rays), fresh.any(rays));
}

}  // namespace
}  // namespace eikon
