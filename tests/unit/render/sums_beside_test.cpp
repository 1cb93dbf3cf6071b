// SPDX-License-Identifier: Apache-2.0
// Sums that are added beside the thread of their device: nothing is lost or added twice, and no
// error goes by.
#include <gtest/gtest.h>

#include "core/error.h"
#include "unit/render/fake_devices.h"

namespace eikon::test {
namespace {

std::shared_ptr<std::vector<FakeDevice>> devices_beside(std::size_t count) {
  auto all = devices(count);
  for (FakeDevice& device : *all) device.beside = true;
  return all;
}

void expect_exact(const Outcome& outcome) {
  ASSERT_EQ(outcome.state, DeviceSessions::State::done);
  EXPECT_EQ(outcome.totals.samples, kImage.pixel_count() * kSpp);
  EXPECT_TRUE(outcome.film->sample_set.missing(kImage, 0, kSpp).empty());
  for (std::uint32_t y = 0; y < kImage.y1; ++y)
    for (std::uint32_t x = 0; x < kImage.x1; ++x)
      for (std::uint32_t c = 0; c < 3; ++c) {
        std::uint64_t sum = 0;
        for (std::uint64_t s = 0; s < kSpp; ++s) sum += value(x, y, s, c);
        ASSERT_TRUE(outcome.film->film.total(x, y, c) == int128(sum)) << x << "," << y;
      }
}

TEST(SumsBeside, are_all_in_the_film) {
  for (const std::size_t count : {1U, 3U}) {
    auto all = devices_beside(count);
    for (FakeDevice& device : *all) device.capacity = 600, device.path_s = 1e-8;
    expect_exact(run(all));
  }
}

TEST(SumsBeside, of_units_before_a_failure_count_once) {
  for (const std::uint64_t every : {2U, 3U, 7U}) {
    auto two = devices_beside(2);
    for (FakeDevice& device : *two) device.capacity = 900;
    (*two)[0].unit = [&](std::uint64_t n, const WorkUnit&) {
      if (n % every == 1) throw DeviceError("it is broken");
    };
    const Outcome outcome = run(two);
    expect_exact(outcome);
    EXPECT_GT(outcome.devices[0].failures, 0U);
  }
}

TEST(SumsBeside, an_error_of_the_film_ends_the_render_also_where_the_device_fails_at_once) {
  for (const bool fails : {false, true}) {
    auto one = devices_beside(1);
    (*one)[0].capacity = 900;
    (*one)[0].spoils = [](std::uint64_t n) { return n == 3; };
    (*one)[0].unit = [&](std::uint64_t n, const WorkUnit&) {
      if (fails && n == 4) throw DeviceError("it is broken");
    };
    const Outcome outcome = run(one);
    EXPECT_EQ(outcome.state, DeviceSessions::State::broken);
    ASSERT_TRUE(outcome.error);
    EXPECT_THROW(std::rethrow_exception(outcome.error), InternalError) << fails;
  }
}

TEST(SumsBeside, an_error_of_the_last_unit_is_told) {
  auto one = devices_beside(1);
  std::uint64_t paths = 0;
  (*one)[0].unit = [&](std::uint64_t, const WorkUnit& unit) { paths += unit.path_count(); };
  (*one)[0].spoils = [&](std::uint64_t) { return paths == kImage.pixel_count() * kSpp; };
  const Outcome outcome = run(one);
  EXPECT_EQ(outcome.state, DeviceSessions::State::broken);
  EXPECT_TRUE(outcome.error);
}

}  // namespace
}  // namespace eikon::test
