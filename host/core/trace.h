// SPDX-License-Identifier: Apache-2.0
// Records the timeline of --profile: spans on tracks (the queue of a device, a thread of the host)
// and counters over time. Its memory is bounded. A full track keeps its whole time, but
// neighbouring spans are merged into one that lists its parts. Code that records takes a Trace
// pointer; with a null pointer it measures nothing.
#pragma once
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"

namespace eikon {

/// A timeline: spans on tracks, and counters. Any number of threads may record in it.
class Trace {
 public:
  using Track = std::size_t;
  static constexpr Track kMain = 0;  // the thread that created the trace

  /// Time under one name within an entry.
  struct Part {
    std::size_t name = 0;  // index into names()
    std::uint64_t count = 0;
    double seconds = 0;
  };
  /// One span, or several neighbours with the gaps between them. Times are host_seconds().
  struct Entry {
    double begin_s = 0, end_s = 0;
    std::uint64_t parent = 0;  // id that the children of one span share; 0: none
    std::vector<Part> parts;   // by name; a single span has one part of count 1
  };
  /// Spans of one depth of nesting, in the order of time.
  struct Level {
    std::vector<Entry> entries;
    std::uint64_t grain = 1;     // spans that are merged into one entry
    std::uint64_t left_out = 0;  // spans for which there was no place
  };
  struct TrackRecord {
    std::string name;
    std::vector<Level> levels;  // spans of a level lie within spans of the level before
  };
  /// The mean of a value over a stretch of time, or the value at one moment.
  struct Point {
    double begin_s = 0, end_s = 0, value = 0;
  };

  /// most_*: limits for each level of each track and for each counter; at least 2
  explicit Trace(std::size_t most_entries = 8192, std::size_t most_points = 2048);

  /// Adds a track. Its spans come from one thread at a time.
  Track add_track(const std::string& name);
  /// Records a span that has ended, below the spans that are open on the track. The part that
  /// overlaps with the last span of the same level is cut off.
  void span(Track track, std::string_view name, double begin_s, double end_s);
  /// Opens and closes spans that enclose others; see TraceScope.
  void open(Track track);
  void close(Track track, std::string_view name, double begin_s, double end_s);
  /// Records the mean of a value from begin_s to end_s, which begins at the end of the last one or
  /// later. Of values at one moment (begin_s = end_s), every second one goes when there are too
  /// many.
  void count(const std::string& counter, double begin_s, double end_s, double value);

  /// Ends recording for all callers, because a thread that hung in a driver may come back at any
  /// time.
  void end();
  /// For the writer; to be called after end(), or when nobody records any more.
  [[nodiscard]] const std::vector<TrackRecord>& tracks() const { return tracks_; }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] const std::map<std::string, std::vector<Point>>& counters() const { return counters_; }

 private:
  std::size_t name_index(std::string_view name);
  void add(TrackRecord& track, std::size_t level, Entry entry);
  void coarsen(Level& level) const;

  const std::size_t most_entries_, most_points_;
  std::mutex mutex_;
  std::vector<TrackRecord> tracks_;
  std::vector<std::vector<std::uint64_t>> open_;  // for each track: its open spans, outermost first
  std::uint64_t opened_ = 0;
  bool ended_ = false;
  std::vector<std::string> names_;
  std::map<std::string, std::size_t, std::less<>> name_indices_;
  std::map<std::string, std::vector<Point>> counters_;
};

/// Records a span for as long as the object lives, or until end(). With a null trace it does
/// nothing.
class TraceScope {
 public:
  TraceScope(Trace* trace, Trace::Track track, const char* name) : trace_(trace), track_(track), name_(name) {
    if (trace_ == nullptr) return;
    trace_->open(track_);
    begin_s_ = host_seconds();
  }
  ~TraceScope() { end(); }
  TraceScope(const TraceScope&) = delete;
  TraceScope& operator=(const TraceScope&) = delete;
  void end() {
    if (trace_ != nullptr) trace_->close(track_, name_, begin_s_, host_seconds());
    trace_ = nullptr;
  }

 private:
  Trace* trace_;
  Trace::Track track_;
  const char* name_;
  double begin_s_ = 0;
};

}  // namespace eikon
