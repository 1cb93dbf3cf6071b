// SPDX-License-Identifier: Apache-2.0
// Device threads with invented devices: what fails, hangs or dawdles changes nothing of the film.
#include "render/device_sessions.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "core/error.h"
#include "support/lost_threads.h"
#include "support/messages.h"
#include "unit/render/fake_devices.h"

namespace eikon::test {
namespace {

void expect_complete(const Outcome& outcome) {
  ASSERT_EQ(outcome.state, DeviceSessions::State::done);
  EXPECT_EQ(outcome.totals.samples, kImage.pixel_count() * kSpp);
  EXPECT_TRUE(outcome.film->sample_set.missing(kImage, 0, kSpp).empty());
  std::uint64_t samples = 0;
  for (const DeviceReport& device : outcome.devices) samples += device.samples;
  EXPECT_EQ(samples, outcome.totals.samples);
  for (std::uint32_t y = 0; y < kImage.y1; ++y)
    for (std::uint32_t x = 0; x < kImage.x1; ++x)
      for (std::uint32_t c = 0; c < 3; ++c) {
        std::uint64_t sum = 0;
        for (std::uint64_t s = 0; s < kSpp; ++s) sum += value(x, y, s, c);
        ASSERT_TRUE(outcome.film->film.total(x, y, c) == int128(sum)) << x << "," << y;
      }
}

[[noreturn]] void fail() { throw DeviceError("it is broken"); }

/// A call that does not return until the test is over; longer than any watchdog here.
class Hang {
 public:
  Hang() = default;
  Hang(const Hang&) = delete;
  Hang& operator=(const Hang&) = delete;
  ~Hang() {
    release();
    EXPECT_TRUE(wait_for_lost_threads(10));
  }
  [[nodiscard]] std::function<void()> call() const {
    return [released = released_] {
      while (!released->load()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
  }
  void release() const { *released_ = true; }

 private:
  std::shared_ptr<std::atomic<bool>> released_ = std::make_shared<std::atomic<bool>>(false);
};

TEST(DeviceSessions, devices_of_unequal_speed_make_one_film) {
  auto three = devices(3);
  (*three)[1].path_s = 1e-6;
  (*three)[2].path_s = 2e-5;
  const Outcome outcome = run(three);
  expect_complete(outcome);
  EXPECT_GT(outcome.devices[0].units, 0U);
  EXPECT_GT(outcome.devices[1].units, 0U);
  EXPECT_TRUE(outcome.totals.render_s > 0);
}

TEST(DeviceSessions, a_unit_that_fails_at_any_moment_is_done_by_another_device) {
  for (std::uint64_t after : {0U, 1U, 2U, 5U}) {
    auto two = devices(2);
    (*two)[1].unit = [&](std::uint64_t n, const WorkUnit&) {
      if (n >= after) fail();
    };
    const Outcome outcome = run(two);
    expect_complete(outcome);
    if (outcome.devices[1].units == after && outcome.devices[1].failures > 0) {
      EXPECT_TRUE(outcome.has(1, DeviceEvent::Kind::failed)) << after;
    }
    EXPECT_FALSE(outcome.has(0, DeviceEvent::Kind::failed));
  }
}

TEST(DeviceSessions, a_device_that_fails_now_and_then_stays) {
  auto one = devices(1);
  (*one)[0].unit = [](std::uint64_t n, const WorkUnit&) {
    if (n % 5 == 3 && n < 30) fail();
  };
  const Outcome outcome = run(one);
  expect_complete(outcome);
  EXPECT_GE(outcome.devices[0].failures, 1U);
  EXPECT_FALSE(outcome.has(0, DeviceEvent::Kind::dropped));
}

TEST(DeviceSessions, units_become_smaller_where_large_ones_fail) {
  auto one = devices(1);
  (*one)[0].unit = [](std::uint64_t, const WorkUnit& unit) {
    if (unit.path_count() > 4096) fail();  // as out of memory would
  };
  const Outcome outcome = run(one);
  expect_complete(outcome);
  EXPECT_EQ(outcome.devices[0].device_bytes, 4096U) << "a quarter of what it began with";
}

TEST(DeviceSessions, single_faults_are_forgiven_and_units_grow_again) {
  // Of 20 units, one fails, and 8 are of a quarter's size: 3/2 times as many as undisturbed, and
  // the last of them smaller. Units that take long on a busy machine become smaller, too; not in
  // every attempt.
  std::uint64_t units = 2 * 288;
  for (int attempt = 0; attempt < 20 && units >= 2 * 288; ++attempt) {
    auto one = devices(1);
    (*one)[0].capacity = 512;  // 288 units, undisturbed
    (*one)[0].unit = [](std::uint64_t n, const WorkUnit&) {
      if (n % 20 == 19) fail();
    };
    const Outcome outcome = run(one);
    expect_complete(outcome);
    EXPECT_GT(outcome.devices[0].failures, 12U) << "more than are borne in a row, or near each other";
    units = outcome.devices[0].units;
  }
  EXPECT_LT(units, 2 * 288U);
}

TEST(DeviceSessions, a_device_that_fails_too_often_is_dropped) {
  auto one = devices(1);
  (*one)[0].capacity = 512;
  (*one)[0].unit = [](std::uint64_t n, const WorkUnit&) {
    if (n % 3 == 2) fail();
  };
  const Outcome outcome = run(one);
  EXPECT_EQ(outcome.state, DeviceSessions::State::no_device_left);
  EXPECT_EQ(outcome.devices[0].failures, 10U);
}

TEST(DeviceSessions, a_device_that_failed_and_hangs_when_it_is_closed_is_given_up_in_time) {
  // Half of what opening it may take; a busy machine may need longer, but not in every attempt.
  constexpr double kWatchdog_s = 0.2, kInTime_s = 0.5 * DeviceSessions::kOpeningWatchdogs * kWatchdog_s;
  double least_s = kInTime_s;
  for (int attempt = 0; attempt < 5 && least_s >= kInTime_s; ++attempt) {
    const Hang hang;
    auto one = devices(1);
    (*one)[0].unit = [](std::uint64_t n, const WorkUnit&) {
      if (n == 2) fail();
    };
    (*one)[0].close = hang.call();
    const auto begin = std::chrono::steady_clock::now();
    const Outcome outcome = run(one, kWatchdog_s);
    least_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    EXPECT_EQ(outcome.state, DeviceSessions::State::no_device_left);
    EXPECT_TRUE(contains(outcome.failure_summary, "it is broken; then closing it did not end within"))
        << outcome.failure_summary;
  }
  EXPECT_LT(least_s, kInTime_s);
}

TEST(DeviceSessions, when_it_is_stopped_nobody_waits_for_a_device_that_is_being_opened) {
  const Hang hang;  // a compiler
  auto sessions =
      std::make_shared<DeviceSessions>(std::vector<DeviceReport>(1), FilmState{Film(layout()), SampleSet()}, 32, 5);
  const auto one = devices(1);
  (*one)[0].open = [hangs = hang.call()](unsigned) { hangs(); };
  sessions->open({WorkUnit{kImage, 0, kSpp}});
  std::thread thread([sessions, one] {
    run_device(sessions, 0,
               [one](std::size_t, unsigned shrink) { return std::make_unique<FakeRunner>((*one)[0], shrink); });
  });
  EXPECT_EQ(sessions->state(), DeviceSessions::State::working);
  sessions->end();
  sessions->wait_for_threads();  // returns, though the call hangs until the end of the test
  ASSERT_TRUE(sessions->is_lost(0));
  EXPECT_TRUE(sessions->events().empty());
  thread.detach();
}

TEST(DeviceSessions, a_device_too_slow_for_the_rest_is_left_out_and_that_is_said) {
  // On a machine so busy that the fast device sleeps too long, the slow one is of use. That is not
  // so in every attempt.
  Outcome outcome;
  for (int attempt = 0; attempt < 20 && !outcome.has(1, DeviceEvent::Kind::left_out); ++attempt) {
    auto two = devices(2);
    (*two)[0].path_s = 2e-6;  // 0.3 s for all
    // 0.1 s for its first unit of 1024 paths, and for a quarter of its grain: the last third is too
    // short
    (*two)[1].path_s = 1e-4;
    (*two)[1].grain = 4096;
    outcome = run(two, 60);
    expect_complete(outcome);
  }
  ASSERT_TRUE(outcome.has(1, DeviceEvent::Kind::left_out));
  for (const DeviceEvent& event : outcome.events)
    if (event.kind == DeviceEvent::Kind::left_out) {
      EXPECT_EQ(event.text.rfind("it was left out of the last ", 0), 0U) << event.text;
      EXPECT_TRUE(contains(event.text, " % of the work: its units would have been late"));
    }
  EXPECT_FALSE(outcome.has(0, DeviceEvent::Kind::left_out));
}

TEST(DeviceSessions, a_device_that_cannot_be_opened_is_dropped) {
  auto two = devices(2);
  (*two)[0].open = [](unsigned) { fail(); };
  (*two)[1].path_s = 2e-6;
  const Outcome outcome = run(two);
  expect_complete(outcome);
  EXPECT_TRUE(outcome.has(0, DeviceEvent::Kind::dropped));
  EXPECT_EQ(outcome.devices[0].error, "it is broken");
}

TEST(DeviceSessions, a_device_that_does_not_compile_the_kernels_is_opened_once) {
  auto two = devices(2);
  int opened = 0;
  (*two)[0].open = [&opened](unsigned) {
    ++opened;
    throw CompileError("the kernels do not compile");
  };
  const Outcome outcome = run(two);
  EXPECT_EQ(outcome.state, DeviceSessions::State::done);
  EXPECT_EQ(opened, 1);
  EXPECT_TRUE(outcome.has(0, DeviceEvent::Kind::dropped));
}

TEST(DeviceSessions, when_all_devices_fail_what_is_done_stays) {
  auto two = devices(2);
  for (FakeDevice& device : *two)
    device.unit = [](std::uint64_t n, const WorkUnit&) {
      if (n >= 3) fail();
    };
  const Outcome outcome = run(two);
  EXPECT_EQ(outcome.state, DeviceSessions::State::no_device_left);
  EXPECT_GT(outcome.totals.samples, 0U);
  EXPECT_EQ(outcome.film->sample_set.sample_count(), outcome.totals.samples);
  EXPECT_TRUE(contains(outcome.failure_summary, "it is broken"));
}

TEST(DeviceSessions, an_error_that_is_not_the_devices_ends_it) {
  auto two = devices(2);
  (*two)[1].unit = [](std::uint64_t, const WorkUnit&) { throw InternalError("impossible"); };
  (*two)[0].path_s = 1e-6;
  const Outcome outcome = run(two);
  EXPECT_EQ(outcome.state, DeviceSessions::State::broken);
  EXPECT_THROW(std::rethrow_exception(outcome.error), InternalError);
}

TEST(DeviceSessions, a_device_that_hangs_is_given_up_and_what_it_brings_later_does_not_count) {
  for (std::uint64_t at : {0U, 2U}) {
    const Hang hang;
    auto two = devices(2);
    (*two)[0].path_s = 1e-6;
    (*two)[1].unit = [at, hangs = hang.call()](std::uint64_t n, const WorkUnit&) {
      if (n == at) hangs();
    };
    const Outcome outcome = run(two, 0.1);
    expect_complete(outcome);
    EXPECT_TRUE(outcome.has(1, DeviceEvent::Kind::hung) || outcome.has(1, DeviceEvent::Kind::late));
    EXPECT_EQ(lost_threads(), 1);
    // It comes back: the thread ends, and the film is as it was.
    hang.release();
    EXPECT_TRUE(wait_for_lost_threads(10));
    expect_complete(outcome);
  }
}

TEST(DeviceSessions, the_only_device_that_hangs_ends_it_in_time) {
  const Hang hang;
  auto one = devices(1);
  (*one)[0].unit = [hangs = hang.call()](std::uint64_t n, const WorkUnit&) {
    if (n == 2) hangs();
  };
  const Outcome outcome = run(one, 0.1);  // returns, though the call hangs until the end of the test
  EXPECT_EQ(outcome.state, DeviceSessions::State::no_device_left);
  EXPECT_GT(outcome.totals.samples, 0U);
  EXPECT_TRUE(outcome.has(0, DeviceEvent::Kind::hung));
  EXPECT_TRUE(contains(outcome.failure_summary, "did not end within"));
}

TEST(DeviceSessions, opening_that_hangs_is_given_up_when_the_others_are_done) {
  const Hang hang;
  auto two = devices(2);
  (*two)[1].open = [hangs = hang.call()](unsigned) { hangs(); };
  const Outcome outcome = run(two);
  expect_complete(outcome);
  EXPECT_TRUE(outcome.has(1, DeviceEvent::Kind::late));
  EXPECT_EQ(lost_threads(), 1);
}

TEST(DeviceSessions, a_device_that_dawdles_keeps_nobody_waiting) {
  const Hang hang;
  auto two = devices(2);
  (*two)[1].unit = [hangs = hang.call()](std::uint64_t n, const WorkUnit&) {
    if (n == 1) hangs();  // far from what the watchdog would call hung
  };
  const Outcome outcome =
      run(two, 3600);  // the call hangs until the end of the test, which comes only if nobody waits for it
  expect_complete(outcome);
  EXPECT_TRUE(outcome.has(1, DeviceEvent::Kind::late));
}

TEST(DeviceSessions, samples_that_two_devices_finish_count_once_and_are_told) {
  auto two = devices(2);
  const auto worked = std::make_shared<std::array<std::atomic<std::uint64_t>, 2>>();
  (*two)[0].unit = [worked](std::uint64_t, const WorkUnit& unit) { (*worked)[0] += unit.path_count(); };
  (*two)[1].unit = [worked](std::uint64_t n, const WorkUnit& unit) {
    // It keeps its second unit until the other device has repeated that.
    while (n == 1 && (*worked)[0] + (*worked)[1] < kImage.pixel_count() * kSpp)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    (*worked)[1] += unit.path_count();
  };
  const Outcome outcome = run(two, 3600);
  expect_complete(outcome);
  if (outcome.has(1, DeviceEvent::Kind::late)) return;  // the end of the render did not wait for it
  for (std::size_t i = 0; i < 2; ++i) {
    const DeviceReport& device = outcome.devices[i];
    EXPECT_EQ(device.samples + device.repeated_rays.camera, (*worked)[i]) << i;
  }
  EXPECT_GT(outcome.devices[0].repeated_rays.camera + outcome.devices[1].repeated_rays.camera, 0U);
}

TEST(DeviceSessions, watchdog_leaves_slow_devices_alone) {
  // 0.44 s in all, far beyond the watchdog's seconds, but no unit takes 20 times what it should. On
  // a machine so busy that one does, the watchdog is right; one that goes by its own seconds alone
  // would be wrong in every attempt.
  bool left_alone = false;
  for (int attempt = 0; attempt < 20 && !left_alone; ++attempt) {
    auto one = devices(1);
    (*one)[0].path_s = 3e-6;
    left_alone = run(one, 0.05).events.empty();
  }
  EXPECT_TRUE(left_alone);
}

}  // namespace
}  // namespace eikon::test
