// SPDX-License-Identifier: Apache-2.0
// Scheduling with invented devices, in invented time.
#include "render/schedule.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <random>

#include "film/sample_set.h"

namespace eikon {
namespace {

struct SimulatedDevice {
  double paths_per_s = 1e6;
  double overhead_s = 1e-3;  // of a unit
  double spread = 0;         // of what a path takes, from block to block
  double joins_s = 0;        // when it is ready
  std::uint64_t capacity = 1U << 18;
  std::function<double(double)> speed = [](double) { return 1.0; };  // of time: changes of rate
  std::uint64_t fails_every = 0;                                     // units; 0: none does
  double dies_s = 1e30;                                              // gives back what it has, and leaves
};

struct Simulation {
  double wall_s = 0;
  std::vector<double> last_s;        // when each device finished its last unit
  std::vector<std::uint64_t> paths;  // that count
  std::vector<std::uint64_t> units;
  std::vector<double> left_out_at;
  std::size_t sample_set_parts = 0;  // at most, while it went on
};

// Events in the order of time: each device is idle, or has a unit, and then asks for one more to
// begin with at once after that. The set of samples throws if a sample is done twice.
Simulation simulate(const std::vector<SimulatedDevice>& devices, const Crop& crop, std::uint64_t spp, unsigned seed = 1) {
  struct Flying {
    bool fails = false;
    Schedule::Assignment assignment;
    double begin_s = 0, end_s = 0;
  };
  std::mt19937 random(seed);
  Schedule schedule(devices.size(), 128);
  schedule.open({WorkUnit{crop, 0, spp}});
  SampleSet done;
  Simulation outcome;
  outcome.last_s.resize(devices.size());
  outcome.paths.resize(devices.size());
  outcome.units.resize(devices.size());
  std::vector<std::deque<Flying>> flying(devices.size());  // the first is being done
  std::vector<bool> joined(devices.size()), dead(devices.size());
  constexpr double kTick = 0.01;  // idle devices ask again so often
  double now = 0;
  const auto begin = [&](std::size_t i, Flying& f) {
    const SimulatedDevice& d = devices[i];
    const double noise = std::exp(d.spread * std::normal_distribution<>()(random));
    f.begin_s = now;
    f.end_s = now + d.overhead_s + double(f.assignment.unit.path_count()) / (d.paths_per_s * d.speed(now)) * noise;
  };
  std::uint64_t rounds = 0;
  while (!schedule.complete()) {
    if (++rounds > 5000000) {
      ADD_FAILURE() << "no progress";
      break;
    }
    for (std::size_t i = 0; i < devices.size(); ++i) {
      const SimulatedDevice& d = devices[i];
      if (!joined[i] && now >= d.joins_s) {
        schedule.join(i, {d.capacity, std::min<std::uint64_t>(8192, d.capacity)});
        joined[i] = true;
      }
      if (!dead[i] && now >= d.dies_s) {
        schedule.leave(i);
        dead[i] = true;
        flying[i].clear();
      }
      while (!flying[i].empty() && now >= flying[i].front().end_s) {
        const Flying f = flying[i].front();
        flying[i].pop_front();
        if (!flying[i].empty()) begin(i, flying[i].front());
        if (f.fails) {
          schedule.gave_back(f.assignment.id);
        } else if (schedule.finished(f.assignment.id, f.begin_s, now)) {
          done.add(f.assignment.unit);
          outcome.sample_set_parts = std::max(outcome.sample_set_parts, done.parts().size());
          outcome.paths[i] += f.assignment.unit.path_count();
          outcome.last_s[i] = now;
        }
      }
    }
    for (std::size_t i = 0; i < devices.size(); ++i) {
      const SimulatedDevice& d = devices[i];
      while (flying[i].size() < 2 && !dead[i] && joined[i]) {
        const auto assignment = schedule.next(i, now);
        if (!assignment) break;
        EXPECT_LE(assignment->unit.path_count(), d.capacity);
        const bool fails = d.fails_every != 0 && ++outcome.units[i] % d.fails_every == 0;
        if (d.fails_every == 0) ++outcome.units[i];
        flying[i].push_back({fails, *assignment, 0, 0});
        if (flying[i].size() == 1) begin(i, flying[i].front());
      }
    }
    double next_s = now + kTick;
    for (const auto& of_device : flying)
      if (!of_device.empty()) next_s = std::min(next_s, std::max(of_device.front().end_s, std::nextafter(now, 1e30)));
    now = next_s;
  }
  for (std::size_t i = 0; i < devices.size(); ++i)
    if (!flying[i].empty()) outcome.last_s[i] = now;  // in vain, but not idle
  outcome.wall_s = *std::max_element(outcome.last_s.begin(), outcome.last_s.end());
  for (std::size_t i = 0; i < devices.size(); ++i) outcome.left_out_at.push_back(schedule.left_out_at(i));
  EXPECT_TRUE(done.missing(crop, 0, spp).empty());
  EXPECT_EQ(done.sample_count(), crop.pixel_count() * spp);
  return outcome;
}

constexpr Crop kSimulatedImage{0, 0, 512, 512};

double ideal_s(const std::vector<SimulatedDevice>& devices, const Crop& crop, std::uint64_t spp) {
  double rate = 0;
  for (const SimulatedDevice& d : devices) rate += d.paths_per_s;
  return double(crop.pixel_count() * spp) / rate;
}

// All finish within 3 % of the wall time of each other, and nearly as soon as is possible.
void expect_together(const std::vector<SimulatedDevice>& devices, std::uint64_t spp, double most_loss = 0.05) {
  const Simulation outcome = simulate(devices, kSimulatedImage, spp);
  for (std::size_t i = 0; i < devices.size(); ++i)
    EXPECT_LT(outcome.wall_s - outcome.last_s[i], 0.03 * outcome.wall_s) << "device " << i;
  EXPECT_LT(outcome.wall_s, (1 + most_loss) * ideal_s(devices, kSimulatedImage, spp));
}

TEST(Schedule, devices_of_any_ratio_finish_together) {
  for (double ratio : {1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0}) {
    SCOPED_TRACE(ratio);
    expect_together({{.paths_per_s = 4e6}, {.paths_per_s = 4e6 / ratio}}, 64);
    expect_together({{.paths_per_s = 4e6 / ratio}, {.paths_per_s = 4e6}}, 64);
    expect_together({{.paths_per_s = 4e6 / ratio}, {.paths_per_s = 4e6}, {.paths_per_s = 4e6 / std::sqrt(ratio)}}, 64);
    expect_together({{.paths_per_s = 100e6, .overhead_s = 2e-4, .capacity = 1U << 20},
                     {.paths_per_s = 100e6 / ratio, .overhead_s = 2e-4, .capacity = 1U << 20}},
                    1024);
  }
}

TEST(Schedule, devices_finish_together_where_some_blocks_take_longer) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const std::vector<SimulatedDevice> devices = {
        {.paths_per_s = 4e6, .spread = 0.4}, {.paths_per_s = 1e6, .spread = 0.4}, {.paths_per_s = 3e5, .spread = 0.4}};
    const Simulation outcome = simulate(devices, kSimulatedImage, 64, seed);
    for (double last_s : outcome.last_s) EXPECT_LT(outcome.wall_s - last_s, 0.03 * outcome.wall_s) << seed;
  }
}

