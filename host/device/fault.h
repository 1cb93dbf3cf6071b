// SPDX-License-Identifier: Apache-2.0
// Faults on purpose, for tests of what happens when a device fails: the variable EIKON_FAULT says which.
//
//   EIKON_FAULT=device:POSITION[:after=UNITS][:above=PATHS][:times=COUNT][:KIND][;device:...]
//
//   POSITION  of the device among those selected, from 0
//   after     so many work units go through first; default 0. Units are counted over all openings of the device.
//   above     only units of more than so many paths are hit; default 0
//   times     so many units are hit, then the device works again; default: it never does
//   KIND      error   (default) launches fail with CL_OUT_OF_RESOURCES
//             oom     without `after`, memory cannot be allocated; else launches fail for want of memory
//             lost    every call fails, opening the device again included; without `after`, it cannot even be opened once
//             hang    the call that launches the unit never returns, and neither does any later one
//             slow=F  the device takes F times as long for everything; takes neither after nor above nor times
//             wrong   what is read back from the device is wrong in one bit of each transfer
//             gpu     no fault: a CPU device is driven as a GPU is
//
// For example device:1:after=3 or device:0:slow=10;device:1:times=1:oom:after=2. Without the variable a device does not
// even have a Fault.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace eikon {

struct FaultPlan {
  enum class Kind { error, oom, lost, hang, slow, wrong, gpu };
  std::uint32_t device = 0;  // position among those selected
  Kind kind = Kind::error;
  std::optional<std::uint64_t> after;                               // work units
  std::uint64_t above = 0;                                          // paths of a unit
  std::uint64_t times = std::numeric_limits<std::uint64_t>::max();  // units
  double factor = 1;                                                // of slow; at least 1
};

/// What EIKON_FAULT says. throws UsageError
[[nodiscard]] std::vector<FaultPlan> parse_faults(const std::string& text);

/// The faults of one device, and how far it has come; lives as long as the selection that the device is of, so that a lost
/// device stays lost. For any number of threads.
class Fault {
 public:
  enum class Call { open, allocate, launch, transfer, wait };

  explicit Fault(std::vector<FaultPlan> plans);
  /// The device is to be taken for a GPU.
  [[nodiscard]] bool acts_as_gpu() const;
  /// It is nothing but that: the device does not fail.
  [[nodiscard]] bool is_harmless() const;
  /// The next launch begins a work unit of so many paths.
  void begin_unit(std::uint64_t paths);
  /// Every call of the device comes through here first. returns the OpenCL code that it is to fail with, or 0
  [[nodiscard]] int at(Call call);
  /// The device was busy for so long, until now at the latest: sleeps for what it lacks to be as slow as planned. What it did meanwhile
  /// counts as done after that.
  void slow_down(double busy_s);
  /// Spoils what was read, if planned.
  void spoil(void* data, std::size_t bytes) const;

 private:
  [[nodiscard]] int fail(FaultPlan& plan);

  std::vector<FaultPlan> plans_;
  mutable std::mutex mutex_;
  std::uint64_t units_ = 0, paths_ = 0;  // units begun, and of the last one
  bool begins_ = false;                  // a unit, whose first launch is yet to come
  bool lost_ = false;
  double slow_until_s_ = 0;  // host_seconds(): when a device that slow had done all that was told
  std::atomic<bool> hung_ = false;
};

}  // namespace eikon
