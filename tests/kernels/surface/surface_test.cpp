// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "kernels/probe.h"
#include "kernels/statistics.h"
#include "shared/records.h"
#include "support/random.h"

namespace eikon::test {
namespace {

using Exact = glm::vec<3, long double>;  // exact enough to judge float results

Exact exact(const std::vector<Words>& out, std::size_t k, std::size_t i) {
  return {as_float(out[k][i]), as_float(out[k + 1][i]), as_float(out[k + 2][i])};
}
Exact corner(const Triangle& t, int k) {
  if (k == 0) return {t.p0_x, t.p0_y, t.p0_z};
  if (k == 1) return {t.p1_x, t.p1_y, t.p1_z};
  return {t.p2_x, t.p2_y, t.p2_z};
}
Exact exact_normal(const Triangle& t) { return glm::cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0)); }

/// With an area: rounding makes some far from the origin degenerate, which the reader of files
/// leaves out.
template <class Coordinate>
Triangle random_triangle(std::mt19937& random, Coordinate coordinate) {
  Triangle t{};
  do {
    for (float* x : {&t.p0_x, &t.p0_y, &t.p0_z, &t.p1_x, &t.p1_y, &t.p1_z, &t.p2_x, &t.p2_y, &t.p2_z})
      *x = coordinate(random);
  } while (glm::length(exact_normal(t)) == 0);
  return t;
}

float any_magnitude(std::mt19937& random) {  // 10^-8 to 10^8, either sign
  const double magnitude = std::pow(10.0, 16.0 * double(uniform(random)) - 8.0);
  return float((random() & 1U) != 0 ? magnitude : -magnitude);
}

/// w: where a ray leaves to; it came along -w turned, from as far away as the coordinates are
/// large, or from very near.
struct PointsHit {
  Words triangle, u, v, wx, wy, wz, from_x, from_y, from_z;
  void add(std::uint32_t index, float b1, float b2, const glm::vec3& w) {
    const float near = u.size() % 8 == 0 ? 0x1p-22F : 1;
    from_x.push_back(as_word(-near * w[1]));
    from_y.push_back(as_word(-near * w[2]));
    from_z.push_back(as_word(-near * w[0]));
    triangle.push_back(index);
    u.push_back(as_word(b1));
    v.push_back(as_word(b2));
    wx.push_back(as_word(w[0]));
    wy.push_back(as_word(w[1]));
    wz.push_back(as_word(w[2]));
  }
};

Triangle with_normal(Triangle t) {
  const Exact n = exact_normal(t);
  const long double norm = glm::length(n);
  t.n_x = float(n[0] / norm);
  t.n_y = float(n[1] / norm);
  t.n_z = float(n[2] / norm);
  return t;
}

/// Outputs of probe_surface: 0 p, 3 p_error, 6 n_geom, 9 ray origin, 12 material, 13 light_pdf_m2,
/// 14 node.
std::vector<Words> surfaces(std::vector<Triangle> triangles, const PointsHit& hits) {
  for (Triangle& t : triangles) t = with_normal(t);
  return Probe("surface")
      .buffer("triangles", triangles)
      .run("probe_surface",
           {hits.triangle, hits.u, hits.v, hits.wx, hits.wy, hits.wz, hits.from_x, hits.from_y, hits.from_z}, 15);
}

PointsHit random_hits(std::mt19937& random, std::uint32_t triangles, int each) {
  PointsHit hits;
  for (std::uint32_t t = 0; t < triangles; ++t)
    for (int i = 0; i < each; ++i) {
      float u = uniform(random), v = uniform(random);
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      if (i % 16 == 0) v = 1 - u;  // on the edge that the third weight vanishes on, where it is all rounding
      if (i % 64 == 1) u = 0;
      hits.add(t, u, v, glm::vec3(random_direction(random)));
    }
  return hits;
}

struct Cloud {
  const char* name;
  std::vector<Triangle> triangles;
};

std::vector<Cloud> clouds(std::mt19937& random) {
  std::vector<Cloud> all{
      {"coordinates of any magnitude", {}}, {"unit size", {}}, {"far from the origin", {}}, {"needles", {}}};
  for (int i = 0; i < 1000; ++i) {
    all[0].triangles.push_back(random_triangle(random, any_magnitude));
    all[1].triangles.push_back(random_triangle(random, [](std::mt19937& r) { return 2 * uniform(r) - 1; }));
    all[2].triangles.push_back(random_triangle(random, [](std::mt19937& r) { return 1e6F + uniform(r); }));
    Triangle needle = random_triangle(random, [](std::mt19937& r) { return 2 * uniform(r) - 1; });
    needle.p2_x = needle.p0_x + 0.5F * (needle.p1_x - needle.p0_x) + 1e-4F * (uniform(random) - 0.5F);
    needle.p2_y = needle.p0_y + 0.5F * (needle.p1_y - needle.p0_y) + 1e-4F * (uniform(random) - 0.5F);
    needle.p2_z = needle.p0_z + 0.5F * (needle.p1_z - needle.p0_z) + 1e-4F * (uniform(random) - 0.5F);
    all[3].triangles.push_back(needle);
  }
  return all;
}