TEST(Schedule, a_slower_device_makes_the_whole_faster_and_never_slower) {
  const SimulatedDevice fast{.paths_per_s = 4e6};
  for (std::uint64_t spp : {1U, 4U, 16U, 64U}) {
    const double alone_s = simulate({fast}, kSimulatedImage, spp).wall_s;
    for (double ratio : {10.0, 100.0, 1e3, 1e4, 1e6}) {
      const double both_s = simulate({fast, {.paths_per_s = 4e6 / ratio}}, kSimulatedImage, spp).wall_s;
      // Two more units, and an idle device asks again only after a tick.
      EXPECT_LT(both_s, alone_s * 1.02 + 2 * 4e-3 + 0.01) << ratio << " " << spp;
      if (ratio == 10.0 && spp >= 16) {
        EXPECT_LT(both_s, alone_s * 0.95) << spp;
      }
    }
  }
}

// The second device is half as fast in the last second as it was before.
TEST(Schedule, nothing_begins_that_would_end_after_the_time_given) {
  constexpr double kLatest_s = 5;
  const std::vector<double> rate = {4e6, 1e6};
  Schedule schedule(2, 128);
  schedule.open({WorkUnit{kSimulatedImage, 0, 1U << 20}});
  schedule.set_latest(kLatest_s);
  double last_s = 0;
  for (std::size_t device : {0U, 1U}) {
    schedule.join(device, {1U << 18, 8192});
    double now = 0;
    while (const auto assignment = schedule.next(device, now)) {
      const double slower = device == 1 && now > kLatest_s - 1 ? 2 : 1;
      const double end_s = now + 1e-3 + double(assignment->unit.path_count()) / rate[device] * slower;
      EXPECT_TRUE(schedule.finished(assignment->id, now, end_s));
      now = end_s;
    }
    EXPECT_GT(now, kLatest_s - 0.03) << "device " << device << " has no more work too early";
    last_s = std::max(last_s, now);
  }
  EXPECT_LT(last_s, kLatest_s + 0.05);
}

