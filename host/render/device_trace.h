// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "core/trace.h"
#include "device/device.h"
#include "wavefront/wavefront.h"

namespace eikon {

/// The tracks of one device in a trace: its queue, the host thread that feeds it and, where it has
/// memory of its own, the transfers beside its work; and its rays per second. With a null trace it
/// does nothing.
class DeviceTrace {
 public:
  DeviceTrace(Trace* trace, const DeviceInfo& info);
  [[nodiscard]] Trace::Track thread() const { return thread_; }
  [[nodiscard]] Trace::Track queue() const { return queue_; }
  [[nodiscard]] Trace::Track beside() const { return beside_; }
  /// so_far: rays of all units so far; the first unit began at begin_s, the last one ended at now_s
  void count_rays(const RayCounts& so_far, double begin_s, double now_s);

 private:
  Trace* trace_;
  Trace::Track thread_ = 0, queue_ = 0, beside_ = 0;
  std::string rate_;
  double counted_s_ = 0;
  std::uint64_t counted_ = 0;
};

}  // namespace eikon
