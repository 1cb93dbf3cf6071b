// SPDX-License-Identifier: Apache-2.0
// Rays with a time against triangles that move: every tree over time finds the hits of brute force,
// and these are the hits of the triangles where they stand at that time.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <random>
#include <string>

#include "kernels/traverse/traverse_probe.h"
#include "support/accel_fixtures.h"
#include "support/random.h"

namespace eikon {
namespace {

constexpr std::uint32_t kSteps = 3;

/// A room of which every other triangle moves: some far, some by the last bit of a corner, some
/// through a point.
struct MovingRoom {
  std::vector<fixtures::Soup> poses;
  std::vector<bool> moves;

  /// every  of so many triangles the first moves; 0: none
  explicit MovingRoom(std::size_t every = 2) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
    const fixtures::Soup soup = fixtures::room();
    poses.assign(kSteps + 1, soup);
    for (std::size_t i = 0; i < soup.size() / 9; ++i) {
      moves.push_back(every != 0 && i % every == 0);
      if (!moves.back()) continue;
      for (fixtures::Soup& pose : poses)
        for (std::size_t k = 9 * i; k < 9 * i + 9; ++k) {
          if (i % 6 == 0) pose[k] += 0.4F * unit(random);
          if (i % 6 == 2) pose[k] = std::nextafter(pose[k], unit(random));
        }
      if (i % 6 == 4)
        for (std::size_t k = 0; k < 9; ++k) poses[1][9 * i + k] = poses[1][9 * i + k % 3];
    }
  }

  /// The corners at a time, by the operations of the kernels (kernels/surface/motion.h).
  [[nodiscard]] fixtures::Soup at(float time) const {
    const float passed = time * float(kSteps);
    const std::uint32_t step = std::min(std::uint32_t(passed), kSteps - 1);
    const float share = passed - float(step);
    fixtures::Soup soup = poses[0];
    for (std::size_t k = 0; k < soup.size(); ++k) {
      const float a = poses[step][k], b = poses[step + 1][k];
      if (moves[k / 9]) soup[k] = std::clamp(a + (b - a) * share, std::min(a, b), std::max(a, b));
    }
    return soup;
  }

  /// The room over time, or where it stands at one time, with the same bounds.
  [[nodiscard]] PackedScene packed(std::optional<float> time) const {
    PackedScene scene;
    const std::size_t count = poses[0].size() / 9;
    scene.triangles.resize(count);
    for (const fixtures::Soup& pose : poses)
      for (std::size_t k = 0; k < pose.size(); k += 3) {
        const glm::dvec3 p(pose[k], pose[k + 1], pose[k + 2]);
        scene.bounds.lo = glm::min(scene.bounds.lo, p);
        scene.bounds.hi = glm::max(scene.bounds.hi, p);
      }
    const fixtures::Soup now = at(time.value_or(0));
    for (std::size_t i = 0; i < count; ++i) std::copy_n(&now[9 * i], 9, &scene.triangles[i].p0_x);
    if (time) return scene;
    scene.pose_steps = kSteps;
    std::vector<std::uint32_t> first_records(count, 0);
    for (std::size_t i = 0; i < count; ++i) {
      if (!moves[i]) continue;
      first_records[i] = std::uint32_t(1 + scene.pose_triangles.size());
      for (const fixtures::Soup& pose : poses) {
        Triangle t{};
        std::copy_n(&pose[9 * i], 9, &t.p0_x);
        scene.pose_triangles.push_back(t);
      }
    }
    scene.motion = motion_table(kSteps, first_records);
    if (scene.pose_triangles.empty()) scene.pose_triangles.resize(kSteps + 1);  // as pack_motion leaves it
    return scene;
  }
};

/// Some of them leave a triangle, go to one, or end before long; closest hits have no end.
std::vector<ProbeRay> rays_of(std::size_t count, std::optional<float> time, unsigned seed = 4) {
  const std::size_t triangles = fixtures::room().size() / 9;
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::vector<ProbeRay> rays(count);
  for (ProbeRay& ray : rays) {
    for (float& x : ray.o) x = 5.0F * unit(random);
    for (float& x : ray.d) x = unit(random);
    if (random() % 4 == 0) ray.left = std::uint32_t(random() % triangles);
    if (random() % 4 == 0) ray.goal = std::uint32_t(random() % triangles);
    if (random() % 4 == 0) ray.t_max = 2.0F + unit(random);
    ray.time = time.value_or(std::min(0.5F * unit(random) + 0.5F, 0x1.fffffep-1F));
  }
  return rays;
}

struct Probes {
  Scene scene;
  Settings settings;
  PackedScene packed;
  std::optional<Features> features;

