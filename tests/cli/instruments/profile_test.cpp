// SPDX-License-Identifier: Apache-2.0
// --profile and --stats of real renders: a reader of trace events and the schema of the statistics.
#include "cli/command.h"
#include "cli/instruments/json_schema.h"
#include "support/paths.h"

#include <map>
#include <nlohmann/json.hpp>

namespace eikon::test {
namespace {

using nlohmann::json;

struct Span {
  std::string name;
  double begin_us = 0, end_us = 0, busy_us = 0;
  int depth = 0;
};

/// What a viewer makes of trace events.
struct Timeline {
  std::map<int, std::string> names;         // of tracks
  std::map<int, std::vector<Span>> tracks;  // by begin
  std::map<std::string, std::vector<std::pair<double, double>>> counters;

  [[nodiscard]] const std::vector<Span>& track(const std::string& part) const {
    for (const auto& [id, name] : names)
      if (contains(name, part)) return tracks.at(id);
    throw std::runtime_error("no track " + part);
  }
};

constexpr double kRound_us = 1e-3;  // ends are sums of rounded numbers

/// Reads and checks: known kinds of events, named tracks, spans that nest or follow each other,
/// counters in the order of time.
Timeline read_timeline(const json& file) {
  Timeline timeline;
  for (const json& event : file.at("traceEvents")) {
    const std::string kind = event.at("ph");
    EXPECT_EQ(event.at("pid"), 1);
    if (kind == "M") {
      if (event.at("name") == "thread_name") timeline.names[event.at("tid")] = event.at("args").at("name");
      continue;
    }
    const double at = event.at("ts");
    EXPECT_GE(at, 0);
    if (kind == "C") {
      const double value = event.at("args").at("value");
      EXPECT_GE(value, 0) << event;
      auto& points = timeline.counters[event.at("name")];
      EXPECT_GE(at, points.empty() ? 0.0 : points.back().first) << event;
      points.emplace_back(at, value);
      continue;
    }
    EXPECT_EQ(kind, "X") << event;
    const double duration = event.at("dur");
    EXPECT_GE(duration, 0) << event;
    const double busy = event.contains("args") ? 1e3 * event.at("args").at("busy_ms").get<double>() : duration;
    EXPECT_LE(busy, duration + kRound_us) << event;
    EXPECT_FALSE(event.at("name").get<std::string>().empty());
    timeline.tracks[event.at("tid")].push_back({event.at("name"), at, at + duration, busy});
  }
  for (auto& [id, spans] : timeline.tracks) {
    EXPECT_EQ(timeline.names.count(id), 1U) << "track " << id << " has no name";
    std::ranges::stable_sort(spans, [](const Span& a, const Span& b) {
      return a.begin_us != b.begin_us ? a.begin_us < b.begin_us : a.end_us > b.end_us;
    });
    std::vector<double> open;
    for (Span& span : spans) {
      while (!open.empty() && open.back() <= span.begin_us + kRound_us) open.pop_back();
      EXPECT_LE(span.end_us, open.empty() ? span.end_us : open.back() + kRound_us) << span.name << " leaves its parent";
      span.depth = int(open.size());
      open.push_back(span.end_us);
    }
  }
  return timeline;
}

double seconds_of(const std::vector<Span>& spans, const std::string& name, double from_us = 0) {
  double sum = 0;
  for (const Span& span : spans)
    if ((name.empty() || span.name == name) && span.begin_us >= from_us) sum += 1e-6 * span.busy_us;
  return sum;
}

/// The part of the time from the first span to the last one that outermost spans cover.
double coverage(const std::vector<Span>& spans) {
  double covered_us = 0, end_us = 0;
  for (const Span& span : spans) {
    if (span.depth == 0) covered_us += span.end_us - span.begin_us;
    end_us = std::max(end_us, span.end_us);
  }
  return covered_us / (end_us - spans.front().begin_us);
}

// Structure and sums are judged: the steps are all there, in their order, and agree with the
// seconds of the statistics as far as one reading of the clock encloses the other.
void expect_timeline_of(const Timeline& timeline, const json& stats, std::size_t device) {
  const json& seconds = stats.at("seconds");
  const std::vector<Span>& main = timeline.track("main");
  std::vector<std::string> steps;
  for (const Span& span : main)
    if (span.depth == 0) steps.push_back(span.name);
  EXPECT_EQ(steps, (std::vector<std::string>{"load", "find devices", "pack", "choose layout, build tree", "pilot", "render",
                                             "predict error", "write"}));
  constexpr double kRound_s = 2e-6 * kRound_us;
  EXPECT_GE(seconds_of(main, "load") + kRound_s, seconds.at("load").get<double>()) << "the span holds the reading";
  EXPECT_LE(seconds_of(main, "write"), seconds.at("write").get<double>() + kRound_s) << "the statistics hold the span";

  const json& told = stats.at("devices").at(device);
  const std::string prefix = "device " + told.at("selector").get<std::string>() + ": ";
  const std::vector<Span>& thread = timeline.track(prefix + "host");
  for (const char* step : {"open", "compile", "upload", "warm up", "render", "begin unit", "wait", "add to film"})
    EXPECT_GT(seconds_of(thread, step), 0) << step;
  EXPECT_GE(seconds_of(main, "render") + kRound_s, told.at("seconds").get<double>());
  std::map<std::string, std::size_t> during_render;
  for (const Span& span : thread)
    if (span.depth == 1) ++during_render[span.name];
  for (const char* step : {"begin unit", "wait", "add to film"})
    EXPECT_EQ(during_render[step], told.at("units").get<std::size_t>())
        << step << ": what the host's thread did for each unit while the device rendered";

  // The queue: every launch and transfer of the table, and nothing else.
  const std::vector<Span>& queue = timeline.track(prefix + "queue");
  double begin_us = 0;
  for (const Span& span : thread)
    if (span.name == "render") begin_us = span.begin_us;
  double stages_s = 0;
  for (const json& stage : stats.at("stages"))
    if (stage.at("device") == device) stages_s += stage.at("seconds").get<double>();
  EXPECT_NEAR(seconds_of(queue, "", begin_us), stages_s, 0.01 * stages_s + 1e-3);
  for (const Span& span : queue) EXPECT_EQ(span.depth, 0);
}

TEST(Profile, shows_where_the_wall_time_of_the_statistics_went) {
  const Workplace here;
  ASSERT_TRUE(succeeded(
      here.eikon(cornell("--size 128x128 --spp 128 --quiet --profile trace.json --stats stats.json --devices cpu"))));
  const Timeline timeline = read_timeline(read_json(here / "trace.json"));
  expect_timeline_of(timeline, read_json(here / "stats.json"), 0);
  for (const char* counter : {"Mrays/s, device 0", "live paths, device 0", "predicted relMSE"})
    ASSERT_EQ(timeline.counters.count(counter), 1U) << counter;
  EXPECT_DOUBLE_EQ(timeline.counters.at("predicted relMSE").back().second,
                   read_json(here / "stats.json").at("relmse_predicted").get<double>());
}

// Another process may take the processor between two spans, so the best of several renders counts:
// time that no span covers is missing in all of them.
TEST(Profile, spans_cover_nine_tenths_of_the_time) {
  double main = 0, device = 0;
  for (int attempt = 0; attempt < 5 && (main < 0.9 || device < 0.9); ++attempt) {
    const Workplace here;
    ASSERT_TRUE(succeeded(
        here.eikon(cornell("--size 128x128 --spp 128 --quiet --profile trace.json --stats stats.json --devices cpu"))));
    const Timeline timeline = read_timeline(read_json(here / "trace.json"));
    main = std::max(main, coverage(timeline.track("main")));
    double render_s = 0, steps_s = 0;
    for (const Span& span : timeline.track(": host")) {
      if (span.name == "render") render_s += 1e-6 * span.busy_us;
      for (const char* step : {"begin unit", "launch", "wait", "add to film"})
        if (span.name == step) steps_s += 1e-6 * span.busy_us;
    }
    device = std::max(device, steps_s / render_s);
  }
  EXPECT_GE(main, 0.9) << "of the render's thread";
  EXPECT_GE(device, 0.9) << "of what the device's thread did while the device rendered";
}

TEST(Profile, has_tracks_of_each_of_two_devices) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(
      cornell("--size 128x128 --spp 64 --quiet --profile trace.json --stats stats.json --devices cpu:2x1"))));
  const json stats = read_json(here / "stats.json");
  ASSERT_EQ(stats.at("devices").size(), 2U);
  const Timeline timeline = read_timeline(read_json(here / "trace.json"));
  std::uint64_t samples = 0;
  for (const json& device : stats.at("devices")) {
    samples += device.at("samples").get<std::uint64_t>();
    const std::string prefix = "device " + device.at("selector").get<std::string>() + ": ";
    EXPECT_FALSE(timeline.track(prefix + "queue").empty());
    EXPECT_FALSE(timeline.track(prefix + "host").empty());
  }
  EXPECT_EQ(samples, stats.at("samples").get<std::uint64_t>());
}

