// SPDX-License-Identifier: Apache-2.0
// Decides which device gets which samples. It has plain numbers and no clock of its own, so that
// tests can simulate devices of any rate.
#pragma once
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "film/units.h"

namespace eikon {

/// Sizes of units that a device can take, in paths.
struct UnitLimits {
  std::uint64_t capacity = 1;  // most paths of one unit
  std::uint64_t grain = 1;     // fewer paths leave a part of the device without work
  std::uint64_t least_block = std::uint64_t{128} * 128;  // pixels of a block, which may have fewer paths than capacity
  std::uint64_t most_block = least_block;                // pixels of a block that has room for its sums
  // A unit may have as many samples of a pixel as all devices render of the whole picture in this
  // time. Where sums are copied from a device, few pixels of many samples take less of that.
  double pass_s = 0;
};

/// Assigns units to devices so that all finish together. Each device gets its share, by measured
/// rate, of a third of what is left (factoring [Hummel, Schonberg, Flynn 1992, CACM 35(8)]). So
/// units shrink towards the end, down to a size at which the fixed cost of a unit is a few percent.
///
/// A unit counts once, whatever happens. A unit that a device gave back or lost goes to a device
/// again, if possible to another one. When nothing else is left, an idle device gets a speculative
/// copy of a unit that it would have done sooner than the device that has it, and the first result
/// counts (backup tasks [Dean, Ghemawat 2004, OSDI]).
///
/// Times are seconds on one clock, which never goes back. Not synchronised.
class Schedule {
 public:
  struct Assignment {
    std::uint64_t id = 0;
    WorkUnit unit;
  };

  /// block: largest side of a unit's block, in pixels
  Schedule(std::size_t devices, std::uint32_t block);

  /// No unit will cross a multiple of so many samples (UnitPool::set_period).
  void set_period(std::uint64_t period) { pool_.set_period(period); }

  /// Adds work. Devices that were left out before may take part again.
  void open(const std::vector<WorkUnit>& boxes);

  /// From now on units are sized so that they should have ended by then; none is assigned that
  /// would not.
  void set_latest(double latest_s) { latest_s_ = latest_s; }

  /// From now on the device takes part, with these limits; measurements of an earlier opening stay.
  void join(std::size_t device, const UnitLimits& limits);
  /// The device takes part no longer. Its units go to other devices; finished() returns false for
  /// them.
  void leave(std::size_t device);

  /// The next unit of a device that takes part. Nothing means that there is no work for it now;
  /// unless complete(), there may be some later. A device does its units in the order of
  /// assignment; it may ask before it has done the last.
  [[nodiscard]] std::optional<Assignment> next(std::size_t device, double now_s);
  /// The result of a unit is there; the device began it at begin_s.
  /// returns  false when it does not count, because the copy of another device did or because the
  ///          device had left
  bool finished(std::uint64_t id, double begin_s, double now_s);
  /// The device failed to do a unit.
  void gave_back(std::uint64_t id);

  /// A device has the unit and its result would count.
  [[nodiscard]] bool counts(std::uint64_t id) const { return in_flight_.count(id) != 0; }
  /// Everything that was opened has been finished.
  [[nodiscard]] bool complete() const { return left_ == 0; }
  /// Seconds that the unit should take; nothing while the device's rate is unknown or when no
  /// device has the unit.
  [[nodiscard]] std::optional<double> expected_s(std::uint64_t id) const;
  /// Paths per second as measured; 0 while unknown.
  [[nodiscard]] double rate(std::size_t device) const;
  /// The largest share of the work opened last that was left when the device was refused a unit
  /// because any would have been late; 0: never.
  [[nodiscard]] double left_out_at(std::size_t device) const { return devices_[device].left_out_at; }

 private:
  struct DeviceState {
    bool takes_part = false, has_left = false;  // neither: it is still being opened
    UnitLimits limits;
    double path_s = 0;                        // seconds per path; 0: unknown
    double overhead_s = 0;                    // fixed cost of a unit
    std::uint64_t largest = 0, smallest = 0;  // paths of units that were measured; 0: none
    double smallest_s = 0, largest_s = 0;
    bool split_known = false;  // overhead and rate are known apart
    double left_out_at = 0;
  };
  struct InFlight {
    std::size_t device = 0;
    WorkUnit unit;
    double begin_s = 0;                  // when it was assigned, or when the unit before it ended
    std::uint64_t speculative_copy = 0;  // id of the same unit on another device; 0: none
  };
  struct Returned {
    WorkUnit unit;
    std::size_t from = 0;
  };

  std::vector<DeviceState> devices_;
  std::uint32_t block_;
  UnitPool pool_;
  std::vector<Returned> returned_;
  std::map<std::uint64_t, InFlight> in_flight_;
  double latest_s_ = std::numeric_limits<double>::infinity();
  std::uint64_t next_id_ = 1;
  std::uint64_t left_ = 0;          // paths that are not finished, assigned ones included
  std::uint64_t opened_ = 0;        // paths that were left when open() was called last
  std::uint64_t range_ = 1;         // samples of a pixel that open() was called with last

  [[nodiscard]] double expected_s(const DeviceState& device, std::uint64_t paths) const;
  [[nodiscard]] double end_s(std::size_t device, std::uint64_t last_id, double now_s) const;
  [[nodiscard]] double free_at(std::size_t device, double now_s) const;
  [[nodiscard]] bool is_idle(std::size_t device) const;
  [[nodiscard]] double finish_s(double paths, std::size_t without, double now_s) const;
  [[nodiscard]] std::uint64_t unit_size(std::size_t device, double now_s);
  [[nodiscard]] std::uint64_t most_samples(const UnitLimits& limits) const;
  [[nodiscard]] std::uint64_t block_pixels(const UnitLimits& limits, std::uint64_t paths) const;
  [[nodiscard]] std::uint64_t most_in_time(std::size_t device, double now_s) const;
  [[nodiscard]] bool is_quickest(std::size_t device, std::uint64_t paths) const;
  [[nodiscard]] std::uint64_t least_size(const DeviceState& device) const;
  [[nodiscard]] bool others_take_part(std::size_t device) const;
  [[nodiscard]] bool others_are_expected(std::size_t device) const;
  [[nodiscard]] std::optional<WorkUnit> take_returned(std::size_t device, std::uint64_t most);
  [[nodiscard]] std::uint64_t latest_unit(std::size_t device, double now_s) const;
  Assignment assign(std::size_t device, const WorkUnit& unit, double now_s);
  void measure(DeviceState& device, std::uint64_t paths, double seconds);
};

}  // namespace eikon
