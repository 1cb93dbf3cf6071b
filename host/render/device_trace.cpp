// SPDX-License-Identifier: Apache-2.0
#include "render/device_trace.h"

#include <fmt/format.h>

#include <algorithm>

namespace eikon {

DeviceTrace::DeviceTrace(Trace* trace, const DeviceInfo& info) : trace_(trace) {
  if (trace_ == nullptr) return;
  thread_ = trace_->add_track(fmt::format("device {}: host thread", info.selector));
  queue_ = trace_->add_track(fmt::format("device {}: queue of {}", info.selector, info.name));
  if (!info.cpu) beside_ = trace_->add_track(fmt::format("device {}: read back beside it", info.selector));
  rate_ = fmt::format("Mrays/s, device {}", info.selector);
}

void DeviceTrace::count_rays(const RayCounts& so_far, double begin_s, double now_s) {
  if (trace_ == nullptr) return;
  const double from_s = std::max(counted_s_, begin_s);
  if (now_s <= from_s) return;
  trace_->count(rate_, from_s, now_s, 1e-6 * double(so_far.total() - counted_) / (now_s - from_s));
  counted_s_ = now_s;
  counted_ = so_far.total();
}

}  // namespace eikon
