// SPDX-License-Identifier: Apache-2.0
// The stage table of a render on stdout, and the figures of stages that --stats has, too.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "job/report/stats.h"
#include "render/render.h"

namespace eikon {

/// Prints a table per device: launches, items, milliseconds in all and per launch, share, millions
/// of items per second, bytes, the gaps between launches, and how full lanes and queues are at each
/// bounce. Several devices have a line each.
void print_stage_table(const RenderReport& report);
/// Prints the seconds of each step of the command in one line.
void print_times(const RenderReport& report, const CommandTimes& times);

/// The names of the stages: kernels in the order of the wavefront, then transfers.
[[nodiscard]] std::vector<std::string> stage_order(const std::map<std::string, StageTotals>& stages);
/// The seconds of a stage's launches. Those of `paths` include the stages that ran within them.
[[nodiscard]] double launched_seconds(const std::map<std::string, StageTotals>& stages, const std::string& name);
/// Seconds that other devices still rendered after this one's last unit; 0 if it had none.
[[nodiscard]] double idle_at_end_s(const RenderReport& report, const DeviceReport& device);

}  // namespace eikon
