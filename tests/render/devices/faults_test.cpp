// SPDX-License-Identifier: Apache-2.0
// Several devices on one image, some of which fail: the film has the bits of one device that works.
#include <chrono>
#include <cstdlib>

#include "core/error.h"
#include "core/lost_threads.h"
#include "render/scene_builder.h"
#include "support/messages.h"

namespace eikon::test {
namespace {

class Faults : public ::testing::Test {
 protected:
  Faults() {
    execution.unit_paths = 1U << 12;  // many units
    execution.block = 32;
    execution.watchdog_s = 60;  // a machine with other work to do may keep a unit waiting for seconds
    plan(kNone);
    for (const DeviceInfo& info : list_devices())
      if (info.cpu && info.divisible && info.unusable.empty() && info.compute_units >= 2) pair = info.selector;
  }
  ~Faults() override { plan(kNone); }
  void SetUp() override {
    if (pair.empty()) GTEST_SKIP() << "no CPU device that can be divided";
  }

  Film undisturbed() {
    Execution one = execution;
    one.devices = pair;
    return film_of(scene, settings, one);
  }
  RenderOutput with(const std::string& fault, RenderHooks hooks = {}, const std::string& parts = ":2x1") {
    plan(fault);
    execution.devices = pair + parts;
    const ::testing::ScopedTrace of(__FILE__, __LINE__, fault);
    try {
      RenderOutput output = render(scene, settings, as_tested(execution), stop, std::move(hooks));
      plan(kNone);
      return output;
    } catch (const DeviceError& error) {
      if (!may_throw) ADD_FAILURE() << "with EIKON_FAULT=" << fault << ": " << error.what();
      throw;
    }
  }
  // The variable is replaced, never taken away: threads that were given up may be reading the
  // environment.
  static void plan(const std::string& fault) { setenv("EIKON_FAULT", fault.c_str(), 1); }
  static constexpr const char* kNone = "device:0:slow=1";
  static bool has(const RenderReport& report, std::size_t device, DeviceEvent::Kind kind) {
    return std::any_of(report.events.begin(), report.events.end(),
                       [&](const DeviceEvent& e) { return e.device == device && e.kind == kind; });
  }