TEST(Schedule, a_device_slower_than_its_overhead_is_left_out) {
  const Simulation outcome = simulate({{.paths_per_s = 4e6}, {.paths_per_s = 4e6, .overhead_s = 30.0}}, kSimulatedImage, 64);
  EXPECT_EQ(outcome.paths[1], 0U);
  EXPECT_LT(outcome.wall_s, 1.05 * ideal_s({{.paths_per_s = 4e6}}, kSimulatedImage, 64));
  const Simulation late = simulate({{.paths_per_s = 4e6}, {.paths_per_s = 40.0}}, kSimulatedImage, 256);
  EXPECT_EQ(late.paths[1], 0U);
  EXPECT_LT(late.wall_s, 1.03 * ideal_s({{.paths_per_s = 4e6}}, kSimulatedImage, 256));
}

TEST(Schedule, left_out_is_said_only_of_a_device_that_is) {
  const Simulation outcome = simulate({{.paths_per_s = 4e6}, {.paths_per_s = 4e6, .overhead_s = 3.0}}, kSimulatedImage, 64);
  EXPECT_GT(outcome.left_out_at[1], 0.05);
  EXPECT_LT(outcome.left_out_at[0], 0.03);
  for (double at : simulate({{.paths_per_s = 4e6}, {.paths_per_s = 1e6}}, kSimulatedImage, 64).left_out_at) EXPECT_LT(at, 0.03);
}

TEST(Schedule, a_device_that_slows_down_keeps_nobody_waiting) {
  const auto slows = [](double factor, double at_s) {
    return [=](double now) { return now < at_s ? 1.0 : 1 / factor; };
  };
  for (double factor : {3.0, 30.0, 1e4})
    for (double at_s : {0.2, 1.0, 1.9}) {
      const SimulatedDevice steady{.paths_per_s = 4e6};
      const SimulatedDevice slowing{.paths_per_s = 4e6, .speed = slows(factor, at_s)};
      const Simulation outcome = simulate({steady, slowing}, kSimulatedImage, 64);
      const double alone_from_then_s = at_s + (ideal_s({steady}, kSimulatedImage, 64) - 2 * at_s);
      EXPECT_LT(outcome.wall_s, std::max(alone_from_then_s, 0.0) * 1.05 + 0.15) << factor << " at " << at_s;
    }
}

TEST(Schedule, a_device_that_comes_late_takes_part) {
  const Simulation outcome = simulate({{.paths_per_s = 1e6}, {.paths_per_s = 4e6, .joins_s = 3.0}}, kSimulatedImage, 64);
  EXPECT_NEAR(outcome.wall_s, 3.0 + (16.8 - 3.0) / 5, 0.2);
  for (double last_s : outcome.last_s) EXPECT_LT(outcome.wall_s - last_s, 0.03 * outcome.wall_s);
}

