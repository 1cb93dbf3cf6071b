// SPDX-License-Identifier: Apache-2.0
// The numbers that decide whether a ray meets a surface of some opacity: uniform, independent
// between triangles, depths, kinds of rays and pixels, and even over the samples of a pixel.
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "kernels/probe.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

constexpr std::size_t kCount = 1 << 16;
constexpr std::size_t kFamily = 40;  // tests of this file, or more

struct Rays {
  Words key, index, triangle;
};

std::vector<double> numbers(const Rays& rays, std::uint32_t depth = 1, std::uint32_t kind = 0) {
  const Words out = Probe("opacity")
                        .value("depth", depth)
                        .value("kind", kind)
                        .run("probe_opacity_number", {rays.key, rays.index, rays.triangle}, 1)[0];
  std::vector<double> x;
  x.reserve(out.size());
  for (const std::uint32_t word : out) x.push_back(double(as_float(word)));
  return x;
}

/// Rays of as many paths, each at some sample, all about one triangle.
Rays many(std::uint32_t triangle = 5) {
  std::mt19937 random(11);
  Rays rays;
  for (std::size_t i = 0; i < kCount; ++i) {
    rays.key.push_back(std::uint32_t(random()));
    rays.index.push_back(std::uint32_t(random() % 256));
    rays.triangle.push_back(triangle);
  }
  return rays;
}

Rays shifted(Rays rays, std::uint32_t triangles) {
  for (std::uint32_t& t : rays.triangle) t += triangles;
  return rays;
}

void expect_uniform(const std::vector<double>& observed, const std::string& what) {
  double total = 0;
  for (const double x : observed) total += x;
  const ChiSquare result = chi_square(observed, std::vector<double>(observed.size(), total / double(observed.size())));
  EXPECT_GT(result.p_value, sidak(kFamily)) << what << "\n" << result.table;
}

/// Three numbers per path, each in one of eight octaves of [0, 1): all 512 combinations are as
/// likely.
void expect_independent(const std::vector<double>& a, const std::vector<double>& b, const std::vector<double>& c,
                        const std::string& what) {
  std::vector<double> cells(512, 0);
  for (std::size_t i = 0; i < a.size(); ++i)
    ++cells[std::size_t(a[i] * 8) * 64 + std::size_t(b[i] * 8) * 8 + std::size_t(c[i] * 8)];
  expect_uniform(cells, what);
}

TEST(OpacityNumber, is_uniform) {
  for (const std::uint32_t triangle : {0U, 1U, 77777U, (1U << 28) - 1}) {
    std::vector<double> bins(256, 0);
    for (const double x : numbers(many(triangle))) {
      ASSERT_GE(x, 0);
      ASSERT_LT(x, 1);
      ++bins[std::size_t(x * 256)];
    }
    expect_uniform(bins, "triangle " + std::to_string(triangle));
  }
}

TEST(OpacityNumber, of_several_triangles_depths_and_kinds_of_rays_are_independent) {
  const Rays rays = many();
  const std::vector<double> x = numbers(rays);
  expect_independent(x, numbers(shifted(rays, 1)), numbers(shifted(rays, 2)), "triangles 1, 2 on");
  expect_independent(x, numbers(shifted(rays, 1 << 16)), numbers(shifted(rays, 1 << 27)), "triangles far on");
  expect_independent(x, numbers(rays, 2), numbers(rays, 3), "depths");
  expect_independent(x, numbers(rays, 1, 1), numbers(rays, 2, 0), "shadow ray, next path ray");
  expect_independent(x, numbers(shifted(rays, 1), 2), numbers(shifted(rays, 2), 3), "depths and triangles");
}

TEST(OpacityNumber, of_several_pixels_and_far_samples_are_independent) {
  const Rays rays = many();
  Rays next = rays, far = rays;
  for (std::size_t i = 0; i < kCount; ++i) {
    next.key[i] = rays.key[i] ^ 1U;  // keys are hashes: these are two pixels
    far.key[i] = rays.key[i] + 0x10000;
  }
  expect_independent(numbers(rays), numbers(next), numbers(far), "pixels");
  // Thirty bounces apart nothing meets a constant of the hash.
  expect_independent(numbers(rays, 1), numbers(rays, 30), numbers(rays, 1000), "far depths");
}

TEST(OpacityNumber, over_any_aligned_samples_of_a_pixel_has_one_in_each_stratum) {
  for (const unsigned m : {1U, 4U, 8U}) {
    const std::size_t n = std::size_t{1} << m;
    Rays rays;
    for (std::uint32_t i = 0; i < 4096; ++i) {
      rays.key.push_back(0x12345 + (i >> m) % 3);
      rays.index.push_back(i);
      rays.triangle.push_back((i >> m) % 7);
    }
    const std::vector<double> x = numbers(rays);
    for (std::size_t first = 0; first < x.size(); first += n) {
      std::vector<int> strata(n, 0);
      for (std::size_t i = first; i < first + n; ++i) ++strata[std::size_t(x[i] * double(n))];
      for (const int count : strata) ASSERT_EQ(count, 1) << "from sample " << first << " of " << n;
    }
  }
}

TEST(OpacityNumber, of_two_triangles_over_the_samples_of_one_pixel_fill_the_square) {
  // One pixel, one shuffle per triangle: if both had the same, their points would lie on few lines.
  Rays rays;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    rays.key.push_back(99);
    rays.index.push_back(i);
    rays.triangle.push_back(3);
  }
  const std::vector<double> a = numbers(rays), b = numbers(shifted(rays, 1));
  std::vector<double> cells(64, 0);
  for (std::size_t i = 0; i < kCount; ++i) ++cells[std::size_t(a[i] * 8) * 8 + std::size_t(b[i] * 8)];
  // Stratified, so more even than by chance; a chi-square test of the upper side still holds.
  expect_uniform(cells, "two triangles");
}

}  // namespace
}  // namespace eikon::test
