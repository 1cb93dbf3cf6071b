// SPDX-License-Identifier: Apache-2.0
// Scenes in two levels: the hits of brute force over all instances, to the bit, wherever they are.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>

#include "support/accel_fixtures.h"
#include "kernels/traverse/traverse_probe.h"
#include "pack/geometry/instanced_meshes.h"
#include "support/random.h"

namespace eikon {
namespace {

Primitive primitive_of(const fixtures::Soup& soup) {
  Primitive primitive;
  for (std::size_t i = 0; i < soup.size(); i += 3) {
    primitive.indices.push_back(std::uint32_t(i / 3));
    primitive.positions_object.emplace_back(soup[i], soup[i + 1], soup[i + 2]);
  }
  return primitive;
}

void add_instance(Scene& scene, std::uint32_t mesh, const glm::dmat4& m) {
  Node node;
  node.mesh = mesh;
  node.world_from_object = m;
  node.mirrored = glm::determinant(glm::dmat3(m)) < 0;
  scene.nodes.push_back(node);
}

/// A turned, stretched and perhaps mirrored place near the origin.
glm::dmat4 anywhere(test::Random& random, double reach, double size) {
  const auto stretch = [&] {
    return size * std::exp2(test::uniform(random, -1.5, 1.5)) * (test::uniform(random, 0, 1) < 0.2 ? -1 : 1);
  };
  return glm::translate(glm::dmat4(1), reach * test::uniform(random, 0, 1) * test::random_direction(random)) *
         glm::rotate(glm::dmat4(1), test::uniform(random, 0, 6), test::random_direction(random)) *
         glm::scale(glm::dmat4(1), glm::dvec3(stretch(), stretch(), stretch()));
}

/// Meshes of few and of many triangles with many instances, one of them far from its own origin;
/// meshes with one instance; shapes; and meshes at the same place twice, so that hits tie.
Scene crowd(double size, std::uint32_t seed, bool shapes) {
  test::Random random(seed);
  Scene scene;
  Material material;
  material.metallic = 0;
  material.specular = 0;
  scene.materials.push_back(material);
  const auto add = [&](fixtures::Soup soup) {
    scene.meshes.push_back({"mesh", {primitive_of(soup)}});
    return std::uint32_t(scene.meshes.size() - 1);
  };
  fixtures::Soup far = fixtures::bumpy_sphere(4);
  for (std::size_t i = 0; i < far.size(); i += 3) far[i] += 1000;
  const std::uint32_t ball = add(fixtures::bumpy_sphere(8)), blade = add(fixtures::scattered(3, 1, seed + 1)),
                      heap = add(fixtures::scattered(300, 1, seed + 2)), away = add(far),
                      one = add(fixtures::scattered(40, 4, seed + 3)),
                      quad = add({-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, -1, 1, 0, 1, -1, 0, 1});
  const auto big = glm::scale(glm::dmat4(1), glm::dvec3(size));
  add_instance(scene, one, big);
  for (int i = 0; i < 120; ++i) {
    const std::uint32_t mesh = i % 4 == 0 ? ball : i % 4 == 1 ? heap : blade;
    const glm::dmat4 m = big * anywhere(random, 4, 0.5);
    add_instance(scene, mesh, m);
    if (i % 10 == 9) add_instance(scene, mesh, m);
  }
  for (int i = 0; i < 3; ++i)
    add_instance(scene, away, big * anywhere(random, 2, 0.5) * glm::translate(glm::dmat4(1), glm::dvec3(-1000, 0, 0)));
  // A floor of tiles that share edges and lie in coordinate planes: rays along it see them edge-on.
  for (int i = 0; i < 16; ++i)
    add_instance(scene, quad, big * glm::translate(glm::dmat4(1), glm::dvec3(2 * (i % 4) - 3, -2, 2 * (i / 4) - 3)));
  for (int i = 0; shapes && i < 12; ++i) {
    Shape shape;
    shape.kind = i % 2 == 0 ? ShapeKind::sphere : ShapeKind::box;
    std::size_t at = 0;
    for (const ShapeParameter& parameter : shape_kind(shape.kind).parameters)
      for (std::size_t k = 0; k < parameter.count; ++k) shape.size[at++] = parameter.usual;
    shape.world_from_object = big * anywhere(random, 4, 0.3);
    scene.shapes.push_back(shape);
  }
  return scene;
}

/// From everywhere: at corners and edges of triangles as they stand, within their planes, from far
/// away, and any.
std::vector<ProbeRay> rays_at(const PackedScene& flat, std::size_t count, double size, std::uint32_t seed) {
  test::Random random(seed);
  std::vector<ProbeRay> rays;
  const auto corner = [](const Triangle& t, int k) {
    const float* p = &t.p0_x + 3 * k;
    return glm::dvec3(p[0], p[1], p[2]);
  };
  for (std::size_t i = 0; i < count; ++i) {
    const Triangle& t = flat.triangles[std::size_t(test::uniform(random, 0, double(flat.triangle_count()) - 0.5))];
    const glm::dvec3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
    const double u = test::uniform(random, 0, 1), v = test::uniform(random, 0, 1 - u);
    const glm::dvec3 inside = (1 - u - v) * a + u * b + v * c;
    const double reach = (i % 11 == 10 ? 1e5 : i % 11 == 9 ? 0.01 : 6) * size;
    glm::dvec3 target = inside, origin = inside + reach * test::random_direction(random);
    switch (i % 8) {
      case 0:
        target = a;
        break;
      case 1:
        target = 0.5 * (a + b);
        break;
      case 2:
        origin = inside + reach * glm::normalize(b - a + 1e-30);
        break;  // in its plane
      case 3:
        origin = b, target = c + (c - b);
        break;  // along an edge
      case 4:
        origin = reach * test::random_direction(random), target = origin + test::random_direction(random);
        break;
      case 5:
        origin = target, origin[int(i / 8 % 3)] += reach;
        break;  // along an axis
      case 6:
        origin = inside, target = origin + test::random_direction(random);
        break;
      default:
        break;
    }
    const glm::dvec3 d = (target - origin) / std::max(glm::length(target - origin), 1e-300);
    rays.push_back(probe_ray(origin, d, test::uniform(random, 0, 2) * reach));
  }
  return rays;
}

struct Packed {
  Settings settings{};
  Features features;
  PackedScene scene;
  Packed(const Scene& from, bool two_level) : features(from, settings) {
    features.set_two_level(two_level, "the test");
    scene = pack_in_world(from, features, settings);
  }
  /// The index of each instance's first triangle if the mesh were stored for each.
  [[nodiscard]] ProbeHit flat(ProbeHit hit) const {
    if (hit.triangle == EK_NO_HIT) hit.instance = 0;  // means nothing
    if (scene.instances.empty() || hit.triangle == EK_NO_HIT) return hit;
    const std::size_t stored = scene.stored_meshes.front().first;
    if (hit.triangle >= scene.triangle_count()) {
      hit.triangle += std::uint32_t(scene.instanced_triangle_count() - scene.triangle_count());
    } else if (hit.triangle >= stored) {
      std::size_t first = stored;
      for (std::size_t i = 0; i + 1 < hit.instance; ++i) first += scene.stored_meshes[scene.instances[i].mesh].count;
      hit.triangle += std::uint32_t(first - scene.stored_meshes[scene.instances[hit.instance - 1].mesh].first);
    }
    hit.instance = 0;
    return hit;
  }
};

using Ways = std::vector<TraverseProbe::Options>;

/// One ray alone, many in turn, and packets in large and in small trees; with the builtins of the
/// processor, those of a lesser one and none: of each piece of code that goes down two levels, all
/// that it can be compiled to.
Ways ways_down(const std::string& layout) {
  const auto way = [&](int width, std::map<std::string, std::string> defines, bool portable = false,
                       bool coherent = false) {
    TraverseProbe::Options o{layout, width, portable, coherent};
    o.defines = std::move(defines);
    return o;
  };
  if (layout == "bvh2") return {way(1, {}), way(16, {})};
  if (layout == "bvh8")
    return {way(1, {}), way(8, {{"EK_SMALL_TREE", "0"}}), way(8, {{"EK_SMALL_TREE", "0"}, {"EK_NO_AVX512", "1"}}),
            way(8, {{"EK_SMALL_TREE", "0"}, {"EK_MEDIUM_TREE", "1"}, {"EK_LARGE_TREE", "1"}}, false, true)};
  return {way(1, {}),
          way(16, {{"EK_SMALL_TREE", "0"}}),
          way(16, {{"EK_SMALL_TREE", "0"}, {"EK_MEDIUM_TREE", "1"}, {"EK_LARGE_TREE", "1"}}, false, true),
          way(16, {{"EK_SMALL_TREE", "1"}}),
          way(16, {{"EK_SMALL_TREE", "0"}}, true),
          way(16, {{"EK_SMALL_TREE", "0"}, {"EK_MEDIUM_TREE", "1"}, {"EK_LARGE_TREE", "1"}}, true, true)};
}

/// One of each layout, all different, where it is the scene that matters.
Ways few_ways_down() {
  return {ways_down("bvh2")[0], ways_down("bvh8")[3], ways_down("bvh16")[0], ways_down("bvh16")[1]};
}

void expect_hits_of_brute_force(const Scene& scene, double size, std::size_t count, std::uint32_t seed,
                                const Ways& ways) {
  const Packed flat(scene, false), two_level(scene, true);
  ASSERT_FALSE(two_level.scene.instances.empty());
  EXPECT_EQ(two_level.scene.instanced_triangle_count(), flat.scene.triangle_count());
  EXPECT_EQ(two_level.scene.bounds.lo, flat.scene.bounds.lo);
  EXPECT_EQ(two_level.scene.bounds.hi, flat.scene.bounds.hi);
  const std::vector<ProbeRay> rays = rays_at(flat.scene, count, size, seed);
  for (const auto& opened : test::devices()) {
    Device& device = *opened;
    TraverseProbe::Options brute{"none", 1};
    brute.method = "none";
    TraverseProbe reference(device, flat.scene, flat.features, flat.settings, brute);
    const std::vector<ProbeHit> expected = reference.closest(rays);
    const std::vector<bool> blocked = reference.any(rays);
    std::size_t hits = 0;
    for (const ProbeHit& hit : expected) hits += hit.triangle != EK_NO_HIT;
    EXPECT_GT(hits, rays.size() / 4);
    for (const TraverseProbe::Options& options : ways) {
      ASSERT_TRUE(has_two_levels(options.layout));
      TraverseProbe probe(device, two_level.scene, two_level.features, two_level.settings, options);
      const std::vector<ProbeHit> found = probe.closest(rays);
      const std::string what = device.info().name + ": " + TraverseProbe::describe(options);
      std::size_t wrong = 0, first = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        const ProbeHit hit = two_level.flat(found[i]);
        if (std::memcmp(&hit, &expected[i], sizeof hit) == 0) continue;
        if (wrong++ == 0) first = i;
      }
      EXPECT_EQ(wrong, 0U) << what << ": of " << rays.size() << " rays; ray " << first << ", kind " << first % 8
                           << ": t " << found[first].t << " triangle " << two_level.flat(found[first]).triangle
                           << " against t " << expected[first].t << " triangle " << expected[first].triangle;
      EXPECT_EQ(probe.any(rays), blocked) << what;
    }
  }
}

class TraverseInstances : public testing::TestWithParam<std::string> {};

TEST_P(TraverseInstances, G19_hits_are_those_of_brute_force_over_all_instances) {
  expect_hits_of_brute_force(crowd(1, 1, false), 1, 6000, 2, ways_down(GetParam()));
}

// In the mesh's space a ray without a direction has no number left, and would meet children that
// are missing.
TEST_P(TraverseInstances, rays_that_are_none_hit_nothing_and_end) {
  std::vector<ProbeRay> rays;
  ProbeRay ray;
  ray.d = {0.6F, 0, -0.8F};
  for (const float x : {-3.0F, 0.0F, 2.0F}) {
    ray.o = {x, 0.25F, x};
    const std::vector<ProbeRay> none = rays_that_are_none(ray);
    rays.insert(rays.end(), none.begin(), none.end());
  }
  const Packed two_level(crowd(1, 1, false), true);
  Device& device = *test::devices().front();
  for (const TraverseProbe::Options& options : ways_down(GetParam())) {
    TraverseProbe probe(device, two_level.scene, two_level.features, two_level.settings, options);
    for (const ProbeHit& hit : probe.closest(rays))
      EXPECT_EQ(hit.triangle, EK_NO_HIT) << TraverseProbe::describe(options);
    EXPECT_EQ(probe.any(rays), std::vector<bool>(rays.size(), false)) << TraverseProbe::describe(options);
  }
}

std::string layout_name(const testing::TestParamInfo<std::string>& info) { return info.param; }
INSTANTIATE_TEST_SUITE_P(, TraverseInstances, testing::Values("bvh16", "bvh8", "bvh2"), layout_name);

TEST(TraverseInstanceScenes, instances_beside_shapes_have_the_hits_of_brute_force) {
  expect_hits_of_brute_force(crowd(1, 3, true), 1, 3000, 4, few_ways_down());
}

TEST(TraverseInstanceScenes, tiny_and_huge_scenes_have_the_hits_of_brute_force) {
  for (const double size : {0x1p-17, 0x1p20})
    expect_hits_of_brute_force(crowd(size, 1, false), size, 1000, 6, few_ways_down());
}

TEST(TraverseInstanceScenes, scenes_far_from_the_origin_have_the_hits_of_brute_force) {
  Scene scene = crowd(1, 7, false);
  for (Node& node : scene.nodes)
    node.world_from_object = glm::translate(glm::dmat4(1), glm::dvec3(3e4, -2e4, 1e3)) * node.world_from_object;
  expect_hits_of_brute_force(scene, 1, 1500, 8, few_ways_down());
}

}  // namespace
}  // namespace eikon