/// The weights that a hit's point is made of: 2^-20 at least, by the kernels' own operations.
std::pair<float, float> weights_off_the_edges(float u, float v) {
  const float least = 0x1p-20F;
  u = std::max(u, least);
  v = std::max(v, least);
  const float excess = std::max((u + v) - (1.0F - least), 0.0F);
  return u > v ? std::pair{u - excess, v} : std::pair{u, v - excess};
}

TEST(Surface, the_error_of_a_point_is_within_its_bound) {
  std::mt19937 random(1);
  for (const Cloud& cloud : clouds(random)) {
    const PointsHit hits = random_hits(random, 1000, 128);
    const auto out = surfaces(cloud.triangles, hits);
    std::size_t outside = 0;
    for (std::size_t i = 0; i < hits.u.size(); ++i) {
      const Triangle& t = cloud.triangles[hits.triangle[i]];
      const auto [near_u, near_v] = weights_off_the_edges(as_float(hits.u[i]), as_float(hits.v[i]));
      const long double u = near_u, v = near_v;
      ASSERT_GE(1 - u - v, 0x1p-21);
      const Exact p = exact(out, 0, i), bound = exact(out, 3, i);
      for (int axis = 0; axis < 3; ++axis) {
        const long double exact = (1 - u - v) * corner(t, 0)[axis] + u * corner(t, 1)[axis] + v * corner(t, 2)[axis];
        outside += std::abs(p[axis] - exact) > bound[axis] ? 1 : 0;
      }
    }
    EXPECT_EQ(outside, 0U) << cloud.name;
  }
}

TEST(Surface, points_are_moved_back_by_twice_their_error_or_half_of_the_way) {
  std::mt19937 random(6);
  const Cloud cloud = clouds(random)[1];
  const PointsHit hits = random_hits(random, 1000, 64);
  PointsHit from_nowhere = hits;
  for (Words* words : {&from_nowhere.from_x, &from_nowhere.from_y, &from_nowhere.from_z})
    std::fill(words->begin(), words->end(), as_word(0));
  const auto out = surfaces(cloud.triangles, hits), unmoved = surfaces(cloud.triangles, from_nowhere);
  for (std::size_t i = 0; i < hits.u.size(); ++i) {
    const Exact p = exact(out, 0, i), p0 = exact(unmoved, 0, i), bound = exact(out, 3, i);
    const Exact travelled{as_float(hits.from_x[i]), as_float(hits.from_y[i]), as_float(hits.from_z[i])};
    for (int axis = 0; axis < 3; ++axis) {
      const long double error = bound[axis] / 3.25L, back = std::min(2 * error, std::abs(travelled[axis]) / 2);
      const long double moved = std::copysign(1.0L, travelled[axis]) * (p0[axis] - p[axis]);
      ASSERT_NEAR(double(moved), double(back), double(0x1p-24L * std::abs(p0[axis]) + 0x1p-20L * back)) << i;
    }
  }
}

TEST(Surface, G3_rays_leave_on_the_side_that_they_go_to) {
  std::mt19937 random(2);
  for (const Cloud& cloud : clouds(random)) {
    const PointsHit hits = random_hits(random, 1000, 1000);
    const auto out = surfaces(cloud.triangles, hits);
    std::size_t wrong = 0, example = 0;
    for (std::size_t i = 0; i < hits.u.size(); ++i) {
      const Triangle& t = cloud.triangles[hits.triangle[i]];
      const Exact w{as_float(hits.wx[i]), as_float(hits.wy[i]), as_float(hits.wz[i])};
      const Exact n = exact_normal(t);
      const long double going = glm::dot(n, w), side = glm::dot(n, exact(out, 9, i) - corner(t, 0));
      if (std::abs(going) < 1e-5L * glm::length(n)) continue;  // along the surface: either side will do
      if ((going > 0) != (side > 0) && wrong++ == 0) example = i;
    }
    EXPECT_EQ(wrong, 0U) << cloud.name << ", first: ray " << example;
  }
}

TEST(Surface, ray_origins_stay_within_a_few_float_steps_of_the_surface) {
  std::mt19937 random(3);
  const Cloud cloud = clouds(random)[1];
  const PointsHit hits = random_hits(random, 1000, 64);
  const auto out = surfaces(cloud.triangles, hits);
  for (std::size_t i = 0; i < hits.u.size(); ++i)
    ASSERT_LT(glm::length(exact(out, 9, i) - exact(out, 0, i)), 64 * 0x1p-24L) << i;  // coordinates are within 1
}

