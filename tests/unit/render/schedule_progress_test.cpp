// SPDX-License-Identifier: Apache-2.0
// Scheduling goes on as long as something is left, whatever was measured of the devices.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "render/schedule.h"

namespace eikon {
namespace {

TEST(Schedule, somebody_takes_what_is_left_whatever_was_measured) {
  // Units that take any time, so that devices look quick for one size and slow for another. Nobody
  // may wait for the others for ever.
  for (unsigned seed = 0; seed < 20000; ++seed) {
    std::mt19937 random(seed);
    const auto log_uniform = [&](double least, double most) {
      return least * std::pow(most / least, std::generate_canonical<double, 53>(random));
    };
    const std::size_t devices = 2 + random() % 2;
    Schedule schedule(devices, 32);
    schedule.open(
        {WorkUnit{{0, 0, 1 + std::uint32_t(random() % 200), 1 + std::uint32_t(random() % 200)}, 0, 1 + random() % 64}});
    for (std::size_t i = 0; i < devices; ++i) {
      const auto capacity = std::uint64_t(log_uniform(1 << 10, 1 << 18));
      schedule.join(i, {capacity, std::min<std::uint64_t>(capacity, std::uint64_t(log_uniform(1, 1 << 14)))});
    }
    double now_s = 0;
    while (!schedule.complete()) {
      std::vector<Schedule::Assignment> taken;
      for (std::size_t i = 0; i < devices; ++i)
        if (const auto assignment = schedule.next(i, now_s)) taken.push_back(*assignment);
      ASSERT_FALSE(taken.empty()) << "nobody takes a unit, seed " << seed;
      double end_s = now_s;
      for (const Schedule::Assignment& assignment : taken) {
        const double seconds = log_uniform(1e-4, 1);
        schedule.finished(assignment.id, now_s, now_s + seconds);
        end_s = std::max(end_s, now_s + seconds);
      }
      now_s = end_s;
    }
  }
}

}  // namespace
}  // namespace eikon
