// SPDX-License-Identifier: Apache-2.0
// M16: which solid a camera stands in.
#include "pack/materials/camera_medium.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace eikon {
namespace {

/// Appends the sphere of `rings` x 2 rings facets around `center`, its front to the outside;
/// without the facets `left_out` is true for.
template <class LeftOut>
void add_sphere(PackedScene& packed, std::uint32_t material, const glm::dvec3& center, double radius, int rings,
                LeftOut left_out) {
  const auto point = [&](int i, int j) {
    const double polar = M_PI * i / rings, around = M_PI * j / rings;
    return center + radius * glm::dvec3(std::sin(polar) * std::cos(around), std::cos(polar),
                                        -std::sin(polar) * std::sin(around));
  };
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < 2 * rings; ++j) {
      if (left_out(i, j)) continue;
      const glm::dvec3 corners[] = {point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)};
      for (const auto& [b, c] : {std::pair{1, 2}, std::pair{2, 3}}) {
        Triangle t{};
        t.p0_x = float(corners[0].x), t.p0_y = float(corners[0].y), t.p0_z = float(corners[0].z);
        t.p1_x = float(corners[b].x), t.p1_y = float(corners[b].y), t.p1_z = float(corners[b].z);
        t.p2_x = float(corners[c].x), t.p2_y = float(corners[c].y), t.p2_z = float(corners[c].z);
        t.material = material;
        packed.triangles.push_back(t);
      }
    }
}

const auto kWhole = [](int, int) { return false; };

PackedScene with_solids(std::size_t materials) {
  PackedScene packed;
  packed.materials.resize(materials);
  packed.material_extensions.resize(materials);
  for (MaterialRecord& m : packed.materials) m.flags = EK_MATERIAL_SOLID;
  packed.material_extensions[0].absorption_r = -1;
  return packed;
}

glm::dvec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

TEST(CameraMedium, is_the_solid_around_the_eye_whatever_it_looks_at) {
  PackedScene packed = with_solids(2);
  add_sphere(packed, 1, {10, 0, 0}, 2, 16, kWhole);
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 along = random_direction(random), view = random_direction(random);
    EXPECT_EQ(camera_medium(packed, glm::dvec3(10, 0, 0) + 1.9 * along, view), 2U);
    EXPECT_EQ(camera_medium(packed, glm::dvec3(10, 0, 0) + 2.01 * along, view), 0U);
  }
}

TEST(CameraMedium, rays_through_edges_and_corners_do_not_matter) {
  PackedScene packed = with_solids(1);
  add_sphere(packed, 0, {0, 0, 0}, 1, 8, kWhole);
  for (const glm::dvec3& view : {glm::dvec3(0, 1, 0), glm::dvec3(0, -1, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1)}) {
    EXPECT_EQ(camera_medium(packed, {0, 0, 0}, view), 1U);
    EXPECT_EQ(camera_medium(packed, -3.0 * view, view), 0U);  // the whole of it before the eye
    EXPECT_EQ(camera_medium(packed, 3.0 * view, view), 0U);
  }
}

TEST(CameraMedium, a_solid_with_holes_is_one_still) {
  PackedScene packed = with_solids(1);
  add_sphere(packed, 0, {0, 0, 0}, 1, 16, [](int i, int j) { return (i + j) % 5 == 0; });  // a fifth of it
  EXPECT_EQ(camera_medium(packed, {0.1, 0.2, 0.3}, {0, 0, -1}), 1U);
  EXPECT_EQ(camera_medium(packed, {1.5, 0.2, 0.3}, {0, 0, -1}), 0U);
}

TEST(CameraMedium, the_innermost_of_nested_solids_counts) {
  PackedScene packed = with_solids(3);
  add_sphere(packed, 2, {0, 0, 0}, 1, 8, kWhole);
  add_sphere(packed, 0, {0, 0, 0}, 2, 64, kWhole);
  add_sphere(packed, 1, {0, 0, 0}, 3, 5, kWhole);
  std::mt19937 random(2);
  for (int i = 0; i < 100; ++i) {
    const glm::dvec3 along = random_direction(random), view = random_direction(random);
    EXPECT_EQ(camera_medium(packed, 0.5 * along, view), 3U);
    EXPECT_EQ(camera_medium(packed, 1.5 * along, view), 1U);
    EXPECT_EQ(camera_medium(packed, 2.2 * along, view), 2U);
  }
}

