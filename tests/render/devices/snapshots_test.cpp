// SPDX-License-Identifier: Apache-2.0
// Snapshots of a film on the way hold exactly the samples that they state, and taking them changes nothing.
#include <atomic>
#include <chrono>
#include <thread>

#include "core/clock.h"
#include "core/error.h"
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

struct Seen {
  std::uint64_t sample_end;
  double seconds;
  Film film;
};

TEST(Snapshots, film_holds_exactly_the_samples_below_and_seconds_grow) {
  auto [scene, settings] = room(40, 24, 9);
  settings.sample_begin = 1;
  settings.sample_end = 10;
  std::vector<Seen> seen;
  Snapshots snapshots;
  snapshots.at = {2, 5, 10};
  snapshots.take = [&](std::uint64_t end, double seconds, const Film& film) { seen.push_back({end, seconds, film}); };
  const std::atomic<bool> stop{false};
  const RenderOutput done = render(scene, settings, as_tested({}), stop, {.snapshots = snapshots});
  ASSERT_EQ(seen.size(), 3U);
  double before = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i].sample_end, snapshots.at[i]);
    EXPECT_GT(seen[i].seconds, before);
    before = seen[i].seconds;
    Settings fewer = settings;
    fewer.sample_end = snapshots.at[i];
    EXPECT_TRUE(same_film(seen[i].film, render(scene, fewer, as_tested({}), stop).film)) << i;
  }
  EXPECT_TRUE(same_film(seen.back().film, done.film));
  EXPECT_DOUBLE_EQ(seen.back().seconds, done.report.render_s);
  EXPECT_FALSE(done.report.interrupted);
}

// Between the end of one snapshot and the begin of the next no more seconds of rendering can have passed than seconds of the clock.
TEST(Snapshots, time_that_a_snapshot_takes_is_no_rendering) {
  auto [scene, settings] = room(8, 8, 2);
  std::vector<double> begun, ended, told;
  Snapshots snapshots;
  snapshots.at = {1, 2};
  snapshots.take = [&](std::uint64_t, double seconds, const Film&) {
    begun.push_back(host_seconds());
    told.push_back(seconds);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    ended.push_back(host_seconds());
  };
  const std::atomic<bool> stop{false};
  const double render_s = render(scene, settings, as_tested({}), stop, {.snapshots = snapshots}).report.render_s;
  ASSERT_EQ(told.size(), 2U);
  EXPECT_LE(told[1] - told[0], begun[1] - ended[0]);
  EXPECT_EQ(render_s, told[1]) << "what the last snapshot takes is not counted either";
}

TEST(Snapshots, stop_set_by_a_snapshot_ends_the_render_there) {
  auto [scene, settings] = room(16, 16, 1024);
  std::atomic<bool> stop{false};
  std::size_t count = 0;
  Snapshots snapshots;
  snapshots.at = {1, 2, 4, 1024};
  snapshots.take = [&](std::uint64_t end, double, const Film&) {
    ++count;
    stop = end == 2;
  };
  const RenderOutput done = render(scene, settings, as_tested({}), stop, {.snapshots = snapshots});
  EXPECT_EQ(count, 2U);
  EXPECT_EQ(done.report.samples, 2U * 16 * 16);
  EXPECT_TRUE(done.report.interrupted);
}

TEST(Snapshots, a_snapshot_that_throws_ends_the_render_with_its_error) {
  auto [scene, settings] = room(8, 8, 4);
  Snapshots snapshots;
  snapshots.at = {1, 2};
  snapshots.take = [](std::uint64_t, double, const Film&) { throw InputError("seen enough"); };
  const std::atomic<bool> stop{false};
  EXPECT_THROW(render(scene, settings, as_tested({}), stop, {.snapshots = snapshots}), InputError);
}

TEST(Snapshots, out_of_order_or_beyond_the_samples_are_refused) {
  auto [scene, settings] = room(8, 8, 4);
  const std::atomic<bool> stop{false};
  for (const std::vector<std::uint64_t>& at : {std::vector<std::uint64_t>{2, 2}, {3, 1}, {0}, {5}}) {
    Snapshots snapshots;
    snapshots.at = at;
    snapshots.take = [](std::uint64_t, double, const Film&) {};
    EXPECT_THROW(render(scene, settings, as_tested({}), stop, {.snapshots = snapshots}), InternalError);
  }
}

}  // namespace
}  // namespace eikon::test
