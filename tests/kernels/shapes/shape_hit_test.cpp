// SPDX-License-Identifier: Apache-2.0
// Rays against shapes: the same hits in every structure to the bit.
#include <gtest/gtest.h>

#include <cstring>

#include "formula/parse.h"
#include "kernels/shapes/shape_cloud.h"
#include "scene/endless.h"

namespace eikon {
namespace {

::testing::AssertionResult same_hits(const std::vector<ProbeHit>& a, const std::vector<ProbeHit>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::memcmp(&a[i], &b[i], sizeof a[i]) != 0)
      return ::testing::AssertionFailure()
             << "ray " << i << ": t " << a[i].t << " id " << a[i].triangle << " part " << a[i].u << " against "
             << b[i].t << ", " << b[i].triangle << ", " << b[i].u;
  return ::testing::AssertionSuccess();
}

void expect_same_hits_everywhere(const Packed& packed, const std::vector<ProbeRay>& rays,
                                 const std::vector<TraverseProbe::Options>& ways) {
  for (const auto& opened : test::devices()) {
    Device& device = *opened;
    TraverseProbe::Options brute{"none", 1};
    brute.method = "none";
    TraverseProbe reference(device, packed.scene, packed.features, packed.settings, brute);
    const std::vector<ProbeHit> expected = reference.closest(rays);
    const std::vector<bool> blocked = reference.any(rays);
    std::size_t hits = 0;
    for (const ProbeHit& hit : expected)
      hits += hit.triangle != EK_NO_HIT && hit.triangle >= packed.scene.triangle_count();
    EXPECT_GT(hits, rays.size() / 10);
    for (const TraverseProbe::Options& options : ways) {
      TraverseProbe probe(device, packed.scene, packed.features, packed.settings, options);
      EXPECT_TRUE(same_hits(probe.closest(rays), expected)) << device.info().name << ": " << TraverseProbe::describe(options);
      EXPECT_EQ(probe.any(rays), blocked) << device.info().name << ": " << TraverseProbe::describe(options);
    }
  }
}

TEST(ShapeHits, every_structure_gives_the_hits_of_brute_force) {
  const Scene scene = cloud(300, 1, 1);
  expect_same_hits_everywhere(Packed(scene), rays_at(scene, 4000, 1, 2), TraverseProbe::variants());
}

/// Formulas beside all kinds of shapes and triangles, overlapping, turned, stretched, some in one
/// place twice; one is given up on most rays.
Scene formulas_among_shapes(bool opacity) {
  Scene scene = cloud(40, 1, 21, opacity);
  for (const char* text : {"x^2+y^2+z^2-1", "(x^2+y^2+z^2+0.3)^2-1.6*(x^2+y^2)",
                           "sin(5*x)*cos(5*y)+sin(5*y)*cos(5*z)+sin(5*z)*cos(5*x)", "x*y-x*y+1e-5"})
    scene.formulas.push_back(formula::parse_formula(text));
  test::Random random(22);
  for (std::uint32_t i = 0; i < 24; ++i) {
    Shape shape;
    shape.kind = ShapeKind::implicit;
    shape.size = {1.1, 1.1, 1.1};
    shape.formula = i == 23 ? 3 : i % 3;
    const auto stretch = [&] { return 0.5 * std::exp2(test::uniform(random, -1.5, 1.5)); };
    shape.world_from_object =
        glm::translate(glm::dmat4(1), test::random_direction(random) * test::uniform(random, 0, 4)) *
        glm::rotate(glm::dmat4(1), test::uniform(random, 0, 6), test::random_direction(random)) *
        glm::scale(glm::dmat4(1), glm::dvec3(stretch(), stretch(), stretch()));
    scene.shapes.push_back(shape);
    if (i % 8 == 7) scene.shapes.push_back(shape);
  }
  return scene;
}

/// With formulas and opacity, whether the scene has them or not: its tests share their programs.
Packed packed_for_all(const Scene& scene) { return {scene, formulas_among_shapes(true)}; }

TEST(ShapeHits, formulas_among_shapes_and_triangles_have_the_hits_of_brute_force_in_every_structure) {
  const Scene scene = formulas_among_shapes(false);
  expect_same_hits_everywhere(packed_for_all(scene), rays_at(scene, 1500, 1, 23), TraverseProbe::each_once());
}

TEST(ShapeHits, planes_without_end_have_the_hits_of_brute_force_in_every_structure) {
  Scene scene = cloud(100, 1, 31);
  test::Random random(32);
  for (const double other : {kEndlessSize, 2.0}) {
    for (int i = 0; i < 3; ++i) {  // level, twice in one place, and askew
      Shape plane;
      plane.kind = ShapeKind::plane;
      plane.size = {kEndlessSize, other, 0};
      plane.world_from_object = glm::translate(glm::dmat4(1), glm::dvec3(0.25, other > 2 ? -1.5 : 1.0, -0.5));
      if (i == 2)
        plane.world_from_object = plane.world_from_object * glm::rotate(glm::dmat4(1), test::uniform(random, 0, 6),
                                                                        test::random_direction(random));
      scene.shapes.push_back(plane);
    }
  }
  const Scene planes_and_others = scene;
  expect_same_hits_everywhere(Packed(scene), rays_at(scene, 1500, 1, 33), TraverseProbe::each_once());
  scene.meshes.clear();  // and nothing else, by the same programs
  scene.nodes.clear();
  scene.shapes.erase(scene.shapes.begin(), scene.shapes.end() - 6);
  expect_same_hits_everywhere({scene, planes_and_others}, rays_at(scene, 500, 1, 34), TraverseProbe::each_once());
}

TEST(ShapeHits, tiny_and_huge_scenes_have_the_hits_of_brute_force) {
  for (const double size : {1e-6, 1e8}) {
    const Scene scene = cloud(60, size, 3);
    expect_same_hits_everywhere(Packed(scene), rays_at(scene, 500, size, 4), TraverseProbe::variants());
  }
}

TEST(ShapeHits, rays_pass_shapes_in_the_same_places_everywhere) {
  const Scene scene = cloud(150, 1, 5, true);
  expect_same_hits_everywhere(packed_for_all(scene), rays_at(scene, 2000, 1, 6), TraverseProbe::each_once());
}

}  // namespace
}  // namespace eikon
