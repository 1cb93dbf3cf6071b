// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/json_dump.h"
#include "job/report/trace_file.h"

namespace eikon {
namespace {

using nlohmann::json;

/// Writes one event per line as they come, since the file is far larger than the trace that it is
/// made from.
class EventFile {
 public:
  explicit EventFile(const std::filesystem::path& path) : file_(path) {
    write("{\"displayTimeUnit\": \"ms\", \"traceEvents\": [");
  }
  void operator()(const json& event) {
    write((first_ ? "\n" : ",\n") + dump_json(event));
    first_ = false;
  }
  void commit() {
    write("\n]}\n");
    file_.commit();
  }

 private:
  AtomicFile file_;
  bool first_ = true;
  void write(const std::string& text) { file_.write(text.data(), text.size()); }
};

double microseconds(double seconds) { return 1e6 * seconds; }

json metadata(const char* what, std::size_t track, json args) {
  return {{"ph", "M"}, {"pid", 1}, {"tid", track}, {"name", what}, {"args", std::move(args)}};
}

json span(const Trace& trace, std::size_t track, const Trace::Entry& entry) {
  const auto most = std::ranges::max_element(entry.parts, {}, &Trace::Part::seconds);
  json event = {{"ph", "X"},
                {"pid", 1},
                {"tid", track},
                {"name", trace.names()[most->name]},
                {"ts", microseconds(entry.begin_s)},
                {"dur", microseconds(entry.end_s - entry.begin_s)}};
  if (entry.parts.size() == 1 && most->count == 1) return event;
  std::uint64_t spans = 0;
  double busy_s = 0;
  json ms = json::object();
  for (const Trace::Part& part : entry.parts) {
    spans += part.count;
    busy_s += part.seconds;
    ms[trace.names()[part.name]] = 1e3 * part.seconds;
  }
  event["args"] = {{"spans", spans}, {"busy_ms", 1e3 * busy_s}, {"ms", std::move(ms)}};
  return event;
}

json counter(const std::string& name, double at_s, double value) {
  return {{"ph", "C"}, {"pid", 1}, {"name", name}, {"ts", microseconds(at_s)}, {"args", {{"value", value}}}};
}

/// Takes one event after the other.
using TakeEvent = std::function<void(const json&)>;

void add_track(const TakeEvent& take, const Trace& trace, std::size_t track) {
  const Trace::TrackRecord& record = trace.tracks()[track];
  take(metadata("thread_name", track, {{"name", record.name}}));
  take(metadata("thread_sort_index", track, {{"sort_index", track}}));
  for (std::size_t depth = 0; depth < record.levels.size(); ++depth) {
    const Trace::Level& level = record.levels[depth];
    if (level.grain > 1 || level.left_out > 0)
      take(metadata("left_out", track,
                        {{"note", fmt::format("'{}', depth {}: up to {} spans are drawn as one, {} are left out",
                                              record.name, depth, level.grain, level.left_out)}}));
    for (const Trace::Entry& entry : level.entries) take(span(trace, track, entry));
  }
}

void add_counter(const TakeEvent& take, const std::string& name, const std::vector<Trace::Point>& points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    take(counter(name, points[i].begin_s, points[i].value));
    if (points[i].end_s == points[i].begin_s) continue;  // a single moment
    const bool ends = i + 1 == points.size() || points[i].end_s < points[i + 1].begin_s;
    if (ends) take(counter(name, points[i].end_s, 0));
  }
}

void for_each_event(const Trace& trace, const TakeEvent& take) {
  take(metadata("process_name", 0, {{"name", "eikon"}}));
  for (std::size_t track = 0; track < trace.tracks().size(); ++track) add_track(take, trace, track);
  for (const auto& [name, points] : trace.counters()) add_counter(take, name, points);
}

}  // namespace

void write_trace(const std::filesystem::path& path, const Trace& trace) {
  EventFile file(path);
  for_each_event(trace, std::ref(file));
  file.commit();
}

json trace_events(const Trace& trace) {
  json events = json::array();
  for_each_event(trace, [&](const json& event) { events.push_back(event); });
  return events;
}

}  // namespace eikon