TEST(Schedule, units_that_fail_are_done_again) {
  for (std::uint64_t every : {2U, 3U, 7U, 20U}) {
    const Simulation outcome =
        simulate({{.paths_per_s = 4e6}, {.paths_per_s = 2e6, .fails_every = every}}, kSimulatedImage, 32, unsigned(every));
    EXPECT_GT(outcome.paths[0], 0U);
  }
  simulate({{.paths_per_s = 4e6, .fails_every = 2}}, kSimulatedImage, 8);  // nobody else
  simulate({{.paths_per_s = 4e6, .fails_every = 2}, {.paths_per_s = 1e4, .fails_every = 3}}, kSimulatedImage, 8);
}

TEST(Schedule, a_unit_that_failed_goes_to_another_device_first) {
  Schedule schedule(2, 128);
  schedule.open({WorkUnit{kSimulatedImage, 0, 4}});
  schedule.join(0, {1U << 16, 1024});
  schedule.join(1, {1U << 16, 1024});
  const auto failed = schedule.next(0, 0);
  const auto other = schedule.next(1, 0);
  schedule.gave_back(failed->id);
  EXPECT_FALSE(schedule.next(0, 0.1)->unit == failed->unit);
  EXPECT_TRUE(schedule.finished(other->id, 0, 0.1));
  EXPECT_EQ(schedule.next(1, 0.1)->unit, failed->unit);
  // Nobody else is left: then to the same device.
  const auto again = schedule.next(0, 0.2);
  schedule.leave(1);
  schedule.gave_back(again->id);
  EXPECT_TRUE(schedule.next(0, 0.3));
}

TEST(Schedule, what_was_taken_away_does_not_count_when_it_comes_late) {
  Schedule schedule(2, 128);
  schedule.open({WorkUnit{{0, 0, 16, 16}, 0, 4}});
  schedule.join(0, {1U << 16, 1024});
  schedule.join(1, {1U << 16, 1024});
  const auto hung = schedule.next(0, 0);
  ASSERT_EQ(hung->unit.path_count(), 1024U);
  schedule.leave(0);
  EXPECT_FALSE(schedule.finished(hung->id, 0, 5));
  EXPECT_FALSE(schedule.complete());
  const auto again = schedule.next(1, 6);
  EXPECT_EQ(again->unit, hung->unit);
  EXPECT_TRUE(schedule.finished(again->id, 6, 7));
  EXPECT_TRUE(schedule.complete());
  EXPECT_FALSE(schedule.finished(again->id, 6, 7));
}

TEST(Schedule, the_first_of_two_that_have_the_same_unit_counts) {
  for (const bool late_one_first : {false, true}) {
    Schedule schedule(2, 128);
    schedule.open({WorkUnit{{0, 0, 32, 32}, 0, 1}, WorkUnit{{32, 0, 64, 32}, 0, 1}});
    schedule.join(0, {1U << 16, 1024});
    schedule.join(1, {1U << 16, 1024});
    const auto slow = schedule.next(0, 0), quick = schedule.next(1, 0);
    ASSERT_TRUE(schedule.finished(quick->id, 0, 0.01));
    EXPECT_FALSE(schedule.next(1, 0.011)) << "too early to say that it is late";
    const auto copy = schedule.next(1, 0.5);
    ASSERT_TRUE(copy);
    EXPECT_EQ(copy->unit, slow->unit);
    const std::uint64_t first = late_one_first ? slow->id : copy->id, second = late_one_first ? copy->id : slow->id;
    EXPECT_TRUE(schedule.finished(first, 0.5, 0.6));
    EXPECT_TRUE(schedule.complete());
    EXPECT_FALSE(schedule.finished(second, 0, 0.7));
    EXPECT_TRUE(schedule.complete());
  }
}

TEST(Schedule, a_device_of_which_nothing_is_known_takes_what_is_long_overdue) {
  Schedule schedule(2, 128);
  schedule.open({WorkUnit{{0, 0, 32, 32}, 0, 1}});
  schedule.join(0, {1U << 16, 1024});
  schedule.join(1, {1U << 16, 1024});
  const auto slow = schedule.next(0, 0);
  EXPECT_FALSE(schedule.next(1, 0.3)) << "it may come soon";
  const auto copy = schedule.next(1, 3);
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->unit, slow->unit);
}

