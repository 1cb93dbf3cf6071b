// SPDX-License-Identifier: Apache-2.0
// Rays against shapes: the hits of double precision within what floats can know.
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/shapes/shape_cloud.h"
#include "kernels/shapes/shape_oracle.h"

namespace eikon {
namespace {

struct Crossing {
  double least = 0, t = INFINITY;
};
Crossing cross(const Oracle& oracle, const glm::dvec3& o, const glm::dvec3& d) {
  const auto height = [&](double t) { return oracle.height(o + t * d); };
  const auto bisect = [&](double a, double b) {  // height(a) and height(b) differ in sign
    const bool outside = height(a) > 0;
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (a + b);
      ((height(middle) > 0) == outside ? a : b) = middle;
    }
    return 0.5 * (a + b);
  };
  double lo = 0, hi = 4 * (glm::length(o) + 4) / glm::length(d);
  const double end = hi;
  for (int i = 0; i < 300; ++i) {
    const double a = lo + (hi - lo) / 3, b = hi - (hi - lo) / 3;
    (height(a) < height(b) ? hi : lo) = height(a) < height(b) ? b : a;
  }
  const double nearest = 0.5 * (lo + hi);
  Crossing crossing{height(nearest)};
  if (height(0) <= 0)
    crossing.t = bisect(0, end);
  else if (crossing.least <= 0)
    crossing.t = bisect(0, nearest);
  return crossing;
}

TEST(ShapeHits, hits_are_those_of_double_precision) {
  Device& device = *test::devices().front();
  for (const ShapeKindInfo& kind : shape_kinds()) {
    if (kind.kind == ShapeKind::plane) continue;  // has no inside
    for (const double size : {1e-6, 1.0, 1e8}) {
      for (const double stretch : {0.0, 1.5, 5.0}) {
        test::Random random(7);
        Scene scene;
        scene.materials.emplace_back();
        scene.shapes.push_back(shape_of(kind.kind, size * glm::dvec3(0.3, -0.7, 2), size, stretch, random));
        const Packed packed(scene);
        const Oracle oracle(packed.scene.shapes[0]);
        const std::vector<ProbeRay> rays = rays_at(scene, 3000, size, 8);
        TraverseProbe probe(device, packed.scene, packed.features, packed.settings, {"bvh8", 8});
        const std::vector<ProbeHit> hits = probe.closest(rays);
        std::size_t certain = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
          const glm::dvec3 o(rays[i].o[0], rays[i].o[1], rays[i].o[2]), d(rays[i].d[0], rays[i].d[1], rays[i].d[2]);
          const glm::dvec3 from = o - oracle.center;
          const Crossing exact = cross(oracle, oracle.l * from, oracle.l * d);
          // What float products with the matrix can know of heights: some units of the largest sum
          // they make.
          glm::dvec3 sums(0.0);
          for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column) sums[row] += std::abs(oracle.l[column][row] * from[column]);
          const double known = 0x1p-20 * (1 + glm::length(sums));
          const bool hit = hits[i].triangle != EK_NO_HIT;
          const double begins = oracle.height(oracle.l * from);
          if (std::abs(exact.least) > known && std::abs(begins) > known) {
            ASSERT_EQ(hit, std::isfinite(exact.t))
                << kind.name << " size " << size << " stretch " << stretch << " ray " << i << " least " << exact.least;
            ++certain;
          }
          if (!hit) continue;
          const double height = oracle.height(oracle.l * (from + double(hits[i].t) * d));
          ASSERT_LE(std::abs(height), known) << kind.name << " size " << size << " stretch " << stretch << " ray " << i;
          if (!std::isfinite(exact.t) || exact.least > -64 * known)
            continue;  // grazes: the place is as uncertain as the root of that
          const double slope = std::abs(oracle.height(oracle.l * (from + 1.0001 * exact.t * d)) -
                                        oracle.height(oracle.l * (from + 0.9999 * exact.t * d)));
          ASSERT_LE(std::abs(double(hits[i].t) - exact.t) * slope, 2e-4 * exact.t * 16 * known + 1e-3 * slope * exact.t)
              << kind.name << " size " << size << " stretch " << stretch << " ray " << i;
        }
        EXPECT_GT(certain, rays.size() / 2);
      }
    }
  }
}

}  // namespace
}  // namespace eikon
