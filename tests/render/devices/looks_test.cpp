// SPDX-License-Identifier: Apache-2.0
// A film that is looked at on the way: what it holds then, and that looking changes nothing.
#include <atomic>
#include <chrono>
#include <thread>

#include "core/clock.h"
#include "core/error.h"
#include "render/scene_builder.h"

namespace eikon::testing {
namespace {

struct Seen {
  std::uint64_t sample_end;
  double seconds;
  Film film;
};

TEST(Looks, film_holds_exactly_the_samples_below_and_seconds_grow) {
  auto [scene, settings] = room(40, 24, 9);
  settings.sample_begin = 1;
  settings.sample_end = 10;
  std::vector<Seen> seen;
  Looks looks;
  looks.at = {2, 5, 10};
  looks.look = [&](std::uint64_t end, double seconds, const Film& film) { seen.push_back({end, seconds, film}); };
  const std::atomic<bool> stop{false};
  const RenderOutput done = render(scene, settings, as_tested({}), stop, {.looks = looks});
  ASSERT_EQ(seen.size(), 3U);
  double before = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i].sample_end, looks.at[i]);
    EXPECT_GT(seen[i].seconds, before);
    before = seen[i].seconds;
    Settings fewer = settings;
    fewer.sample_end = looks.at[i];
    EXPECT_TRUE(same_film(seen[i].film, render(scene, fewer, as_tested({}), stop).film)) << i;
  }
  EXPECT_TRUE(same_film(seen.back().film, done.film));
  EXPECT_DOUBLE_EQ(seen.back().seconds, done.report.render_s);
  EXPECT_FALSE(done.report.interrupted);
}

// Between the end of one look and the begin of the next no more seconds of rendering can have passed than seconds of the clock.
TEST(Looks, time_that_a_look_takes_is_no_rendering) {
  auto [scene, settings] = room(8, 8, 2);
  std::vector<double> begun, ended, told;
  Looks looks;
  looks.at = {1, 2};
  looks.look = [&](std::uint64_t, double seconds, const Film&) {
    begun.push_back(host_seconds());
    told.push_back(seconds);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    ended.push_back(host_seconds());
  };
  const std::atomic<bool> stop{false};
  const double render_s = render(scene, settings, as_tested({}), stop, {.looks = looks}).report.render_s;
  ASSERT_EQ(told.size(), 2U);
  EXPECT_LE(told[1] - told[0], begun[1] - ended[0]);
  EXPECT_EQ(render_s, told[1]) << "what the last look takes is not counted either";
}

TEST(Looks, stop_set_by_a_look_ends_the_render_there) {
  auto [scene, settings] = room(16, 16, 1024);
  std::atomic<bool> stop{false};
  std::size_t count = 0;
  Looks looks;
  looks.at = {1, 2, 4, 1024};
  looks.look = [&](std::uint64_t end, double, const Film&) {
    ++count;
    stop = end == 2;
  };
  const RenderOutput done = render(scene, settings, as_tested({}), stop, {.looks = looks});
  EXPECT_EQ(count, 2U);
  EXPECT_EQ(done.report.samples, 2U * 16 * 16);
  EXPECT_TRUE(done.report.interrupted);
}

TEST(Looks, a_look_that_throws_ends_the_render_with_its_error) {
  auto [scene, settings] = room(8, 8, 4);
  Looks looks;
  looks.at = {1, 2};
  looks.look = [](std::uint64_t, double, const Film&) { throw InputError("seen enough"); };
  const std::atomic<bool> stop{false};
  EXPECT_THROW(render(scene, settings, as_tested({}), stop, {.looks = looks}), InputError);
}

TEST(Looks, out_of_order_or_beyond_the_samples_are_refused) {
  auto [scene, settings] = room(8, 8, 4);
  const std::atomic<bool> stop{false};
  for (const std::vector<std::uint64_t>& at : {std::vector<std::uint64_t>{2, 2}, {3, 1}, {0}, {5}}) {
    Looks looks;
    looks.at = at;
    looks.look = [](std::uint64_t, double, const Film&) {};
    EXPECT_THROW(render(scene, settings, as_tested({}), stop, {.looks = looks}), InternalError);
  }
}

}  // namespace
}  // namespace eikon::testing
