// SPDX-License-Identifier: Apache-2.0
#include "render/schedule.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace eikon {
namespace {

constexpr std::size_t kNobody = ~std::size_t{0};

// Sizes of units. Factoring: the units that devices get next make up this share of what is left
// [Hummel et al. 1992].
constexpr double kFactoringShare = 1.0 / 3;
// Paths, while no rate is known: milliseconds even on slow devices.
constexpr std::uint64_t kFirstUnit = 1024;
// A unit is at most so many times the largest that was measured.
constexpr std::uint64_t kGrowth = 8;
// An interruption waits for two of them, and a failure loses them.
constexpr double kLongestUnit_s = 0.5;
constexpr double kShortestUnit_s = 4e-3;  // clocks and threads are no more precise than that
// The fixed cost of a unit is at most this share of its duration.
constexpr double kOverheadShare = 0.04;

// Order of samples: a unit has at most 1/kPasses of a pixel's samples, so that an interrupted image
// is noisy everywhere, but kMinSamples where a pixel has few, or more where all samples take
// little time (pass_s).
constexpr std::uint64_t kMinSamples = 16, kPasses = 4;

// Rates: the weight of a new measurement against all before it.
constexpr double kNewWeight = 0.4;

// Speculative copies: a device repeats another one's late unit if it expects to be done sooner by
// kShortestUnit_s and this share of its own time; less may be noise of the measurements.
constexpr double kSpeculationMargin = 0.25;

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
  range_ = end > begin ? end - begin : 1;
}

/// Samples of a pixel that a unit may have.
std::uint64_t Schedule::most_samples(const UnitLimits& limits) const {
  double rate = 0;
  for (const DeviceState& d : devices_)
    if (d.takes_part && d.path_s > 0) rate += 1 / d.path_s;
  const double pass = limits.pass_s * rate * double(range_) / double(std::max<std::uint64_t>(opened_, 1));
  // All of them, or a power of two: then the passes after the first are no smaller.
  const std::uint64_t of_pass = pass < double(range_) ? std::bit_floor(std::uint64_t(pass)) : range_;
  return std::max({kMinSamples, (range_ + kPasses - 1) / kPasses, of_pass});
}

/// Pixels of the block of a unit that is to have so many paths.
std::uint64_t Schedule::block_pixels(const UnitLimits& limits, std::uint64_t paths) const {
  const std::uint64_t pixels = paths / std::min(most_samples(limits), range_);
  return std::clamp(pixels, limits.least_block, std::max(limits.least_block, limits.most_block));
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
  for (auto it = in_flight_.begin(); it != in_flight_.end();) {
    const auto current = it++;
    if (current->second.device == device) gave_back(current->first);
  }
}

bool Schedule::others_take_part(std::size_t device) const {
  for (std::size_t i = 0; i < devices_.size(); ++i)
    if (i != device && devices_[i].takes_part) return true;
  return false;
}

/// Other devices take part, or will as soon as they are open.
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
  // While all units were about equally large, all of their time may be overhead.
  return device.split_known ? seconds : std::max(seconds, device.smallest_s);
}

std::optional<double> Schedule::expected_s(std::uint64_t id) const {
  const auto in_flight = in_flight_.find(id);
  if (in_flight == in_flight_.end() || devices_[in_flight->second.device].path_s == 0) return std::nullopt;
  return expected_s(devices_[in_flight->second.device], in_flight->second.unit.path_count());
}

/// The time at which the device will have done its units up to `last_id`. A late unit is expected
/// to be late by as much again; while no rate is known, a unit counts as due now.
double Schedule::end_s(std::size_t device, std::uint64_t last_id, double now_s) const {
  const DeviceState& d = devices_[device];
  double end_s = now_s;
  bool first = true;
  for (const auto& [id, in_flight] : in_flight_) {
    if (in_flight.device != device || id > last_id) continue;
    const double unit_s = d.path_s > 0 ? expected_s(d, in_flight.unit.path_count()) : 0;
    const double due_s = (first ? in_flight.begin_s : end_s) + unit_s;
    end_s = now_s < due_s ? due_s : now_s + (now_s - due_s);
    first = false;
  }
  return end_s;
}

double Schedule::free_at(std::size_t device, double now_s) const { return end_s(device, next_id_, now_s); }

bool Schedule::is_idle(std::size_t device) const {
  return std::none_of(in_flight_.begin(), in_flight_.end(),
                      [&](const auto& in_flight) { return in_flight.second.device == device; });
}

