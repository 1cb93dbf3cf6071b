// SPDX-License-Identifier: Apache-2.0
// A render that goes on from what another has done ends with the bits of one that was never
// interrupted.
#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "core/clock.h"
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

class Resume : public ::testing::Test {
 protected:
  Resume() {
    execution.unit_paths = 1U << 12;  // several units
    execution.block = 32;
  }
  std::pair<Scene, Settings> both = room(80, 60, 24);
  const Scene& scene = both.first;
  Settings& settings = both.second;
  Execution execution;
  std::atomic<bool> stop{false};
};

TEST_F(Resume, from_any_state_the_result_is_the_same) {
  const RenderOutput whole = render(scene, settings, as_tested(execution), stop);
  EXPECT_EQ(whole.sample_set.sample_count(), 80U * 60U * 24U);
  std::vector<FilmState> states;
  RenderHooks hooks;
  hooks.checkpoint = [&](const FilmState& state) { states.push_back(state); };
  hooks.checkpoint_every_s = 0;
  render(scene, settings, as_tested(execution), stop, hooks);
  ASSERT_FALSE(states.empty());
  EXPECT_TRUE(same_film(states.back().film, whole.film));
  EXPECT_TRUE(states.back().sample_set == whole.sample_set);

  // A state of our own making: samples 4 to 9 of a window.
  Settings window = settings;
  window.sample_begin = 4;
  window.sample_end = 9;
  FilmState begun{Film(whole.film.layout()), SampleSet()};
  window.crop = {16, 8, 50, 41};
  const RenderOutput part = render(scene, window, as_tested(execution), stop);
  begun.film.add(part.film);
  begun.sample_set.add(part.sample_set);
  begun.arithmetic = {"other-12345678"};
  states.push_back(begun);
  for (const FilmState& state : states) {
    RenderHooks go_on;
    go_on.begin_with = state;
    const RenderOutput done = render(scene, settings, as_tested(execution), stop, go_on);
    EXPECT_TRUE(same_film(done.film, whole.film));
    EXPECT_TRUE(done.sample_set == whole.sample_set);
    EXPECT_EQ(done.report.samples_before, state.sample_set.sample_count());
    EXPECT_TRUE(std::includes(done.arithmetic.begin(), done.arithmetic.end(), state.arithmetic.begin(),
                              state.arithmetic.end()));
    EXPECT_EQ(done.report.samples, whole.sample_set.sample_count() - state.sample_set.sample_count());
    EXPECT_FALSE(done.report.interrupted());
  }
}

TEST_F(Resume, what_a_kill_would_lose_is_no_older_than_an_interval) {
  constexpr double kEvery_s = 0.6, kWriting_s = 0.15;
  settings.sample_end = 1U << 30;
  std::vector<double> begun, written;
  RenderHooks hooks;
  hooks.checkpoint_every_s = kEvery_s;
  hooks.checkpoint = [&](const FilmState&) {
    begun.push_back(host_seconds());
    std::this_thread::sleep_for(std::chrono::duration<double>(kWriting_s));
    written.push_back(host_seconds());
    // How old the newest of the files that are there has become: an interval, and the time between
    // two looks at the clock. It is 0.9 s or more, whatever the machine, if each comes an interval
    // after the one before was written. A busy machine disturbs it, so of many one has to be in
    // time.
    const std::size_t last = begun.size() - 1;
    const double oldest_s = last > 0 ? written[last] - begun[last - 1] : 0;
    stop = (oldest_s > kEvery_s - 0.05 && oldest_s < kEvery_s + kWriting_s) || last >= 100;
  };
  render(scene, settings, as_tested(execution), stop, hooks);
  EXPECT_LT(written.size(), 100U);
}

TEST_F(Resume, a_hook_that_throws_ends_the_render) {
  RenderHooks hooks;
  hooks.checkpoint = [](const FilmState&) { throw std::runtime_error("no space"); };
  hooks.checkpoint_every_s = 0;
  EXPECT_THROW(render(scene, settings, as_tested(execution), stop, hooks), std::runtime_error);
}

}  // namespace
}  // namespace eikon::test
