// SPDX-License-Identifier: Apache-2.0
#include "core/trace.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <numeric>
#include <thread>

namespace eikon::test {
namespace {

const Trace::Level& level_of(const Trace& trace, Trace::Track track, std::size_t depth = 0) {
  return trace.tracks().at(track).levels.at(depth);
}

double seconds_of(const Trace::Entry& entry) {
  double sum = 0;
  for (const Trace::Part& part : entry.parts) sum += part.seconds;
  return sum;
}

TEST(Trace, keeps_single_spans_as_they_are) {
  Trace trace(4);
  const Trace::Track queue = trace.add_track("queue");
  trace.span(queue, "paths", 1, 2);
  trace.span(queue, "film", 2.5, 3);
  const auto& entries = level_of(trace, queue).entries;
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(trace.names().at(entries[1].parts.at(0).name), "film");
  EXPECT_EQ(entries[1].begin_s, 2.5);
  EXPECT_EQ(entries[1].end_s, 3);
  EXPECT_EQ(entries[1].parts.at(0).count, 1U);
}

TEST(Trace, of_any_length_has_few_entries_and_all_the_time) {
  Trace trace(16, 16);
  constexpr std::uint64_t count = 100'003;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto begin = double(i);
    trace.span(Trace::kMain, i % 3 == 0 ? "film" : "paths", begin, begin + 0.5);
    trace.count("rate", begin, begin + 1, begin);
  }
  const Trace::Level& level = level_of(trace, Trace::kMain);
  EXPECT_LE(level.entries.size(), 16U);
  EXPECT_GE(level.entries.size(), 8U) << "half of it at least, or detail is lost for nothing";
  EXPECT_EQ(level.left_out, 0U);
  double sum = 0, end = -1;
  std::uint64_t spans = 0;
  for (const Trace::Entry& entry : level.entries) {
    EXPECT_GE(entry.begin_s, end);
    EXPECT_GE(entry.end_s - entry.begin_s, seconds_of(entry));
    end = entry.end_s;
    sum += seconds_of(entry);
    for (const Trace::Part& part : entry.parts) spans += part.count;
  }
  EXPECT_EQ(spans, count);
  EXPECT_DOUBLE_EQ(sum, 0.5 * double(count));
  EXPECT_EQ(level.entries.front().begin_s, 0);
  EXPECT_EQ(end, double(count) - 0.5);

  const auto& points = trace.counters().at("rate");
  EXPECT_LE(points.size(), 16U);
  double area = 0;
  for (const Trace::Point& point : points) area += point.value * (point.end_s - point.begin_s);
  EXPECT_NEAR(area, 0.5 * double(count) * double(count - 1), 1e-6 * area) << "means are weighted by time";
}

TEST(Trace, children_of_different_parents_do_not_become_one) {
  Trace trace(4);
  for (int i = 0; i < 40; ++i) {
    const TraceScope outer(&trace, Trace::kMain, "outer");
    for (int k = 0; k < 3; ++k) const TraceScope inner(&trace, Trace::kMain, "inner");
  }
  const Trace::Level &outer = level_of(trace, Trace::kMain, 0), &inner = level_of(trace, Trace::kMain, 1);
  EXPECT_LE(outer.entries.size(), 4U);
  EXPECT_LE(inner.entries.size(), 4U);
  EXPECT_GT(inner.left_out, 0U) << "forty parents, four places";
  for (const Trace::Entry& child : inner.entries) {
    bool within = false;
    for (const Trace::Entry& parent : outer.entries)
      within = within || (parent.begin_s <= child.begin_s && child.end_s <= parent.end_s);
    EXPECT_TRUE(within);
  }
}

TEST(Trace, cuts_off_what_overlaps) {
  Trace trace(4);
  trace.span(Trace::kMain, "a", 1, 2);
  trace.span(Trace::kMain, "b", 1.9, 3);
  trace.span(Trace::kMain, "c", 2.5, 2.8);
  const auto& entries = level_of(trace, Trace::kMain).entries;
  EXPECT_EQ(entries.at(1).begin_s, 2);
  EXPECT_EQ(seconds_of(entries.at(1)), 1);
  EXPECT_EQ(entries.at(2).begin_s, 3);
  EXPECT_EQ(entries.at(2).end_s, 3);
}

TEST(Trace, values_of_one_moment_stay_values_that_were) {
  Trace trace(4, 4);
  for (int i = 0; i < 100; ++i) trace.count("error", i, i, 1.0 / (1 + i));
  for (const Trace::Point& point : trace.counters().at("error")) {
    EXPECT_EQ(point.begin_s, point.end_s);
    EXPECT_EQ(point.value, 1.0 / (1 + point.begin_s));
  }
}

TEST(Trace, takes_spans_of_many_threads) {
  Trace trace(1000);
  std::vector<Trace::Track> tracks(4);
  {
    std::vector<std::jthread> threads;
    for (Trace::Track& track : tracks)
      threads.emplace_back([&] {
        track = trace.add_track("worker");
        for (int i = 0; i < 500; ++i) {
          const TraceScope outer(&trace, track, "outer");
          trace.span(track, "inner", host_seconds(), host_seconds());
          trace.count("shared", host_seconds(), host_seconds(), i);
        }
      });
  }
  for (const Trace::Track track : tracks) {
    EXPECT_EQ(level_of(trace, track, 0).entries.size(), 500U);
    EXPECT_EQ(level_of(trace, track, 1).entries.size(), 500U);
  }
}

TEST(Trace, of_nobody_costs_no_look_at_the_clock) {
  TraceScope scope(nullptr, Trace::kMain, "nothing");
  scope.end();
  scope.end();
}

TEST(Trace, takes_nothing_after_its_end) {
  Trace trace;
  const Trace::Track queue = trace.add_track("queue");
  trace.span(queue, "paths", 1, 2);
  trace.open(queue);
  std::atomic<bool> go_on{true};
  std::thread hung([&] {  // comes back while the timeline is written
    for (double at = 3; go_on; at += 1) {
      trace.close(queue, "wait", at, at + 0.5);
      trace.open(queue);
      trace.span(queue, "film", at, at + 0.5);
      trace.count("rate", at, at + 0.5, 1);
      (void)trace.add_track("late");
    }
  });
  trace.end();
  const std::size_t entries = level_of(trace, queue).entries.size(), counters = trace.counters().size();
  const std::size_t tracks = trace.tracks().size();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(level_of(trace, queue).entries.size(), entries);
  EXPECT_EQ(trace.counters().size(), counters);
  EXPECT_EQ(trace.tracks().size(), tracks);
  EXPECT_EQ(trace.add_track("later"), Trace::kMain);
  go_on = false;
  hung.join();
}

}  // namespace
}  // namespace eikon::test
