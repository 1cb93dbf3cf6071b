// SPDX-License-Identifier: Apache-2.0
#include "render/schedule.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/error.h"

namespace eikon {
namespace {

constexpr std::size_t kNobody = ~std::size_t{0};
constexpr std::uint64_t kFirstUnit = 1024;  // paths of a unit while nothing is known: milliseconds even on slow devices
constexpr std::uint64_t kGrowth = 8;        // a unit is at most so many times the largest that was measured
constexpr double kShare = 1.0 / 3;          // of what is left, that the units dealt next make up
constexpr double kLongestUnit_s = 0.5;      // an interruption waits for two of them, and a fault loses them
constexpr double kOverheadShare = 0.04;     // of a unit's time
constexpr double kShortestUnit_s = 4e-3;    // whatever the overhead: timing and threads are no better than that
constexpr double kNewWeight = 0.4;          // of a new measurement, against all before it
constexpr std::uint64_t kLeastSamples = 16;  // of a pixel that a unit may have, however few there are
constexpr std::uint64_t kPasses = 4;         // over the image, at least, where a pixel has more samples than that

}  // namespace

Schedule::Schedule(std::size_t devices, std::uint32_t block) : devices_(devices), block_(block), pool_(block) {}

void Schedule::open(const std::vector<WorkUnit>& boxes) {
  std::uint64_t begin = std::numeric_limits<std::uint64_t>::max(), end = 0;
  for (const WorkUnit& box : boxes) {
    pool_.add(box);
    begin = std::min(begin, box.sample_begin);
    end = std::max(end, box.sample_end);
    left_ += box.path_count();
  }
  opened_ = left_;
  const std::uint64_t range = end > begin ? end - begin : 1;
  most_samples_ = std::max(kLeastSamples, (range + kPasses - 1) / kPasses);
}

void Schedule::join(std::size_t device, const UnitLimits& limits) {
  DeviceState& d = devices_[device];
  d.takes_part = true;
  d.has_left = false;
  d.limits = limits;
  d.limits.capacity = std::max<std::uint64_t>(limits.capacity, 1);
  d.limits.grain = std::clamp<std::uint64_t>(limits.grain, 1, d.limits.capacity);
}

void Schedule::leave(std::size_t device) {
  devices_[device].takes_part = false;
  devices_[device].has_left = true;
  for (auto it = flights_.begin(); it != flights_.end();) {
    const auto current = it++;
    if (current->second.device == device) gave_back(current->first);
  }
}

bool Schedule::manned() const {
  return std::any_of(devices_.begin(), devices_.end(), [](const DeviceState& d) { return d.takes_part; });
}

bool Schedule::others_take_part(std::size_t device) const {
  for (std::size_t i = 0; i < devices_.size(); ++i)
    if (i != device && devices_[i].takes_part) return true;
  return false;
}

/// Some take part, or will as soon as they are open.
bool Schedule::others_are_expected(std::size_t device) const {
  for (std::size_t i = 0; i < devices_.size(); ++i)
    if (i != device && !devices_[i].has_left) return true;
  return false;
}

double Schedule::rate(std::size_t device) const {
  return devices_[device].path_s > 0 ? 1 / devices_[device].path_s : 0;
}

double Schedule::expected_s(const DeviceState& device, std::uint64_t paths) const {
  const double seconds = device.overhead_s + double(paths) * device.path_s;
  // While all units were about as large, all of their time may be overhead.
  return device.split_known ? seconds : std::max(seconds, device.smallest_s);
}

std::optional<double> Schedule::expected_s(std::uint64_t id) const {
  const auto flight = flights_.find(id);
  if (flight == flights_.end() || devices_[flight->second.device].path_s == 0) return std::nullopt;
  return expected_s(devices_[flight->second.device], flight->second.unit.path_count());
}

/// When the device will have done its units up to that one. What is late is expected to be late by as much again; where nothing is
/// known, as if it should be there by now.
double Schedule::end_s(std::size_t device, std::uint64_t last_id, double now_s) const {
  const DeviceState& d = devices_[device];
  double end_s = now_s;
  bool first = true;
  for (const auto& [id, flight] : flights_) {
    if (flight.device != device || id > last_id) continue;
    const double unit_s = d.path_s > 0 ? expected_s(d, flight.unit.path_count()) : 0;
    const double due_s = (first ? flight.begin_s : end_s) + unit_s;
    end_s = now_s < due_s ? due_s : now_s + (now_s - due_s);
    first = false;
  }
  return end_s;
}

double Schedule::free_at(std::size_t device, double now_s) const { return end_s(device, next_id_, now_s); }

bool Schedule::is_idle(std::size_t device) const {
  return std::none_of(flights_.begin(), flights_.end(),
                      [&](const auto& flight) { return flight.second.device == device; });
}

/// When all devices of known rate but one have done so many paths, after the units that they have. Infinite: there are none.
double Schedule::finish_s(double paths, std::size_t without, double now_s) const {
  std::vector<std::pair<double, double>> from;  // from that time on, paths per second
  for (std::size_t i = 0; i < devices_.size(); ++i)
    if (i != without && devices_[i].takes_part && devices_[i].path_s > 0)
      from.emplace_back(free_at(i, now_s) + devices_[i].overhead_s, 1 / devices_[i].path_s);
  if (from.empty()) return std::numeric_limits<double>::infinity();
  std::sort(from.begin(), from.end());
  double rate = 0, at_s = from.front().first;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double done = rate * (from[i].first - at_s);
    if (done >= paths) break;
    paths -= done;
    at_s = from[i].first;
    rate += from[i].second;
  }
  return at_s + paths / rate;
}