  explicit Probes(std::optional<float> time, std::size_t every = 2) : packed(MovingRoom(every).packed(time)) {
    scene.moves_surfaces = !time;
    settings.width = settings.height = 1;
    features.emplace(scene, settings);
  }
  TraverseProbe probe(const TraverseProbe::Options& options) {
    return {*test::devices().front(), packed, *features, settings, options};
  }
  TraverseProbe brute_force() {
    TraverseProbe::Options options{"none", 16};
    options.method = "none";
    return probe(options);
  }
};

void expect_same(const std::vector<ProbeHit>& hits, const std::vector<ProbeHit>& expected, const std::string& what) {
  std::size_t differ = 0, hit_count = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    differ += std::memcmp(&hits[i], &expected[i], sizeof(ProbeHit)) != 0 ? 1 : 0;
    hit_count += hits[i].triangle != EK_NO_HIT ? 1 : 0;
  }
  EXPECT_EQ(differ, 0U) << what;
  EXPECT_GT(hit_count, hits.size() / 10) << what;
}

TEST(TraverseMotion, trees_over_time_find_the_hits_of_brute_force) {
  Probes over_time(std::nullopt);
  const char* const asked = std::getenv("EIKON_TEST_ROUNDS");
  const unsigned rounds = asked == nullptr ? 1 : unsigned(std::stoul(asked));
  const auto rays = [](unsigned round) { return rays_of(100'000, std::nullopt, 4 + round); };
  TraverseProbe brute = over_time.brute_force();
  std::vector<decltype(brute.closest(rays(0)))> expected;
  std::vector<decltype(brute.any(rays(0)))> met;
  for (unsigned round = 0; round < rounds; ++round) {
    expected.push_back(brute.closest(rays(round)));
    met.push_back(brute.any(rays(round)));
  }
  for (const TraverseProbe::Options& variant : TraverseProbe::variants()) {
    if (variant.method == "none") continue;  // below
    TraverseProbe tree = over_time.probe(variant);
    for (unsigned round = 0; round < rounds; ++round) {
      expect_same(tree.closest(rays(round)), expected[round], TraverseProbe::describe(variant));
      EXPECT_EQ(tree.any(rays(round)), met[round]) << TraverseProbe::describe(variant);
    }
  }
}

TEST(TraverseMotion, brute_force_finds_the_same_hits_for_one_ray_and_for_many_at_a_time) {
  Probes over_time(std::nullopt);
  const std::vector<ProbeRay> rays = rays_of(2000, std::nullopt);
  TraverseProbe many = over_time.brute_force();
  TraverseProbe::Options options{"none", 1};
  options.method = "none";
  TraverseProbe one = over_time.probe(options);
  expect_same(one.closest(rays), many.closest(rays), "one at a time");
  EXPECT_EQ(one.any(rays), many.any(rays));
}

TEST(TraverseMotion, a_tree_may_hold_everything_or_nothing) {
  const std::vector<ProbeRay> rays = rays_of(20'000, std::nullopt);
  for (const std::size_t every : {std::size_t{0}, std::size_t{1}}) {
    Probes over_time(std::nullopt, every);
    TraverseProbe brute = over_time.brute_force();
    const auto expected = brute.closest(rays);
    const auto met = brute.any(rays);
    for (const TraverseProbe::Options& variant : {TraverseProbe::Options{"bvh16", 16},
                                                  {"bvh16", 16, false, true},
                                                  {"bvh16", 1},
                                                  {"bvh8", 8},
                                                  {"bvh2", 1},
                                                  {"cwbvh", 16}}) {
      TraverseProbe tree = over_time.probe(variant);
      expect_same(tree.closest(rays), expected, TraverseProbe::describe(variant));
      EXPECT_EQ(tree.any(rays), met) << TraverseProbe::describe(variant);
    }
  }
}

TEST(TraverseMotion, hits_are_those_of_the_triangles_where_they_stand_at_the_ray_s_time) {
  Probes over_time(std::nullopt);
  TraverseProbe tree = over_time.probe({"bvh16", 16});
  for (const float time : {0.0F, 0.1F, 1.0F / 3, 0.5F, 0.9F, 0x1.fffffep-1F}) {
    Probes standing(time);
    const std::vector<ProbeRay> rays = rays_of(20'000, time);
    expect_same(tree.closest(rays), standing.brute_force().closest(rays), std::to_string(time));
  }
}

}  // namespace
}  // namespace eikon
