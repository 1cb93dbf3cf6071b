// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <memory>
#include <random>

#include "core/error.h"
#include "image/image.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace eikon {
namespace {

using test::contains;
using test::message_of;
using test::TemporaryFolder;

Image constant(std::uint32_t width, std::uint32_t height, float value) {
  const std::vector<float> plane(std::size_t{width} * height, value);
  return {
      .width = width, .height = height, .channels = {"R", "G", "B"}, .planes = {plane, plane, plane}, .metadata = {}};
}

/// Radiances over six orders of magnitude; a few negative.
Image noise(std::uint32_t width, std::uint32_t height, unsigned seed) {
  Image image = constant(width, height, 0);
  std::mt19937 random(seed);
  for (auto& plane : image.planes)
    for (float& value : plane)
      value = std::exp(std::normal_distribution<float>(-1, 3)(random)) * (random() % 16 == 0 ? -1.0f : 1.0f);
  return image;
}

void write_raw(const std::filesystem::path& path, const Image& image) {
  std::ofstream file(path, std::ios::binary);
  for (const auto& plane : image.planes)
    file.write(reinterpret_cast<const char*>(plane.data()), static_cast<std::streamsize>(plane.size() * sizeof(float)));
}

TEST(Compare, metrics_agree_with_numpy) {
  if (std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") != 0) GTEST_SKIP() << "numpy is not installed";
  const TemporaryFolder folder;
  std::ofstream(folder / "metrics.py") << R"(
import numpy, sys
x, r = (numpy.fromfile(p, dtype=numpy.float32).astype(numpy.float64) for p in sys.argv[1:3])
keep = numpy.isfinite(x) & numpy.isfinite(r)
lost, x, r = (~keep).sum(), x[keep], r[keep]
d = x - r
print(repr(float((d * d).mean())), repr(float((d * d / (r * r + 1e-2)).mean())),
      repr(float((abs(d) / (abs(r) + 1e-2)).mean())), repr(float(x.mean() / r.mean())), lost)
)";
  for (unsigned seed = 0; seed < 4; ++seed) {
    Image test = noise(61 + seed, 47, seed), reference = noise(61 + seed, 47, seed + 100);
    if (seed > 1) {
      test.planes[0][5] = std::numeric_limits<float>::quiet_NaN();
      test.planes[2][9] = reference.planes[2][9] = std::numeric_limits<float>::infinity();
    }
    write_raw(folder / "test", test);
    write_raw(folder / "reference", reference);
    const std::string command = "/usr/bin/python3 " + (folder / "metrics.py").string() + " " +
                                (folder / "test").string() + " " + (folder / "reference").string();
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    ASSERT_TRUE(pipe);
    double mse = 0, relmse = 0, mape = 0, ratio = 0;
    unsigned nonfinite = 0;
    ASSERT_EQ(std::fscanf(pipe.get(), "%lf %lf %lf %lf %u", &mse, &relmse, &mape, &ratio, &nonfinite), 5);
    const Comparison result = compare_images(test, reference);
    EXPECT_NEAR(result.mse, mse, 1e-12 * mse);
    EXPECT_NEAR(result.relmse, relmse, 1e-12 * relmse);
    EXPECT_NEAR(result.mape, mape, 1e-12 * mape);
    EXPECT_NEAR(result.ratio_of_means, ratio, 1e-10 * std::abs(ratio));
    EXPECT_EQ(result.nonfinite, nonfinite);
    EXPECT_EQ(result.nonfinite, seed > 1 ? 2u : 0u);
  }
}

TEST(Compare, measures_are_those_computed_by_hand) {
  const Comparison result = compare_images(constant(2, 2, 2.0f), constant(2, 2, 1.0f));
  EXPECT_DOUBLE_EQ(result.mse, 1);
  EXPECT_DOUBLE_EQ(result.relmse, 1 / 1.01);
  EXPECT_DOUBLE_EQ(result.mape, 1 / 1.01);
  EXPECT_DOUBLE_EQ(result.ratio_of_means, 2);
}

TEST(Compare, an_image_equals_itself_and_black_equals_black) {
  const Image image = noise(8, 8, 3);
  const Comparison same = compare_images(image, image);
  EXPECT_EQ(same.relmse, 0);
  EXPECT_EQ(same.ratio_of_means, 1);
  EXPECT_EQ(compare_images(constant(3, 3, 0), constant(3, 3, 0)).ratio_of_means, 1);
  EXPECT_TRUE(std::isinf(compare_images(constant(3, 3, 1), constant(3, 3, 0)).ratio_of_means));
}

TEST(Compare, when_no_value_is_finite_the_metrics_are_nan) {
  const Comparison result = compare_images(constant(2, 2, std::numeric_limits<float>::quiet_NaN()), constant(2, 2, 1));
  EXPECT_EQ(result.nonfinite, 12u);
  EXPECT_TRUE(std::isnan(result.relmse));
  EXPECT_TRUE(std::isnan(result.ratio_of_means));
}

TEST(Compare, sizes_that_differ_are_named_and_missing_channels_too) {
  const std::string message =
      message_of([] { static_cast<void>(compare_images(constant(4, 3, 1), constant(5, 3, 1))); });
  EXPECT_TRUE(contains(message, "4x3"));
  EXPECT_TRUE(contains(message, "5x3"));
  Image depth = constant(4, 3, 1);
  depth.channels[1] = "Z";
  EXPECT_THROW(static_cast<void>(compare_images(constant(4, 3, 1), depth)), InputError);
  EXPECT_THROW(static_cast<void>(difference_image(depth, constant(4, 3, 1))), InputError);
}

TEST(Compare, the_difference_image_goes_from_black_to_white_and_marks_what_is_not_finite) {
  Image test = constant(3, 1, 1.0f);
  test.planes[1][1] = 50;
  test.planes[2][2] = std::numeric_limits<float>::infinity();
  const Image difference = difference_image(test, constant(3, 1, 1.0f));
  EXPECT_LT(difference.planes[1][0], 0.01f);
  EXPECT_EQ(difference.planes[0][1], 1.0f);
  EXPECT_EQ(difference.planes[2][1], 1.0f);
  EXPECT_EQ(difference.planes[0][2], 0.0f);
  EXPECT_EQ(difference.planes[1][2], 1.0f);
}

}  // namespace
}  // namespace eikon