TEST(Stats, are_as_their_schema_says) {
  const Workplace here;
  const JsonSchema schema(read_json(std::string(EIKON_SOURCE_DIR) + "/host/job/report/stats_schema.json"));
  for (const char* flags : {"--size 32x24 --spp 16 --devices cpu", "--size 32x24 --spp 1",
                            "--size 8x8 --spp 4 --devices cpu:2x1", "--size 32x24 --spp 4 --layout probe"}) {
    ASSERT_TRUE(succeeded(here.eikon(cornell(std::string(flags) + " --quiet --stats stats.json")))) << flags;
    for (const std::string& error : schema.errors(read_json(here / "stats.json")))
      ADD_FAILURE() << flags << ": " << error;
  }
  json damaged = read_json(here / "stats.json");
  damaged.erase("seed");
  damaged["samples"] = -1;
  damaged["devices"][0]["name"] = 7;
  damaged["stages"][0]["unheard_of"] = true;
  EXPECT_EQ(schema.errors(damaged).size(), 4U) << "the test sees what is wrong";
}

TEST(StageTable, tells_each_device_its_stages_bounces_and_gaps) {
  const Workplace here;
  const Outcome one = here.eikon(cornell("--size 64x48 --spp 16 --devices cpu"));
  ASSERT_TRUE(succeeded(one));
  for (const char* part : {"stage ", "launches", "ms mean", "Mitems/s", "intersect", "in paths", "read back", "gaps",
                           "bounce ", "paths, %", "lanes full, %", "chunks full, %", "setup: open ", "seconds: load"})
    EXPECT_TRUE(contains(one.out, part)) << part << " is not in\n" << one.out;
  EXPECT_FALSE(contains(one.out, "idle at end"));
  const Outcome two = here.eikon(cornell("--size 64x48 --spp 16 --devices cpu:2x1"));
  ASSERT_TRUE(succeeded(two));
  EXPECT_TRUE(contains(two.out, "idle at end"));
}

}  // namespace
}  // namespace eikon::test
