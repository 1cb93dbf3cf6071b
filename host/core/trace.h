// SPDX-License-Identifier: Apache-2.0
// What happened when, for --profile: spans on tracks (a device's queue, a thread of the host), and counters over time. Memory is
// bounded however long it goes on: a track that is full keeps all its time, but neighbours become one span that says what is in it.
// Whoever has something to tell takes a pointer that may be null, and then nothing is measured.
#pragma once
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"

namespace eikon {

class Trace {
 public:
  using Track = std::size_t;
  static constexpr Track kMain = 0;  // the thread that made the trace

  /// What was recorded as one, or of one piece.
  struct Part {
    std::size_t name = 0;  // index into names()
    std::uint64_t count = 0;
    double seconds = 0;
  };
  /// One span, or several that follow each other, with what lies between them. Seconds of host_seconds().
  struct Entry {
    double begin_s = 0, end_s = 0;
    std::uint64_t parent = 0;  // 0: none; else only to tell the children of one span from those of another
    std::vector<Part> parts;   // by name; one part of count 1: a single span
  };
  /// Spans of one depth of nesting, one after the other.
  struct Level {
    std::vector<Entry> entries;
    std::uint64_t grain = 1;     // spans that become one entry
    std::uint64_t left_out = 0;  // for which there was no place
  };
  struct TrackRecord {
    std::string name;
    std::vector<Level> levels;  // those of a level lie within those of the level before
  };
  /// A value's mean over a stretch of time, or what it was at one moment.
  struct Point {
    double begin_s = 0, end_s = 0, value = 0;
  };

  /// most_*: of each level of each track, and of each counter; at least 2
  explicit Trace(std::size_t most_entries = 8192, std::size_t most_points = 2048);

  /// A new track. Its spans come from one thread at a time.
  Track add_track(const std::string& name);
  /// A span that has ended, below those that are open on the track. Not before the last one of the same level: what overlaps with
  /// it is cut off.
  void span(Track track, std::string_view name, double begin_s, double end_s);
  /// Opens and closes spans that others lie in; see TraceScope.
  void open(Track track);
  void close(Track track, std::string_view name, double begin_s, double end_s);
  /// A value that held on the average from begin_s to end_s, not before the end of the last one; of values at one moment (begin_s
  /// = end_s) every second one goes when there are too many.
  void count(const std::string& counter, double begin_s, double end_s, double value);

  /// Nothing is recorded any more, whoever still calls: a thread that hung in a driver may come back at any time.
  void end();
  /// For the writer, after end(), or when nobody records any more.
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
  std::vector<std::vector<std::uint64_t>> open_;  // of each track: what is open, from the outside
  std::uint64_t opened_ = 0;
  bool ended_ = false;
  std::vector<std::string> names_;
  std::map<std::string, std::size_t, std::less<>> name_indices_;
  std::map<std::string, std::vector<Point>> counters_;
};

/// A span as long as the object lives, or until end(). Of a null trace, nothing.
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
