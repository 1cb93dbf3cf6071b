// SPDX-License-Identifier: Apache-2.0
// Makes devices fail on purpose, for tests. The environment variable EIKON_FAULT lists the faults:
//
//   EIKON_FAULT=device:POSITION[:after=UNITS][:above=PATHS][:times=COUNT][:KIND][;device:...]
//
//   POSITION  of the device among those selected, from 0
//   after     so many work units succeed first; default 0. All openings of the device count.
//   above     only units of more than so many paths fail; default 0
//   times     so many units fail, then the device works again; default: it never does
//   KIND      error   (default) launches fail with CL_OUT_OF_RESOURCES
//             oom     without `after`, allocations fail; with it, launches fail for want of memory
//             lost    every call fails, and so does opening the device again; without `after`, it
//                     cannot even be opened once
//             hang    the call that launches the unit never returns, and neither does any later one
//             stall   the same between units: the call that waits for all of the device's work, of
//                     which opening has some, never returns
//             slow=F  everything takes F times as long; after, above and times do not apply
//             wrong   one bit of each transfer from the device is wrong
//             gpu     no fault: a CPU device is treated like a GPU
//
// For example device:1:after=3 or device:0:slow=10;device:1:times=1:oom:after=2. Without the
// variable devices have no Fault object.
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
  enum class Kind { error, oom, lost, hang, stall, slow, wrong, gpu };
  std::uint32_t device = 0;  // position among those selected
  Kind kind = Kind::error;
  std::optional<std::uint64_t> after;                               // work units
  std::uint64_t above = 0;                                          // paths of a unit
  std::uint64_t times = std::numeric_limits<std::uint64_t>::max();  // units
  double factor = 1;                                                // of `slow`; at least 1
};

/// Parses EIKON_FAULT. throws UsageError
[[nodiscard]] std::vector<FaultPlan> parse_faults(const std::string& text);

/// The faults of one device and the units that it has begun. It lives as long as the selection of
/// devices, so that a lost device stays lost. Any number of threads may call it.
class Fault {
 public:
  /// finish: waits for all work, where wait needs only some
  enum class Call { open, allocate, launch, transfer, wait, finish };

  explicit Fault(std::vector<FaultPlan> plans);
  /// The device is to be treated like a GPU.
  [[nodiscard]] bool acts_as_gpu() const;
  /// No plan makes the device fail; one may make it act as a GPU.
  [[nodiscard]] bool is_harmless() const;
  /// The next launch begins a work unit of so many paths.
  void begin_unit(std::uint64_t paths);
  /// To be called before every call of the device.
  /// returns  the OpenCL code of the planned failure, or 0
  [[nodiscard]] int at(Call call);
  /// Sleeps as long as a device that is as slow as planned would still take for work that kept this
  /// one busy for busy_s. Work that the device does meanwhile counts as done after that.
  void slow_down(double busy_s);
  /// Flips a bit of data that was read, if planned.
  void spoil(void* data, std::size_t bytes) const;

 private:
  [[nodiscard]] int fail(FaultPlan& plan);

  std::vector<FaultPlan> plans_;
  mutable std::mutex mutex_;
  std::uint64_t units_ = 0, paths_ = 0;  // units begun; paths of the last one
  bool begins_ = false;                  // a unit has begun whose first launch is yet to come
  bool lost_ = false;
  double slow_until_s_ = 0;  // host_seconds() when a device that slow would have done all its work
  std::atomic<bool> hung_ = false;
};

}  // namespace eikon