/// Paths of a unit of which the overhead is a small part, if it is not that of the whole device.
std::uint64_t Schedule::least_size(const DeviceState& device) const {
  const double seconds = std::min(std::max(kShortestUnit_s, device.overhead_s / kOverheadShare), kLongestUnit_s);
  const auto paths = std::uint64_t(seconds / device.path_s);
  return std::clamp<std::uint64_t>(paths, 1, device.limits.capacity);
}

/// Of the next unit, from the pool; 0: the device is better left out.
std::uint64_t Schedule::unit_size(std::size_t device, double now_s) {
  DeviceState& d = devices_[device];
  const auto left = double(pool_.path_count());
  const double begin_s = free_at(device, now_s);
  const double others_s = finish_s(left, device, now_s);  // when the others would be done with all of it
  if (d.path_s == 0) {
    // It is not worth waiting for a device of which nothing is known.
    if (others_s < begin_s + kShortestUnit_s) return 0;
    return others_are_expected(device) ? std::min(kFirstUnit, d.limits.capacity) : d.limits.grain;
  }
  const double most_s = kLongestUnit_s / d.path_s;
  std::uint64_t most = std::min(d.limits.capacity, std::max(kGrowth * d.largest, kFirstUnit));
  if (most_s < double(most)) most = std::max<std::uint64_t>(std::uint64_t(most_s), 1);
  if (!others_take_part(device)) return most;
  const double until_s = finish_s(left, kNobody, now_s);
  // The whole device is used where that is not too long for the end.
  const std::uint64_t least = std::min(std::max(least_size(d), d.limits.grain), most);
  const double share = kShare * std::max(until_s - begin_s, 0.0) / d.path_s;
  std::uint64_t size = std::clamp(share < double(most) ? std::uint64_t(share) : most, least, most);
  if (begin_s + expected_s(d, size) > until_s) {
    const double fitting = (until_s - begin_s - d.overhead_s) / d.path_s;
    const std::uint64_t small = std::max<std::uint64_t>(least / 4, 1);
    size = fitting > double(small) ? std::min(std::uint64_t(fitting), size) : small;
  }
  if (begin_s + expected_s(d, size) <= others_s) return size;
  return flights_.empty() && is_quickest(device, size) ? size : 0;  // if nobody does it, it stays undone
}

bool Schedule::is_quickest(std::size_t device, std::uint64_t paths) const {
  const double own_s = expected_s(devices_[device], paths);
  return std::none_of(devices_.begin(), devices_.end(), [&](const DeviceState& d) {
    return d.takes_part && d.path_s > 0 && expected_s(d, paths) < own_s;
  });
}

std::optional<WorkUnit> Schedule::take_returned(std::size_t device) {
  const bool others = others_take_part(device);
  for (auto it = returned_.begin(); it != returned_.end(); ++it) {
    if (it->from == device && others) continue;
    const Returned found = *it;
    returned_.erase(it);
    UnitPool pieces(block_);
    pieces.add(found.unit);
    const DeviceState& d = devices_[device];
    std::uint64_t most = d.path_s > 0 ? std::min(d.limits.capacity, kGrowth * d.largest) : kFirstUnit;
    most = std::min(most, d.limits.capacity);
    const std::optional<WorkUnit> unit = pieces.take(most, found.unit.path_count());
    while (const std::optional<WorkUnit> rest = pieces.take(found.unit.path_count(), found.unit.path_count()))
      returned_.push_back({*rest, found.from});
    return unit;
  }
  return std::nullopt;
}

