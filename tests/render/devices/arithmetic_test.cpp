// SPDX-License-Identifier: Apache-2.0
// What a driver that breaks the arithmetic's rules does: the bits change, the class says so, and
// the picture stays right.
#include "render/scene_builder.h"

#include <cmath>

namespace eikon::test {
namespace {

struct Loose {
  const char* flags;
  bool
      // Our kernels keep denormals out, and then a device that flushes them has the bits of one
      // that does not.
      may_be_exact;
};

constexpr Loose kLoose[] = {{"-cl-fast-relaxed-math", false},
                            {"-cl-denorms-are-zero", true},
                            {"-cl-mad-enable -cl-unsafe-math-optimizations", false}};

Execution loose(const char* flags) {
  Execution execution;
  execution.extra_flags = flags;
  return execution;
}

TEST(Arithmetic, N8_loose_arithmetic_changes_no_mean) {
  const auto [scene, settings] = room(48, 36, 64);
  const Film exact = film_of(scene, settings);
  for (const Loose& driver : kLoose) {
    const RenderOutput found = output_of(scene, settings, loose(driver.flags));
    // The same random numbers, so nearly the same paths: pixels differ by what few of them do
    // otherwise.
    std::uint32_t far = 0;
    double difference = 0, sum = 0;
    for (std::uint32_t y = 0; y < settings.height; ++y)
      for (std::uint32_t x = 0; x < settings.width; ++x)
        for (std::uint32_t c = 0; c < 3; ++c) {
          const double d = found.film.mean(x, y, c) - exact.mean(x, y, c);
          const double sigma = std::sqrt(found.film.variance_of_mean(x, y, c) + exact.variance_of_mean(x, y, c)) +
                               1e-4 * exact.mean(x, y, c);
          far += std::abs(d) > 8 * sigma ? 1 : 0;
          difference += d;
          sum += exact.mean(x, y, c);
        }
    EXPECT_LE(far, 48U * 36U * 3U / 400U) << driver.flags;  // 99.75 % within
    EXPECT_LT(std::abs(difference), 2e-3 * sum) << driver.flags;
  }
}

TEST(Arithmetic, N8_the_class_tells_contracted_or_approximate_arithmetic) {
  const auto [scene, settings] = room(8, 8, 2);
  EXPECT_EQ(output_of(scene, settings).report.arithmetic(), "exact");
  for (const Loose& driver : kLoose) {
    const std::string found = output_of(scene, settings, loose(driver.flags)).report.arithmetic();
    EXPECT_TRUE(driver.may_be_exact || found != "exact") << driver.flags;
  }
}

TEST(Arithmetic, N8_rejected_samples_are_counted_under_finite_math_too) {
  // Radiance that overflows when it is multiplied: infinite on every device, whatever it assumes.
  auto [scene, settings] = room(16, 12, 8);
  for (Material& material : scene.materials)
    if (material.emission.x > 0) material.emission = glm::vec3(3.4e38F);
  const RenderOutput exact = output_of(scene, settings);
  ASSERT_GT(exact.report.nonfinite + exact.report.saturated, 0U);
  for (const Loose& driver : kLoose) {
    const RenderOutput found = output_of(scene, settings, loose(driver.flags));
    EXPECT_GT(found.report.nonfinite + found.report.saturated, 0U) << driver.flags;
    for (std::uint32_t i = 0; i < 16 * 12; ++i)
      ASSERT_TRUE(std::isfinite(found.film.mean(i % 16, i / 16, 0))) << driver.flags;
  }
}

TEST(Arithmetic, N7_direct_light_of_one_sample_is_the_same_from_chunks_queues_and_every_device) {
  auto [scene, settings] = room(64, 48, 1);
  settings.max_depth = 2;
  const Film reference = film_of(scene, settings);
  for (const DeviceInfo& info : select_devices("all"))
    for (bool chunked : {true, false}) {
      Execution execution;
      execution.devices = std::to_string(info.index);
      execution.chunked = chunked;
      EXPECT_TRUE(same_film(reference, film_of(scene, settings, execution))) << info.name << " chunked " << chunked;
    }
}

}  // namespace
}  // namespace eikon::test