  std::pair<Scene, Settings> both = room(120, 90, 32);
  const Scene& scene = both.first;
  Settings& settings = both.second;
  Execution execution;
  std::string pair;  // of the device that is divided
  std::atomic<bool> stop{false};
  bool may_throw = false;  // else what a render throws is a failure, of which the fault is said
};

TEST_F(Faults, N5_devices_of_unequal_speed_make_the_same_film) {
  const Film expected = undisturbed();
  for (const char* fault : {"device:1:slow=1", "device:1:slow=10", "device:0:slow=3", "device:1:slow=1000"}) {
    const RenderOutput output = with(fault);
    EXPECT_TRUE(same_film(expected, output.film)) << fault;
    EXPECT_FALSE(output.report.interrupted());
  }
  const RenderOutput output = with("device:1:slow=10");
  EXPECT_GT(output.report.devices[0].units, 0U);
}

TEST_F(Faults, a_device_with_memory_of_its_own_makes_the_same_film) {
  const Film expected = undisturbed();
  for (const char* fault : {"device:0:gpu", "device:0:gpu;device:1:gpu", "device:0:gpu;device:0:slow=5",
                            "device:1:gpu;device:1:after=2:times=1", "device:1:gpu;device:1:lost:after=3"}) {
    const RenderOutput output = with(fault);
    EXPECT_TRUE(same_film(expected, output.film)) << fault;
    EXPECT_FALSE(output.report.interrupted()) << fault;
  }
}

TEST_F(Faults, any_fault_at_any_moment_leaves_the_same_film) {
  const Film expected = undisturbed();
  for (const char* kind : {"error", "oom", "lost"})
    for (const char* when : {"", "after=1:", "after=2:", "after=6:", "after=1:times=1:", "after=3:times=2:"}) {
      const std::string fault = std::string("device:1:") + when + kind;
      const RenderOutput output = with(fault);
      EXPECT_TRUE(same_film(expected, output.film)) << fault;
      EXPECT_FALSE(output.report.interrupted()) << fault;
      EXPECT_EQ(output.report.samples, 120U * 90U * 32U) << fault;
      EXPECT_FALSE(has(output.report, 0, DeviceEvent::Kind::failed)) << fault;
    }
}

TEST_F(Faults, both_devices_may_fail_now_and_then) {
  const Film expected = undisturbed();
  const RenderOutput output = with("device:0:after=1:times=1;device:1:after=2:times=2;device:0:after=9:times=1");
  EXPECT_TRUE(same_film(expected, output.film));
  EXPECT_TRUE(has(output.report, 0, DeviceEvent::Kind::failed));
}

TEST_F(Faults, units_become_smaller_where_large_ones_fail) {
  const Film expected = undisturbed();
  execution.unit_paths = 1U << 14;
  const RenderOutput output = with("device:0:above=2000;device:1:above=2000:after=1");
  EXPECT_TRUE(same_film(expected, output.film));
}

TEST_F(Faults, a_device_that_hangs_is_given_up) {
  const Film expected = undisturbed();
  execution.watchdog_s = 2;
  // The other one is slow, or it would be done before this one has begun.
  for (const char* fault : {"device:0:slow=20;device:1:hang", "device:0:slow=20;device:1:hang:after=3"}) {
    const RenderOutput output = with(fault);
    EXPECT_TRUE(same_film(expected, output.film)) << fault;
    EXPECT_LE(output.report.devices[1].units, 3U) << fault;  // or the render was over before
  }
  EXPECT_GT(lost_threads(), 0);
}

TEST_F(Faults, when_no_device_is_left_what_is_done_is_handed_out) {
  const Film expected = undisturbed();
  std::optional<FilmState> last;
  RenderHooks hooks;
  hooks.checkpoint = [&](const FilmState& state) { last = state; };
  execution.watchdog_s = 2;
  may_throw = true;
  const std::string message =
      message_of<DeviceError>([&] { (void)with("device:0:after=3;device:1:after=2:hang", hooks); });
  EXPECT_TRUE(contains(message, "no device is left"));
  EXPECT_TRUE(contains(message, "CL_OUT_OF_RESOURCES"));
  ASSERT_TRUE(last);
  EXPECT_GT(last->sample_set.sample_count(), 0U);
  // And it goes on from there.
  RenderHooks go_on;
  go_on.begin_with = last;
  EXPECT_TRUE(same_film(expected, with("device:1:slow=2", go_on).film));
}

TEST_F(Faults, none_that_can_be_opened_says_why) {
  may_throw = true;
  const std::string message = message_of<DeviceError>([&] { (void)with("device:0:lost;device:1:oom"); });
  EXPECT_TRUE(contains(message, "CL_DEVICE_NOT_AVAILABLE"));
  EXPECT_TRUE(contains(message, "CL_MEM_OBJECT_ALLOCATION_FAILURE"));
}

TEST_F(Faults, a_fault_during_checkpoints_changes_none_of_them) {
  const Film expected = undisturbed();
  std::vector<FilmState> states;
  RenderHooks hooks;
  hooks.checkpoint = [&](const FilmState& state) { states.push_back(state); };
  hooks.checkpoint_every_s = 0;
  EXPECT_TRUE(same_film(expected, with("device:1:after=2:times=1;device:0:after=4:times=1", hooks).film));
  ASSERT_FALSE(states.empty());
  EXPECT_TRUE(same_film(expected, states.back().film));
  RenderHooks go_on;
  go_on.begin_with = states.front();
  EXPECT_TRUE(same_film(expected, with("device:1:after=1", go_on).film));
}

TEST_F(Faults, rounds_hold_exactly_their_samples) {
  RenderHooks hooks;
  const std::vector<std::uint64_t> at = {2, 9, 32};
  std::vector<Film> seen;
  hooks.next_round = [&, next = std::size_t{0}](const RoundEnd& now) mutable {
    if (next > 0) seen.push_back(now.film);
    return Round{.end = next < at.size() ? at[next++] : now.done};
  };
  (void)with("device:1:after=2:times=1", hooks);
  ASSERT_EQ(seen.size(), 3U);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    settings.sample_end = at[i];
    EXPECT_TRUE(same_film(seen[i], undisturbed())) << i;
  }
}

TEST_F(Faults, an_interrupted_render_goes_on_elsewhere) {
  const Film expected = undisturbed();
  RenderHooks hooks;
  hooks.next_round = [&](const RoundEnd& now) {
    stop = now.done == 7;
    return Round{.end = now.done == 0 ? 7U : settings.sample_end};
  };
  const RenderOutput part = with("device:1:after=1:times=1", hooks);
  EXPECT_TRUE(part.report.interrupted());
  stop = false;
  RenderHooks go_on;
  go_on.begin_with = FilmState{part.film, part.sample_set, part.arithmetic};
  EXPECT_TRUE(same_film(expected, with("device:0:slow=5", go_on).film));
}

}  // namespace
}  // namespace eikon::test