TEST(Schedule, a_unit_is_done_twice_only_by_a_device_that_is_idle) {
  Schedule schedule(2, 128);
  schedule.open({WorkUnit{{0, 0, 32, 32}, 0, 1}, WorkUnit{{32, 0, 64, 32}, 0, 1}, WorkUnit{{64, 0, 96, 32}, 0, 1}});
  schedule.join(0, {1U << 16, 1024});
  schedule.join(1, {1U << 16, 1024});
  const auto slow = schedule.next(0, 0), quick = schedule.next(1, 0);
  ASSERT_TRUE(schedule.finished(quick->id, 0, 0.01));
  std::vector<std::uint64_t> own;  // all that is left
  while (const auto assignment = schedule.next(1, 0.01)) own.push_back(assignment->id);
  ASSERT_FALSE(own.empty());
  EXPECT_FALSE(schedule.next(1, 5)) << "nothing could call it off behind the one in hand";
  for (const std::uint64_t id : own) ASSERT_TRUE(schedule.finished(id, 0.01, 0.02));
  const auto copy = schedule.next(1, 5);
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->unit, slow->unit);
}

TEST(Schedule, any_device_may_die_at_any_time) {
  for (double dies_s : {0.0, 1e-4, 0.01, 0.5, 1.0, 2.0, 2.7}) {
    simulate({{.paths_per_s = 4e6}, {.paths_per_s = 2e6, .dies_s = dies_s}}, kSimulatedImage, 64);
    simulate({{.paths_per_s = 1e5}, {.paths_per_s = 4e6, .dies_s = dies_s}}, kSimulatedImage, 16);
  }
}

TEST(Schedule, the_set_of_samples_stays_small) {
  const Simulation outcome =
      simulate({{.paths_per_s = 4e6}, {.paths_per_s = 4e5}, {.paths_per_s = 4e4}}, {0, 0, 1920, 1080}, 64);
  // A part for each of 15 x 9 blocks, twice that where samples are missing within, and what the
  // slow devices cut.
  EXPECT_LT(outcome.sample_set_parts, 1000U);
}

TEST(Schedule, a_device_that_is_open_first_begins_with_little_while_others_are_expected) {
  constexpr UnitLimits kLimits = {1U << 18, 8192};
  const auto first_unit = [&](std::size_t devices, bool other_cannot_be_opened) {
    Schedule schedule(devices, 128);
    schedule.open({WorkUnit{kSimulatedImage, 0, 64}});
    if (other_cannot_be_opened) schedule.leave(1);
    schedule.join(0, kLimits);
    return schedule.next(0, 0)->unit.path_count();
  };
  // It may be so slow that it would have that unit alone when the others have done all else.
  EXPECT_LE(first_unit(2, false), 1024U);
  EXPECT_GT(first_unit(2, true), 4096U);
  EXPECT_GT(first_unit(1, false), 4096U);
}

TEST(Schedule, a_single_device_gets_large_units) {
  const Simulation outcome = simulate({{.paths_per_s = 4e6}}, kSimulatedImage, 64);
  EXPECT_LT(outcome.wall_s, ideal_s({{.paths_per_s = 4e6}}, kSimulatedImage, 64) + 70 * 1e-3);
}

TEST(Schedule, no_unit_takes_much_longer_than_half_a_second) {
  Schedule schedule(1, 128);
  schedule.open({WorkUnit{kSimulatedImage, 0, 64}});
  schedule.join(0, {1U << 22, 4096});
  double now = 0;
  for (int i = 0; i < 50; ++i) {
    const auto unit = schedule.next(0, now);
    const double seconds = double(unit->unit.path_count()) / 1e4;
    EXPECT_LT(seconds, 0.75);
    if (i > 0) {
      EXPECT_NEAR(*schedule.expected_s(unit->id), seconds, 0.1 * seconds);
    }
    (void)schedule.finished(unit->id, now, now + seconds);
    now += seconds;
  }
}

}  // namespace
}  // namespace eikon