/// The unit of another device that this one would have done soonest before that one; 0: none.
std::uint64_t Schedule::late_flight(std::size_t device, double now_s) const {
  const DeviceState& d = devices_[device];
  const bool known = d.path_s > 0;  // else it gets what is small, as if that took as long as a unit may
  const std::uint64_t most = known ? d.limits.capacity : std::min(kFirstUnit, d.limits.capacity);
  std::uint64_t best = 0;
  double best_s = 0;
  for (const auto& [id, flight] : flights_) {
    if (flight.device == device || flight.twin != 0 || flight.unit.path_count() > most) continue;
    if (!devices_[flight.device].takes_part) continue;
    const double own_s = known ? expected_s(d, flight.unit.path_count()) : kLongestUnit_s;
    const double gain_s = end_s(flight.device, id, now_s) - (now_s + own_s);
    // Not for what may be noise of the measurements.
    if (gain_s > std::max(best_s, kShortestUnit_s + 0.25 * own_s)) best = id, best_s = gain_s;
  }
  return best;
}

Schedule::Dealt Schedule::deal(std::size_t device, const WorkUnit& unit, double now_s) {
  const std::uint64_t id = next_id_++;
  Flight& flight = flights_[id];
  flight.device = device;
  flight.unit = unit;
  flight.begin_s = now_s;
  return {id, unit};
}

std::optional<Schedule::Dealt> Schedule::next(std::size_t device, double now_s) {
  DeviceState& d = devices_[device];
  if (!d.takes_part) return std::nullopt;
  if (const std::optional<WorkUnit> again = take_returned(device)) return deal(device, *again, now_s);
  if (!pool_.empty()) {
    const std::uint64_t size = unit_size(device, now_s);
    if (size == 0) {
      d.left_out_at = std::max(d.left_out_at, double(pool_.path_count()) / double(std::max<std::uint64_t>(opened_, 1)));
      return std::nullopt;
    }
    return deal(device, *pool_.take(size, most_samples_), now_s);
  }
  // What comes of it may not count: not behind a unit that does, where nothing could call it off.
  const std::uint64_t late = is_idle(device) ? late_flight(device, now_s) : 0;
  if (late == 0) return std::nullopt;
  const Dealt twin = deal(device, flights_.at(late).unit, now_s);
  flights_.at(late).twin = twin.id;
  flights_.at(twin.id).twin = late;
  return twin;
}

/// Takes t = overhead + paths * path_s, through the smallest and the largest unit that were measured.
void Schedule::measure(DeviceState& d, std::uint64_t paths, double seconds) {
  seconds = std::max(seconds, 1e-9);
  const bool larger = paths > d.largest + d.largest / 2;  // a better measurement than all before
  if (d.smallest == 0 || paths < d.smallest) d.smallest = paths, d.smallest_s = seconds;
  if (paths >= d.largest) d.largest = paths, d.largest_s = seconds;
  d.split_known = 2 * d.largest > 3 * d.smallest;
  if (d.split_known) {
    const double path_s = std::max(0.0, (d.largest_s - d.smallest_s) / double(d.largest - d.smallest));
    d.overhead_s = std::clamp(d.smallest_s - path_s * double(d.smallest), 0.0, d.smallest_s);
  }
  const double path_s = std::max(seconds - d.overhead_s, 0.1 * seconds) / double(paths);
  if (larger)
    d.path_s = path_s;
  else
    d.path_s += kNewWeight * std::min(1.0, 4 * double(paths) / double(d.largest)) * (path_s - d.path_s);
}

bool Schedule::finished(std::uint64_t id, double begin_s, double now_s) {
  const auto found = flights_.find(id);
  if (found == flights_.end()) return false;
  const Flight flight = found->second;
  flights_.erase(found);
  if (flight.twin != 0) flights_.erase(flight.twin);  // what comes of it does not count
  for (auto& [other_id, other] : flights_)
    if (other.device == flight.device) other.begin_s = std::max(other.begin_s, now_s);  // only now
  left_ -= flight.unit.path_count();
  measure(devices_[flight.device], flight.unit.path_count(), now_s - begin_s);
  return true;
}

void Schedule::gave_back(std::uint64_t id) {
  const auto found = flights_.find(id);
  if (found == flights_.end()) return;
  const Flight flight = found->second;
  flights_.erase(found);
  if (flight.twin != 0)
    flights_.at(flight.twin).twin = 0;
  else
    returned_.push_back({flight.unit, flight.device});
}

}  // namespace eikon
