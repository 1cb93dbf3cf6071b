// SPDX-License-Identifier: Apache-2.0
// Which device gets which samples: plain numbers, no device and no clock of its own, so that it can be tried with invented rates.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "film/units.h"

namespace eikon {

/// What a device takes, in paths.
struct UnitLimits {
  std::uint64_t capacity = 1;  // of one unit, at most
  std::uint64_t grain = 1;     // fewer leave part of the device without work
};

/// Deals units to devices so that all finish together: each gets its part, by measured rate, of a third of what is left, so that units
/// shrink towards the end, down to a size at which what a unit costs besides its paths is a few percent. [Hummel, Schonberg,
/// Flynn 1992, CACM 35(8): factoring; Dean, Ghemawat 2004, OSDI: backup tasks]
///
/// A unit counts once, whatever happens: one that a device gave back, or was lost with its device, is dealt again, to another
/// device first; and when nothing else is left, a unit of a device that would need longer for it than another one from now on
/// is dealt to that one too, and whoever is first counts.
///
/// Times are seconds on any one clock, which never goes back. Not synchronised.
class Schedule {
 public:
  struct Dealt {
    std::uint64_t id = 0;
    WorkUnit unit;
  };

  /// block: largest side of a unit's block, in pixels
  Schedule(std::size_t devices, std::uint32_t block);

  /// Adds work. What was left out for want of work before may take part again.
  void open(const std::vector<WorkUnit>& boxes);

  /// A device takes part from now on, or again, with other limits; what was measured of it stays.
  void join(std::size_t device, const UnitLimits& limits);
  /// A device takes part no longer. Its units are dealt again; finished() is false for them.
  void leave(std::size_t device);

  /// The next unit of a device that takes part, or nothing: no work for it now. There may be some later, unless complete(). A device
  /// does its units in the order in which it got them; it may ask before it has done the last.
  [[nodiscard]] std::optional<Dealt> next(std::size_t device, double now_s);
  /// A unit's result is there. begin_s: when the device began it. false: it does not count, since another device's counted,
  /// or the unit was taken away
  bool finished(std::uint64_t id, double begin_s, double now_s);
  /// A unit failed on its device.
  void gave_back(std::uint64_t id);

  /// The unit is still somebody's, and not done.
  [[nodiscard]] bool counts(std::uint64_t id) const { return flights_.count(id) != 0; }
  /// Everything that was opened has been finished.
  [[nodiscard]] bool complete() const { return left_ == 0; }
  [[nodiscard]] std::uint64_t paths_left() const { return left_; }  // dealt ones included
  /// Somebody takes part.
  [[nodiscard]] bool manned() const;
  /// Seconds that the unit should take; nothing while the device's rate is not known, or the unit is none.
  [[nodiscard]] std::optional<double> expected_s(std::uint64_t id) const;
  /// Paths per second as measured; 0: unknown
  [[nodiscard]] double rate(std::size_t device) const;
  /// The share of the work opened last that was left when the device was last refused some of it: any unit of it would have been
  /// late. 0: never
  [[nodiscard]] double left_out_at(std::size_t device) const { return devices_[device].left_out_at; }

 private:
  struct DeviceState {
    bool takes_part = false, has_left = false;  // neither: it is still expected
    UnitLimits limits;
    double path_s = 0;                        // per path; 0: unknown
    double overhead_s = 0;                    // of a unit
    std::uint64_t largest = 0, smallest = 0;  // units measured; 0: none
    double smallest_s = 0, largest_s = 0;
    bool split_known = false;  // overhead and rate apart
    double left_out_at = 0;
  };
  struct Flight {
    std::size_t device = 0;
    WorkUnit unit;
    double begin_s = 0;      // dealt, or the one before it came to its end
    std::uint64_t twin = 0;  // id of the same unit on another device
  };
  struct Returned {
    WorkUnit unit;
    std::size_t from = 0;
  };

  std::vector<DeviceState> devices_;
  std::uint32_t block_;
  UnitPool pool_;
  std::vector<Returned> returned_;
  std::map<std::uint64_t, Flight> flights_;
  std::uint64_t next_id_ = 1, left_ = 0, opened_ = 0, most_samples_ = 1;

  [[nodiscard]] double expected_s(const DeviceState& device, std::uint64_t paths) const;
  [[nodiscard]] double end_s(std::size_t device, std::uint64_t last_id, double now_s) const;
  [[nodiscard]] double free_at(std::size_t device, double now_s) const;
  [[nodiscard]] bool is_idle(std::size_t device) const;
  [[nodiscard]] double finish_s(double paths, std::size_t without, double now_s) const;
  [[nodiscard]] std::uint64_t unit_size(std::size_t device, double now_s);
  [[nodiscard]] bool is_quickest(std::size_t device, std::uint64_t paths) const;
  [[nodiscard]] std::uint64_t least_size(const DeviceState& device) const;
  [[nodiscard]] bool others_take_part(std::size_t device) const;
  [[nodiscard]] bool others_are_expected(std::size_t device) const;
  [[nodiscard]] std::optional<WorkUnit> take_returned(std::size_t device);
  [[nodiscard]] std::uint64_t late_flight(std::size_t device, double now_s) const;
  Dealt deal(std::size_t device, const WorkUnit& unit, double now_s);
  void measure(DeviceState& device, std::uint64_t paths, double seconds);
};

}  // namespace eikon
