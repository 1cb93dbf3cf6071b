// SPDX-License-Identifier: Apache-2.0
// Between two rounds the film holds exactly the samples that the round's end states, and looking at
// it changes nothing.
#include <atomic>
#include <chrono>
#include <thread>

#include "core/clock.h"
#include "core/error.h"
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

struct Seen {
  std::uint64_t done;
  double seconds;
  Film film;
};

/// Rounds that end at these samples, and then the render. each: called before every round and at
/// the end
RenderHooks rounds_to(const std::vector<std::uint64_t>& ends, const std::function<void(const RoundEnd&)>& each) {
  RenderHooks hooks;
  hooks.next_round = [ends, each, next = std::size_t{0}](const RoundEnd& now) mutable {
    each(now);
    return next < ends.size() ? Round{.end = ends[next++]} : Round{.end = now.done};
  };
  return hooks;
}

TEST(Rounds, film_holds_exactly_the_samples_below_and_seconds_grow) {
  auto [scene, settings] = room(40, 24, 9);
  settings.sample_begin = 1;
  settings.sample_end = 10;
  std::vector<Seen> seen;
  const auto see = [&](const RoundEnd& now) {
    EXPECT_TRUE(now.exact);
    seen.push_back({now.done, now.render_s, now.film});
  };
  const std::atomic<bool> stop{false};
  const RenderOutput done = render(scene, settings, as_tested({}), stop, rounds_to({2, 5, 10}, see));
  ASSERT_EQ(seen.size(), 4U);
  EXPECT_EQ(seen[0].done, 1U);
  EXPECT_EQ(seen[0].film.samples(0, 0), 0U);
  for (std::size_t i = 1; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i].done, (std::array<std::uint64_t, 4>{1, 2, 5, 10}[i]));
    EXPECT_GT(seen[i].seconds, seen[i - 1].seconds);
    Settings fewer = settings;
    fewer.sample_end = seen[i].done;
    EXPECT_TRUE(same_film(seen[i].film, render(scene, fewer, as_tested({}), stop).film)) << i;
  }
  EXPECT_TRUE(same_film(seen.back().film, done.film));
  EXPECT_DOUBLE_EQ(seen.back().seconds, done.report.render_s);
  EXPECT_EQ(done.report.end, RenderEnd::all_samples);
}

// Between the end of one call and the begin of the next no more seconds of rendering can have
// passed than seconds of the clock.
TEST(Rounds, time_between_them_is_no_rendering) {
  auto [scene, settings] = room(8, 8, 2);
  std::vector<double> begun, ended, told;
  const auto see = [&](const RoundEnd& now) {
    begun.push_back(host_seconds());
    told.push_back(now.render_s);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    ended.push_back(host_seconds());
  };
  const std::atomic<bool> stop{false};
  const double render_s = render(scene, settings, as_tested({}), stop, rounds_to({1, 2}, see)).report.render_s;
  ASSERT_EQ(told.size(), 3U);
  EXPECT_LE(told[2] - told[1], begun[2] - ended[1]);
  EXPECT_EQ(render_s, told[2]) << "what the last call takes is not counted either";
}

TEST(Rounds, a_round_that_ends_where_it_begins_ends_the_render) {
  auto [scene, settings] = room(16, 16, 1024);
  const std::atomic<bool> stop{false};
  const RenderOutput done = render(scene, settings, as_tested({}), stop, rounds_to({1, 2}, [](const RoundEnd&) {}));
  EXPECT_EQ(done.report.samples, 2U * 16 * 16);
  EXPECT_EQ(done.report.end, RenderEnd::target_error);
  EXPECT_FALSE(done.report.interrupted());
}

TEST(Rounds, stop_set_between_two_interrupts_the_render_there) {
  auto [scene, settings] = room(16, 16, 1024);
  std::atomic<bool> stop{false};
  std::size_t count = 0;
  const auto see = [&](const RoundEnd& now) {
    ++count;
    stop = now.done == 2;
  };
  const RenderOutput done = render(scene, settings, as_tested({}), stop, rounds_to({1, 2, 4, 1024}, see));
  EXPECT_EQ(count, 3U);
  EXPECT_EQ(done.report.samples, 2U * 16 * 16);
  EXPECT_TRUE(done.report.interrupted());
}

TEST(Rounds, the_time_that_was_given_ends_the_render) {
  auto [scene, settings] = room(64, 64, std::uint64_t{1} << 24);
  RenderHooks hooks;
  double latest_s = 0;
  hooks.next_round = [&](const RoundEnd& now) {
    if (now.done == 0) return Round{.end = 1};  // the device is then open
    if (now.done == 1) latest_s = host_seconds() + 0.3;
    return Round{.end = 2 * now.done, .latest_s = latest_s};
  };
  const std::atomic<bool> stop{false};
  const RenderOutput done = render(scene, settings, as_tested({}), stop, std::move(hooks));
  EXPECT_EQ(done.report.end, RenderEnd::time_limit);
  EXPECT_GE(host_seconds(), latest_s);
  EXPECT_GE(done.sample_set.sample_count(), 64U * 64);
}

TEST(Rounds, what_the_callback_throws_ends_the_render) {
  auto [scene, settings] = room(8, 8, 4);
  const auto refuse = [](const RoundEnd& now) {
    if (now.done > 0) throw InputError("seen enough");
  };
  const std::atomic<bool> stop{false};
  EXPECT_THROW(render(scene, settings, as_tested({}), stop, rounds_to({1, 2}, refuse)), InputError);
}

TEST(Rounds, out_of_order_or_beyond_the_samples_are_refused) {
  auto [scene, settings] = room(8, 8, 4);
  const std::atomic<bool> stop{false};
  for (const std::vector<std::uint64_t>& ends : {std::vector<std::uint64_t>{3, 1}, {5}})
    EXPECT_THROW(render(scene, settings, as_tested({}), stop, rounds_to(ends, [](const RoundEnd&) {})), InternalError);
}

// A film that a render goes on from may have more samples in some pixels: the first round is told
// so.
TEST(Rounds, go_on_after_the_samples_that_every_pixel_has) {
  auto [scene, settings] = room(16, 16, 4);
  const std::atomic<bool> stop{false};
  const RenderOutput whole = render(scene, settings, as_tested({}), stop);
  Settings some = settings, corner = settings;
  some.sample_end = 2;
  corner.sample_begin = 2;
  corner.crop = {0, 0, 4, 4};
  RenderHooks on;
  on.begin_with = static_cast<FilmState>(render(scene, some, as_tested({}), stop));
  const RenderOutput further = render(scene, corner, as_tested({}), stop);
  on.begin_with->film.add(further.film);
  on.begin_with->sample_set.add(further.sample_set);
  std::vector<std::pair<std::uint64_t, bool>> seen;
  RenderHooks hooks = rounds_to({3, 4}, [&](const RoundEnd& now) { seen.emplace_back(now.done, now.exact); });
  hooks.begin_with = std::move(on.begin_with);
  const RenderOutput done = render(scene, settings, as_tested({}), stop, std::move(hooks));
  EXPECT_EQ(seen, (std::vector<std::pair<std::uint64_t, bool>>{{2, false}, {3, true}, {4, true}}));
  EXPECT_TRUE(same_film(done.film, whole.film));
}

}  // namespace
}  // namespace eikon::test
