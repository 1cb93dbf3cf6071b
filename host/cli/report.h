// SPDX-License-Identifier: Apache-2.0
// What a render tells: the stage table, --stats and --profile.
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

/// A table per device: launches, items, milliseconds in all and per launch, share, millions of items per second, and what
/// lies between the launches.
void print_stage_table(const RenderReport& report);

/// --stats; the schema is documented in report.cpp. throws InputError when the file cannot be written.
void write_stats(const std::filesystem::path& path, const RenderReport& report, const PredictedError& error,
                 const Prepared& prepared, const CommandTimes& times);

/// --profile: Chrome trace events (chrome://tracing, Perfetto), one track per device. throws InputError
void write_profile(const std::filesystem::path& path, const RenderReport& report);

/// Writes a text file under a temporary name, then renames it. throws InputError
void write_text(const std::filesystem::path& path, const std::string& text);

/// Asked before the work, not after it. Empty names are left out.
/// throws InputError for an output that cannot be made or replaced, UsageError when two have one name or one is the input
void require_writable(const std::vector<std::filesystem::path>& outputs, const std::filesystem::path& input);

}  // namespace eikon
