// SPDX-License-Identifier: Apache-2.0
// What a render tells: the stage table and --stats.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "cli/scene_options.h"
#include "render/render.h"

namespace eikon {

/// Times that only the command knows.
struct CommandTimes {
  double load_s = 0, write_s = 0, total_s = 0;
};

/// A table per device: launches, items, milliseconds in all and per launch, share, millions of items per second, bytes, what
/// lies between the launches, and how full lanes and queues are at each bounce; of several devices also a line each.
void print_stage_table(const RenderReport& report);
/// One line: where all the time went.
void print_times(const RenderReport& report, const CommandTimes& times);

/// Names of stages: kernels in the order of the wavefront, then transfers.
[[nodiscard]] std::vector<std::string> stage_order(const std::map<std::string, StageTotals>& stages);
/// All that a stage's launches took: of `paths` with what is booked on the stages that ran within them.
[[nodiscard]] double launched_seconds(const std::map<std::string, StageTotals>& stages, const std::string& name);
/// For how long others still rendered when the device had done its last unit; 0 if it had none.
[[nodiscard]] double idle_at_end_s(const RenderReport& report, const DeviceReport& device);

/// --stats; stats_schema.json is its schema. throws InputError when the file cannot be written.
void write_stats(const std::filesystem::path& path, const RenderReport& report, const PredictedError& error,
                 const Prepared& prepared, const CommandTimes& times);

/// Writes a text file under a temporary name, then renames it. throws InputError
void write_text(const std::filesystem::path& path, const std::string& text);

/// Asked before the work, not after it. Empty names are left out.
/// throws InputError for an output that cannot be made or replaced, UsageError when two have one name or one is the input
void require_writable(const std::vector<std::filesystem::path>& outputs, const std::filesystem::path& input);

}  // namespace eikon