TEST(Surface, G9_points_errors_and_ray_origins_scale_exactly_by_powers_of_two) {
  std::mt19937 random(5);
  const auto unit = clouds(random)[1].triangles;
  const PointsHit hits = random_hits(random, 1000, 16);
  const auto reference = surfaces(unit, hits);
  for (const int k : {-40, -20, -1, 1, 20, 40}) {
    auto scaled = unit;
    for (Triangle& t : scaled)
      for (float* x : {&t.p0_x, &t.p0_y, &t.p0_z, &t.p1_x, &t.p1_y, &t.p1_z, &t.p2_x, &t.p2_y, &t.p2_z})
        *x = std::ldexp(*x, k);
    PointsHit scaled_hits = hits;
    for (Words* words : {&scaled_hits.from_x, &scaled_hits.from_y, &scaled_hits.from_z})
      for (std::uint32_t& word : *words) word = as_word(std::ldexp(as_float(word), k));
    const auto out = surfaces(scaled, scaled_hits);
    for (std::size_t output = 0; output < 12; ++output) {
      const bool is_length = output < 6 || output >= 9;
      for (std::size_t i = 0; i < hits.u.size(); ++i)
        ASSERT_EQ(as_float(out[output][i]), std::ldexp(as_float(reference[output][i]), is_length ? k : 0))
            << "scale 2^" << k << ", output " << output << ", hit " << i;
    }
  }
}

TEST(Surface, records_keep_what_is_not_geometry) {
  Triangle t = {};
  t.p1_x = t.p2_y = 1;
  t.material = 0x80000001U;
  t.light_pdf_m2 = 0.75F;
  t.node = 0x7fc00000U;  // the bits of a NaN
  PointsHit hits;
  hits.add(0, 0.25F, 0.25F, {0, 0, 1});
  const auto out = surfaces({t}, hits);
  EXPECT_EQ(out[12][0], t.material);
  EXPECT_EQ(as_float(out[13][0]), t.light_pdf_m2);
  EXPECT_EQ(out[14][0], t.node);
}

TEST(Surface, next_float_steps_as_nextafter_does_and_leaves_zero_alone) {
  std::mt19937 random(6);
  Words x, step;
  for (int i = 0; i < 1 << 14; ++i) {
    x.push_back(as_word(any_magnitude(random)));
    step.push_back(as_word(any_magnitude(random)));
  }
  for (const float special : {1.0F, -1.0F, 2.0F, -2.0F, 0x1p20F})
    for (const float s : {1.0F, -1.0F}) {
      x.push_back(as_word(special));
      step.push_back(as_word(s));
    }
  const Words out = Probe("surface").run("probe_next_float", {x, step}, 1)[0];
  for (std::size_t i = 0; i < x.size(); ++i)
    ASSERT_EQ(as_float(out[i]), std::nextafter(as_float(x[i]), std::copysign(INFINITY, as_float(step[i])))) << i;
  const Words still = as_words({0.0F, -0.0F, 0.0F, 5.0F, 0x1p-126F});
  EXPECT_EQ(Probe("surface").run("probe_next_float", {still, as_words({1, 1, -1, 0, -1})}, 1)[0], still);
}

TEST(Surface, bases_are_orthonormal_and_right_handed_also_at_the_poles) {
  std::mt19937 random(7);
  std::vector<glm::vec3> normals{{0, 0, 1},
                                 {0, 0, -1},
                                 {1, 0, 0},
                                 {-1, 0, 0},
                                 {0, 1, 0},
                                 {0, -1, 0},
                                 {1, 0, -0.0F},
                                 {6e-4F, 0, -0.99999982F},
                                 {0, 6e-4F, 0.99999982F}};
  for (int i = 0; i < 1 << 15; ++i) normals.push_back(glm::vec3(random_direction(random)));
  std::vector<Words> in(6);
  for (const glm::vec3& n : normals) {
    const glm::vec3 a(random_direction(random));
    append(in, 0, n);
    append(in, 3, a);
  }
  const auto out = Probe("surface").run("probe_basis", in, 15);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const Exact x = exact(out, 0, i), y = exact(out, 3, i), z = exact(out, 6, i), a = exact(in, 3, i);
    ASSERT_EQ(glm::vec3(vector_at(out, 6, i)), normals[i]);
    ASSERT_NEAR(double(glm::dot(x, y)), 0, 5e-7) << i;
    ASSERT_NEAR(double(glm::dot(x, z)), 0, 5e-7) << i;
    ASSERT_NEAR(double(glm::dot(y, z)), 0, 5e-7) << i;
    ASSERT_NEAR(double(glm::length(x)), 1, 5e-7) << i;
    ASSERT_NEAR(double(glm::length(y)), 1, 5e-7) << i;
    ASSERT_NEAR(double(glm::dot(glm::cross(x, y), z)), 1, 1e-6) << i;
    const Exact local = exact(out, 9, i), world = exact(out, 12, i);
    for (int k = 0; k < 3; ++k) {
      const Exact axis[] = {x, y, z};
      ASSERT_NEAR(double(local[k]), double(glm::dot(axis[k], a)), 3e-7) << i;
      ASSERT_NEAR(double(world[k]), double(a[0] * x[k] + a[1] * y[k] + a[2] * z[k]), 3e-7) << i;
    }
  }
}

}  // namespace
}  // namespace eikon::test
