// SPDX-License-Identifier: Apache-2.0
// Hits do not depend on the tree: neither on reinsertion, nor on a refit to triangles that moved.
#include <gtest/gtest.h>

#include <cstring>

#include "accel/layouts/layouts.h"
#include "accel/reinsertion.h"
#include "support/accel_fixtures.h"
#include "kernels/traverse/traverse_probe.h"
#include "support/refit.h"

namespace eikon {
namespace {

class Refit : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Layouts, Refit, testing::ValuesIn(tree_layouts()), [](const auto& p) { return p.param; });

TEST_P(Refit, hits_are_those_of_a_new_tree_to_the_bit) {
  Device& device = *test::devices().front();
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  const fixtures::Soup soup = fixtures::room();
  fixtures::Soup now = soup;
  for (float& x : now) x += 0.1F * unit(random);  // boxes overlap many times as much
  BinaryTree tree = build_binary_tree({soup});
  ASSERT_TRUE(reinsert(tree));
  const auto refit = refitted(tree, {now});
  ASSERT_TRUE(refit.has_value());

  std::vector<ProbeRay> rays(20'000);
  for (ProbeRay& ray : rays) {
    for (float& x : ray.o) x = 5.0F * unit(random);
    for (float& x : ray.d) x = unit(random);
  }
  TraverseProbe::Options options;
  options.layout = GetParam();
  TraverseProbe fresh(device, now, options);
  options.accel = lay_out(*refit, {now}, GetParam());
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