/// The time at which the devices of known rate, except `without`, will have done so many paths
/// after the units that they have; infinite when there is no such device.
double Schedule::finish_s(double paths, std::size_t without, double now_s) const {
  // Time from which a device is free, and its paths per second.
  std::vector<std::pair<double, double>> from;
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

/// Paths of the smallest unit whose fixed cost is a small share of its duration.
std::uint64_t Schedule::least_size(const DeviceState& device) const {
  const double seconds = std::min(std::max(kShortestUnit_s, device.overhead_s / kOverheadShare), kLongestUnit_s);
  const auto paths = std::uint64_t(seconds / device.path_s);
  return std::clamp<std::uint64_t>(paths, 1, device.limits.capacity);
}

/// Most paths of the device's next unit, so that it ends by the time that set_latest() gave. A unit
/// takes at most half of the time left, because devices are not always as fast as they were. A unit
/// too short to be timed counts as none.
std::uint64_t Schedule::most_in_time(std::size_t device, double now_s) const {
  const DeviceState& d = devices_[device];
  if (std::isinf(latest_s_)) return d.limits.capacity;
  const double seconds = latest_s_ - free_at(device, now_s) - d.overhead_s;
  if (seconds < kShortestUnit_s) return 0;
  const double unit_s = std::max(seconds / 2, std::min(seconds, 4 * kShortestUnit_s));
  const double paths = d.path_s > 0 ? unit_s / d.path_s : double(kFirstUnit);
  return paths < double(d.limits.capacity) ? std::uint64_t(paths) : d.limits.capacity;
}

/// Paths of the next unit from the pool; 0: the image is done sooner without this device.
std::uint64_t Schedule::unit_size(std::size_t device, double now_s) {
  DeviceState& d = devices_[device];
  const auto left = double(pool_.path_count());
  const double begin_s = free_at(device, now_s);
  // When the others would have done all of it.
  const double others_s = finish_s(left, device, now_s);
  if (d.path_s == 0) {
    // A device whose rate is unknown gets nothing if the others are done before it could be.
    if (others_s < begin_s + kShortestUnit_s) return 0;
    return others_are_expected(device) ? std::min(kFirstUnit, d.limits.capacity) : d.limits.grain;
  }
  const double most_s = kLongestUnit_s / d.path_s;
  std::uint64_t most = std::min(d.limits.capacity, std::max(kGrowth * d.largest, kFirstUnit));
  if (most_s < double(most)) most = std::max<std::uint64_t>(std::uint64_t(most_s), 1);
  if (!others_take_part(device)) return most;
  const double until_s = finish_s(left, kNobody, now_s);
  // A unit occupies the whole device where that does not delay the end.
  const std::uint64_t least = std::min(std::max(least_size(d), d.limits.grain), most);
  const double share = kFactoringShare * std::max(until_s - begin_s, 0.0) / d.path_s;
  std::uint64_t size = std::clamp(share < double(most) ? std::uint64_t(share) : most, least, most);
  if (begin_s + expected_s(d, size) > until_s) {
    const double fitting = (until_s - begin_s - d.overhead_s) / d.path_s;
    const std::uint64_t small = std::max<std::uint64_t>(least / 4, 1);
    size = fitting > double(small) ? std::min(std::uint64_t(fitting), size) : small;
  }
  if (begin_s + expected_s(d, size) <= others_s) return size;
  // Another device is expected to finish this sooner. But all devices may expect that of another
  // one, because the units that they compare differ in size, and then the work would stay undone.
  // So where nothing is under way, the device takes it that is quickest for all paths that are
  // left: for one number of paths, one of the devices is the quickest.
  return in_flight_.empty() && is_quickest(device, pool_.path_count()) ? size : 0;
}

bool Schedule::is_quickest(std::size_t device, std::uint64_t paths) const {
  const double own_s = expected_s(devices_[device], paths);
  return std::none_of(devices_.begin(), devices_.end(), [&](const DeviceState& d) {
    return d.takes_part && d.path_s > 0 && expected_s(d, paths) < own_s;
  });
}

/// most: paths that the unit may have
std::optional<WorkUnit> Schedule::take_returned(std::size_t device, std::uint64_t most) {
  const bool others = others_take_part(device);
  for (auto it = returned_.begin(); it != returned_.end(); ++it) {
    if (it->from == device && others) continue;
    const Returned found = *it;
    returned_.erase(it);
    UnitPool pieces(block_);
    pieces.add(found.unit);
    const DeviceState& d = devices_[device];
    most = std::min({most, d.limits.capacity, d.path_s > 0 ? kGrowth * d.largest : kFirstUnit});
    const std::optional<WorkUnit> unit = pieces.take(most, found.unit.path_count(), block_pixels(d.limits, most));
    while (const std::optional<WorkUnit> rest = pieces.take(found.unit.path_count(), found.unit.path_count()))
      returned_.push_back({*rest, found.from});
    return unit;
  }
  return std::nullopt;
}

/// The unit of another device whose result would come sooner by the largest margin if this device
/// repeated it; 0: none.
std::uint64_t Schedule::latest_unit(std::size_t device, double now_s) const {
  const DeviceState& d = devices_[device];
  // Else it gets a small unit, which is taken to need as long as a unit may.
  const bool known = d.path_s > 0;
  const std::uint64_t most = known ? d.limits.capacity : std::min(kFirstUnit, d.limits.capacity);
  std::uint64_t best = 0;
  double best_s = 0;
  for (const auto& [id, in_flight] : in_flight_) {
    if (in_flight.device == device || in_flight.speculative_copy != 0 || in_flight.unit.path_count() > most) continue;
    if (!devices_[in_flight.device].takes_part) continue;
    if (in_flight.unit.block.pixel_count() > std::max(d.limits.least_block, d.limits.most_block)) continue;
    const double own_s = known ? expected_s(d, in_flight.unit.path_count()) : kLongestUnit_s;
    const double gain_s = end_s(in_flight.device, id, now_s) - (now_s + own_s);
    if (gain_s > std::max(best_s, kShortestUnit_s + kSpeculationMargin * own_s)) best = id, best_s = gain_s;
  }
  return best;
}

Schedule::Assignment Schedule::assign(std::size_t device, const WorkUnit& unit, double now_s) {
  const std::uint64_t id = next_id_++;
  InFlight& in_flight = in_flight_[id];
  in_flight.device = device;
  in_flight.unit = unit;
  in_flight.begin_s = now_s;
  return {id, unit};
}

std::optional<Schedule::Assignment> Schedule::next(std::size_t device, double now_s) {
  DeviceState& d = devices_[device];
  if (!d.takes_part) return std::nullopt;
  const std::uint64_t most = most_in_time(device, now_s);
  if (most == 0) return std::nullopt;
  if (const std::optional<WorkUnit> again = take_returned(device, most)) return assign(device, *again, now_s);
  if (!pool_.empty()) {
    const std::uint64_t size = std::min(unit_size(device, now_s), most);
    if (size == 0) {
      d.left_out_at = std::max(d.left_out_at, double(pool_.path_count()) / double(std::max<std::uint64_t>(opened_, 1)));
      return std::nullopt;
    }
    return assign(device, *pool_.take(size, most_samples(d.limits), block_pixels(d.limits, size)), now_s);
  }
  // The result of a copy may not count, and nothing can call it off. So only an idle device makes
  // one.
  const std::uint64_t late = is_idle(device) ? latest_unit(device, now_s) : 0;
  if (late == 0) return std::nullopt;
  const Assignment copy = assign(device, in_flight_.at(late).unit, now_s);
  in_flight_.at(late).speculative_copy = copy.id;
  in_flight_.at(copy.id).speculative_copy = late;
  return copy;
}

/// Fits t = overhead + paths * path_s through the smallest and the largest unit that were measured.
void Schedule::measure(DeviceState& d, std::uint64_t paths, double seconds) {
  seconds = std::max(seconds, 1e-9);
  // A much larger unit measures the rate more precisely than all units before, so it alone counts.
  const bool larger = paths > d.largest + d.largest / 2;
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
  const auto found = in_flight_.find(id);
  if (found == in_flight_.end()) return false;
  const InFlight in_flight = found->second;
  in_flight_.erase(found);
  // The result of the copy will not count, so nobody waits for it.
  if (in_flight.speculative_copy != 0) in_flight_.erase(in_flight.speculative_copy);
  // A device does its units one after the other, so its next one begins only now.
  for (auto& [other_id, other] : in_flight_)
    if (other.device == in_flight.device) other.begin_s = std::max(other.begin_s, now_s);
  left_ -= in_flight.unit.path_count();
  measure(devices_[in_flight.device], in_flight.unit.path_count(), now_s - begin_s);
  return true;
}

void Schedule::gave_back(std::uint64_t id) {
  const auto found = in_flight_.find(id);
  if (found == in_flight_.end()) return;
  const InFlight in_flight = found->second;
  in_flight_.erase(found);
  if (in_flight.speculative_copy != 0)
    in_flight_.at(in_flight.speculative_copy).speculative_copy = 0;
  else
    returned_.push_back({in_flight.unit, in_flight.device});
}

}  // namespace eikon