TEST(CameraMedium, a_hollow_is_no_inside) {
  PackedScene packed = with_solids(1);
  add_sphere(packed, 0, {0, 0, 0}, 2, 16, kWhole);
  const std::size_t outer = packed.triangles.size();
  add_sphere(packed, 0, {0, 0, 0}, 1, 16, kWhole);
  for (std::size_t i = outer; i < packed.triangles.size(); ++i) {
    Triangle& t = packed.triangles[i];
    std::swap(t.p1_x, t.p2_x), std::swap(t.p1_y, t.p2_y), std::swap(t.p1_z, t.p2_z);
  }
  EXPECT_EQ(camera_medium(packed, {0.5, 0, 0}, {0, 0, -1}), 0U);
  EXPECT_EQ(camera_medium(packed, {1.5, 0, 0}, {0, 0, -1}), 1U);
}

TEST(CameraMedium, nothing_is_asked_where_nothing_absorbs_or_nothing_is_solid) {
  PackedScene packed = with_solids(1);
  add_sphere(packed, 0, {0, 0, 0}, 1, 8, kWhole);
  packed.material_extensions[0].absorption_r = 0;
  EXPECT_EQ(camera_medium(packed, {0, 0, 0}, {0, 0, -1}), 0U);
  packed.material_extensions[0].absorption_g = -1;
  EXPECT_EQ(camera_medium(packed, {0, 0, 0}, {0, 0, -1}), 1U);
  packed.materials[0].flags = 0;
  EXPECT_EQ(camera_medium(packed, {0, 0, 0}, {0, 0, -1}), 0U);
}

TEST(CameraMedium, lights_are_in_a_solid_whether_it_absorbs_or_not) {
  PackedScene packed = with_solids(1);
  add_sphere(packed, 0, {0, 0, 0}, 1, 8, kWhole);
  packed.material_extensions[0].absorption_r = 0;
  EXPECT_EQ(solid_around(packed, {0.3, 0.2, 0.1}, {0, 0, -1}), 1U);
  EXPECT_EQ(solid_around(packed, {1.3, 0.2, 0.1}, {0, 0, -1}), 0U);
  EXPECT_EQ(camera_medium(packed, {0.3, 0.2, 0.1}, {0, 0, -1}), 0U);
}

TEST(CameraMedium, of_solids_with_ranks_all_that_hold_the_eye_are_listed_each_as_often_as_it_does) {
  PackedScene packed = with_solids(4);
  packed.material_extensions[0].absorption_r = 0;  // it matters even if nothing absorbs
  const std::uint32_t ranks[] = {3, 1, 0, 2};      // the third is no solid
  packed.materials[2].flags = 0;
  for (std::uint32_t m = 0; m < 4; ++m) {
    packed.material_extensions[m].medium_rank = ranks[m];
    if (ranks[m] != 0) packed.material_extensions[ranks[m] - 1].medium_of_rank = m;
  }
  add_sphere(packed, 0, {0, 0, 0}, 2, 16, kWhole);
  add_sphere(packed, 3, {1.5, 0, 0}, 1, 16, kWhole);
  add_sphere(packed, 3, {1.5, 0.3, 0}, 1, 16, kWhole);
  add_sphere(packed, 2, {1.5, 0, 0}, 1, 16, kWhole);
  const auto media = [&](double x) { return camera_medium(packed, {x, 0.1, 0.05}, {0, 0, -1}); };
  EXPECT_EQ(media(-3), 0U);
  EXPECT_EQ(media(-1), 0x03000000U);
  EXPECT_EQ(media(1.5), 0x03020200U);
  EXPECT_EQ(media(2.2), 0x02020000U);
  add_sphere(packed, 1, {1.5, 0, 0}, 1, 16, kWhole);
  EXPECT_EQ(media(1.5), 0x03020201U);
  add_sphere(packed, 0, {1.5, 0, 0}, 1, 16, kWhole);
  EXPECT_EQ(media(1.5), 0x03030202U);  // the lowest of five is left out
}

TEST(CameraMedium, is_the_same_at_every_scale_and_on_a_corner) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    PackedScene packed = with_solids(1);
    add_sphere(packed, 0, {0, 0, 0}, scale, 8, kWhole);
    EXPECT_EQ(camera_medium(packed, {0.5 * scale, 0, 0}, {0, 0, -1}), 1U);
    EXPECT_LE(camera_medium(packed, {0, double(float(scale)), 0}, {0, 0, -1}), 1U);  // on it: either will do
  }
}

}  // namespace
}  // namespace eikon
