// SPDX-License-Identifier: Apache-2.0
// The watertight test of triangles beside itself in double precision, Moller-Trumbore, and plane
// with three cross products: where they agree, and why not elsewhere.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <random>

#include "support/accel_fixtures.h"
#include "kernels/traverse/traverse_probe.h"

namespace eikon {
namespace {

using Vector = glm::dvec3;
using fixtures::Soup;

struct OracleHit {
  bool hit = false;
  double t = 0, u = 0, v = 0;
};
struct Case {
  Vector o{}, d{}, a{}, b{}, c{};
};

/// [Woop, Benthin, Wald 2013], without culling.
OracleHit watertight(const Case& k) {
  int z = 0;
  for (int i = 1; i < 3; ++i) z = std::abs(k.d[i]) > std::abs(k.d[z]) ? i : z;
  const int x = (z + 1) % 3, y = (z + 2) % 3;
  const double sx = k.d[x] / k.d[z], sy = k.d[y] / k.d[z], sz = 1 / k.d[z];
  const auto sheared = [&](const Vector& p) {
    const Vector r = p - k.o;
    return Vector{r[x] - sx * r[z], r[y] - sy * r[z], sz * r[z]};
  };
  const Vector a = sheared(k.a), b = sheared(k.b), c = sheared(k.c);
  const double u = c[0] * b[1] - c[1] * b[0], v = a[0] * c[1] - a[1] * c[0], w = b[0] * a[1] - b[1] * a[0];
  const double det = u + v + w;
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return {};
  if (det == 0) return {};
  const double t = (u * a[2] + v * b[2] + w * c[2]) / det;
  return {t > 0, t, v / det, w / det};
}

/// [Moller, Trumbore 1997]
OracleHit moller_trumbore(const Case& k) {
  const Vector ab = k.b - k.a, ac = k.c - k.a, s = glm::cross(k.d, ac), from_a = k.o - k.a;
  const double det = glm::dot(ab, s);
  if (det == 0) return {};
  const double inverse = 1 / det, u = glm::dot(from_a, s) * inverse;
  const Vector q = glm::cross(from_a, ab);
  const double v = glm::dot(k.d, q) * inverse, t = glm::dot(ac, q) * inverse;
  return {u >= 0 && v >= 0 && u + v <= 1 && t > 0, t, u, v};
}

OracleHit plane_and_edges(const Case& k) {
  const Vector n = glm::cross(k.b - k.a, k.c - k.a);
  if (glm::dot(n, k.d) == 0) return {};
  const double t = glm::dot(n, k.a - k.o) / glm::dot(n, k.d);
  const Vector x = k.o + t * k.d;
  const double wc = glm::dot(glm::cross(k.b - k.a, x - k.a), n), wa = glm::dot(glm::cross(k.c - k.b, x - k.b), n);
  const double wb = glm::dot(glm::cross(k.a - k.c, x - k.c), n);
  return {t > 0 && wa >= 0 && wb >= 0 && wc >= 0, t, wb / glm::dot(n, n), wc / glm::dot(n, n)};
}

Case case_of(const ProbeRay& ray, const float* p) {
  Case k;
  for (int i = 0; i < 3; ++i) {
    k.o[i] = double{ray.o[i]}, k.d[i] = double{ray.d[i]};
    k.a[i] = double{p[i]}, k.b[i] = double{p[3 + i]}, k.c[i] = double{p[6 + i]};
  }
  return k;
}

TraverseProbe::Options with_test(int number) {
  TraverseProbe::Options options{"none", 1};
  if (number != 0) options.defines = {{"EK_TRIANGLE_TEST", std::to_string(number)}};
  return options;
}

TEST(TriangleOracles, all_tests_agree_away_from_edges_and_from_edge_on_planes) {
  // Hits well inside must be hits, misses well outside misses, in single and double precision; t, u
  // and v as the condition of the triangle allows: rounding of coordinates of about 1 by 2^-24, a
  // hundred times over, by the sine of ray and plane and the size.
  Device& device = *test::devices().front();
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::size_t hits = 0, misses = 0;
  for (int scene = 0; scene < 40; ++scene) {
    Soup soup;
    for (int k = 0; k < 9; ++k) soup.push_back(unit(random));
    std::vector<ProbeRay> rays(2000);
    for (ProbeRay& ray : rays) {
      for (std::size_t k = 0; k < 3; ++k) {
        ray.o[k] = 2 * unit(random);
        ray.d[k] = (soup[k] + soup[3 + k] + soup[6 + k]) / 3 + 0.7F * unit(random) - ray.o[k];
      }
    }
    std::array<std::vector<ProbeHit>, 3> found;
    for (int test = 0; test < 3; ++test)
      found[static_cast<std::size_t>(test)] = TraverseProbe(device, soup, with_test(test)).closest(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Case k = case_of(rays[i], soup.data());
      const std::array<OracleHit, 3> oracle{watertight(k), moller_trumbore(k), plane_and_edges(k)};
      const Vector n = glm::cross(k.b - k.a, k.c - k.a);
      const double length = std::sqrt(glm::dot(n, n)),
                   sine = std::abs(glm::dot(n, k.d)) / (length * std::sqrt(glm::dot(k.d, k.d)));
      const double bound = 100 * 0x1p-24 * 8 / (length * sine);
      const double least = std::min({oracle[1].u, oracle[1].v, 1 - oracle[1].u - oracle[1].v});
      if (bound > 0.01 || std::abs(least) < bound || std::abs(oracle[1].t) < bound) continue;
      const bool expected = least > 0 && oracle[1].t > 0;
      (expected ? hits : misses)++;
      for (std::size_t test = 0; test < 3; ++test) {
        ASSERT_EQ(oracle[test].hit, expected) << test;
        const ProbeHit& hit = found[test][i];
        ASSERT_EQ(hit.triangle == 0, expected) << test;
        if (!expected) continue;
        EXPECT_NEAR(oracle[test].t, oracle[1].t, 1e-12 / sine);
        EXPECT_NEAR(hit.t, oracle[1].t, bound) << test;
        EXPECT_NEAR(hit.u, oracle[1].u, bound) << test;
        EXPECT_NEAR(hit.v, oracle[1].v, bound) << test;
      }
    }
  }
  EXPECT_GT(hits, 5'000U);
  EXPECT_GT(misses, 5'000U);
}

TEST(TriangleOracles, only_the_watertight_test_never_lets_a_ray_through_a_shared_edge) {
  // Whole numbers, so that the rays pass through a point of the edge exactly. Moller-Trumbore
  // rounds u + v, of which the neighbour knows nothing, and the plane's point is rounded off the
  // edge; both then miss both triangles. Edge functions are the same numbers for both, with signs
  // changed.
  Device& device = *test::devices().front();
  std::mt19937 random(2);
  std::uniform_int_distribution<int> whole(-500, 500);
  std::array<std::size_t, 3> leaks_single{}, leaks_double{};
  std::size_t count = 0;
  for (int scene = 0; scene < 60; ++scene) {
    // Edge from b to c; one triangle on each side of it, so that in both it is where u + v = 1.
    Vector b{}, c{};
    for (int k = 0; k < 3; ++k) b[k] = 8 * whole(random), c[k] = 8 * whole(random);
    Vector a{};
    for (int k = 0; k < 3; ++k) a[k] = 8 * whole(random);
    const Vector d = b + c - a;
    Soup soup;
    for (const Vector& p : {a, b, c, d, c, b})
      for (int k = 0; k < 3; ++k) soup.push_back(static_cast<float>(p[k]));
    std::vector<ProbeRay> rays;
    for (int i = 1; i < 8; ++i) {
      for (int from = 0; from < 20; ++from) {
        ProbeRay ray;
        for (int k = 0; k < 3; ++k) {
          const auto target = static_cast<int>(b[k] + (c[k] - b[k]) * i / 8);
          const int away = whole(random);
          ray.o[k] = static_cast<float>(target - away);
          ray.d[k] = static_cast<float>(away);
        }
        // Rays within a triangle's plane hit neither in all tests alike.
        const Vector n = glm::cross(b - a, c - a), along{double{ray.d[0]}, double{ray.d[1]}, double{ray.d[2]}};
        if (std::abs(glm::dot(n, along)) > 0.05 * std::sqrt(glm::dot(n, n) * glm::dot(along, along)))
          rays.push_back(ray);
      }
    }
    count += rays.size();
    for (std::size_t test = 0; test < 3; ++test) {
      const auto hits = TraverseProbe(device, soup, with_test(static_cast<int>(test))).closest(rays);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        leaks_single[test] += hits[i].triangle == EK_NO_HIT ? 1 : 0;
        const auto oracle = test == 0 ? watertight : test == 1 ? moller_trumbore : plane_and_edges;
        leaks_double[test] += oracle(case_of(rays[i], &soup[0])).hit || oracle(case_of(rays[i], &soup[9])).hit ? 0 : 1;
      }
    }
  }
  EXPECT_GT(count, 5'000U);
  EXPECT_EQ(leaks_single[0], 0U);
  EXPECT_EQ(leaks_double[0], 0U);
  for (const std::size_t test : {1U, 2U}) {
    EXPECT_GT(leaks_single[test], 0U) << test;
    // Both triangles lie in a plane: in double precision they find the same point of it here, and
    // agree about the edge.
    if (test == 1) {
      EXPECT_GT(leaks_double[test], 0U);
    }
    EXPECT_LT(leaks_single[test], count) << test;
  }
}

}  // namespace
}  // namespace eikon
