// SPDX-License-Identifier: Apache-2.0
#include "core/trace.h"

#include <algorithm>
#include <utility>

namespace eikon {
namespace {

void append(Trace::Entry& to, const Trace::Entry& next) {
  to.end_s = next.end_s;
  for (const Trace::Part& part : next.parts) {
    const auto same = std::ranges::find(to.parts, part.name, &Trace::Part::name);
    if (same == to.parts.end()) {
      to.parts.push_back(part);
    } else {
      same->count += part.count;
      same->seconds += part.seconds;
    }
  }
}

std::uint64_t spans_of(const Trace::Entry& entry) {
  std::uint64_t count = 0;
  for (const Trace::Part& part : entry.parts) count += part.count;
  return count;
}

Trace::Point joined(const Trace::Point& a, const Trace::Point& b) {
  const double of_a = a.end_s - a.begin_s, of_b = b.end_s - b.begin_s, both = of_a + of_b;
  if (both <= 0) return b;
  return {a.begin_s, b.end_s, (a.value * of_a + b.value * of_b) / both};
}

}  // namespace

Trace::Trace(std::size_t most_entries, std::size_t most_points)
    : most_entries_(std::max<std::size_t>(most_entries, 2)), most_points_(std::max<std::size_t>(most_points, 2)) {
  add_track("main");
}

void Trace::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
}

Trace::Track Trace::add_track(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (ended_) return kMain;
  tracks_.push_back({name, {}});
  open_.emplace_back();
  return tracks_.size() - 1;
}

void Trace::span(Track track, std::string_view name, double begin_s, double end_s) {
  const std::lock_guard lock(mutex_);
  if (ended_) return;
  const std::vector<std::uint64_t>& open = open_[track];
  const std::uint64_t parent = open.empty() ? 0 : open.back();
  add(tracks_[track], open.size(), {begin_s, end_s, parent, {{name_index(name), 1, end_s - begin_s}}});
}

void Trace::open(Track track) {
  const std::lock_guard lock(mutex_);
  if (ended_) return;
  open_[track].push_back(++opened_);
}

void Trace::close(Track track, std::string_view name, double begin_s, double end_s) {
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    open_[track].pop_back();
  }
  span(track, name, begin_s, end_s);
}

void Trace::count(const std::string& counter, double begin_s, double end_s, double value) {
  const std::lock_guard lock(mutex_);
  if (ended_) return;
  std::vector<Point>& points = counters_[counter];
  if (!points.empty()) begin_s = std::max(begin_s, points.back().end_s);
  points.push_back({begin_s, std::max(begin_s, end_s), value});
  if (points.size() <= most_points_) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); i += 2)
    points[kept++] = i + 1 < points.size() ? joined(points[i], points[i + 1]) : points[i];
  points.resize(kept);
}

std::size_t Trace::name_index(std::string_view name) {
  const auto found = name_indices_.find(name);
  if (found != name_indices_.end()) return found->second;
  names_.emplace_back(name);
  return name_indices_.emplace(name, names_.size() - 1).first->second;
}

void Trace::add(TrackRecord& track, std::size_t depth, Entry entry) {
  if (track.levels.size() <= depth) track.levels.resize(depth + 1);
  Level& level = track.levels[depth];
  if (!level.entries.empty()) {
    Entry& last = level.entries.back();
    entry.begin_s = std::max(entry.begin_s, last.end_s);
    entry.end_s = std::max(entry.end_s, entry.begin_s);
    entry.parts.front().seconds = entry.end_s - entry.begin_s;
    if (last.parent == entry.parent && spans_of(last) < level.grain) {
      append(last, entry);
      return;
    }
  }
  if (level.entries.size() == most_entries_) coarsen(level);
  if (level.entries.size() == most_entries_)
    ++level.left_out;  // merging needs a common parent, and each of these has its own
  else
    level.entries.push_back(std::move(entry));
}

void Trace::coarsen(Level& level) const {
  level.grain *= 2;
  std::vector<Entry> entries;
  for (Entry& entry : level.entries) {
    const bool joins = !entries.empty() && entries.back().parent == entry.parent &&
                       spans_of(entries.back()) + spans_of(entry) <= level.grain;
    if (joins)
      append(entries.back(), entry);
    else
      entries.push_back(std::move(entry));
  }
  level.entries = std::move(entries);
}

}  // namespace eikon
