// SPDX-License-Identifier: Apache-2.0
#include "page/timeline.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.h"

namespace eikon {
namespace {

constexpr double kSpansAcross = 1500;     // those that are shorter than one part in so many of the time are joined
constexpr std::size_t kMaxPoints = 400;   // of a counter
constexpr std::size_t kMaxTracks = 64, kMaxDepth = 8;
constexpr double kRound_s = 1e-8;  // times in the file are rounded

struct Span {
  double begin_s = 0, end_s = 0;
  std::size_t name = 0;
  double named_s = 0;  // seconds of the longest of those that were joined to it, whose name it has
};

struct Track {
  std::string name;
  std::vector<Span> spans;
};

struct Events {
  std::map<std::int64_t, Track> tracks;
  std::map<std::string, std::vector<std::pair<double, double>>> counters;
  std::vector<std::string> names;
  double begin_s = 1e300, end_s = 0;
};

double number_of(const Json& event, const char* key) {
  const Json* const value = member(event, key);
  if (value == nullptr || !value->is_number()) throw InputError(std::string("an event has no number '") + key + "'");
  return value->get<double>();
}

std::string text_of(const Json& event, const char* key) {
  const Json* const value = member(event, key);
  if (value == nullptr || !value->is_string()) throw InputError(std::string("an event has no text '") + key + "'");
  return value->get<std::string>();
}

void read_event(const Json& event, Events& events, std::map<std::string, std::size_t>& indices) {
  if (!event.is_object()) throw InputError("an event is no object");
  const std::string kind = text_of(event, "ph"), name = text_of(event, "name");
  const Json* const arguments = member(event, "args");
  if (kind == "M" && name == "thread_name" && arguments != nullptr)
    events.tracks[std::int64_t(number_of(event, "tid"))].name = text_of(*arguments, "name");
  if (kind != "X" && kind != "C") return;
  const double at_s = 1e-6 * number_of(event, "ts");
  const double end_s = at_s + (kind == "X" ? 1e-6 * number_of(event, "dur") : 0);
  events.begin_s = std::min(events.begin_s, at_s);
  events.end_s = std::max(events.end_s, end_s);
  if (kind == "C") {
    if (arguments != nullptr) events.counters[name].emplace_back(at_s, number_of(*arguments, "value"));
    return;
  }
  const std::size_t index = indices.emplace(name, indices.size()).first->second;
  if (index == events.names.size()) events.names.push_back(name);
  events.tracks[std::int64_t(number_of(event, "tid"))].spans.push_back({at_s, end_s, index, end_s - at_s});
}

/// The spans of a track by depth of nesting, joined where they are too short to be drawn.
std::vector<std::vector<Span>> rows_of(std::vector<Span> spans, double least_s) {
  std::ranges::sort(spans, [](const Span& a, const Span& b) {
    return a.begin_s != b.begin_s ? a.begin_s < b.begin_s : a.end_s > b.end_s;
  });
  std::vector<std::vector<Span>> rows;
  std::vector<double> open_until;
  for (const Span& span : spans) {
    while (!open_until.empty() && span.begin_s >= open_until.back() - kRound_s) open_until.pop_back();
    const std::size_t depth = open_until.size();
    open_until.push_back(span.end_s);
    if (depth >= kMaxDepth) continue;
    if (rows.size() <= depth) rows.resize(depth + 1);
    std::vector<Span>& row = rows[depth];
    Span* const last = row.empty() ? nullptr : &row.back();
    const bool joins =
        last != nullptr && span.begin_s - last->end_s < least_s && span.end_s - last->begin_s < 2 * least_s;
    if (!joins) {
      row.push_back(span);
      continue;
    }
    last->end_s = std::max(last->end_s, span.end_s);
    if (span.named_s > last->named_s) last->name = span.name, last->named_s = span.named_s;
  }
  return rows;
}

Json track_json(const Track& track, const Events& events, double least_s) {
  Json rows = Json::array();
  for (const std::vector<Span>& row : rows_of(track.spans, least_s)) {
    Json spans = Json::array();
    for (const Span& span : row)
      spans.push_back({span.begin_s - events.begin_s, span.end_s - events.begin_s, span.name});
    rows.push_back(std::move(spans));
  }
  return {{"name", track.name}, {"rows", std::move(rows)}};
}

Json counter_json(const std::vector<std::pair<double, double>>& points, double begin_s) {
  const std::size_t step = points.size() / kMaxPoints + 1;
  Json list = Json::array();
  for (std::size_t i = 0; i < points.size(); ++i)
    if (i % step == 0 || i + 1 == points.size()) list.push_back({points[i].first - begin_s, points[i].second});
  return list;
}

}  // namespace

Json page_timeline(const Json& trace_events) {
  if (!trace_events.is_array()) throw InputError("it has no list of trace events");
  Events events;
  std::map<std::string, std::size_t> indices;
  for (const Json& event : trace_events) read_event(event, events, indices);
  if (events.end_s < events.begin_s) throw InputError("it has no event with a time");
  const double length_s = events.end_s - events.begin_s;
  Json timeline = {
      {"end_s", length_s}, {"names", events.names}, {"tracks", Json::array()}, {"counters", Json::object()}};
  for (const auto& [id, track] : events.tracks)
    if (!track.spans.empty() && timeline["tracks"].size() < kMaxTracks)
      timeline["tracks"].push_back(track_json(track, events, length_s / kSpansAcross));
  for (const auto& [name, points] : events.counters) timeline["counters"][name] = counter_json(points, events.begin_s);
  return timeline;
}

}  // namespace eikon
