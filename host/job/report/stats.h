// SPDX-License-Identifier: Apache-2.0
// The contents of --stats, which the page of --report shows, too.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "io/json_text.h"
#include "job/prepare.h"
#include "pack/features.h"
#include "render/render.h"

namespace eikon {

/// Seconds that only the job knows, since a render neither loads nor writes.
struct CommandTimes {
  double load_s = 0, write_s = 0;
  double total_s = 0;  // from the begin of the command, or of the job
};

/// Facts that a report states beside the results of the render.
struct RenderFacts {
  std::string command;                            // as the user gave it
  std::map<std::string, std::uint64_t> contents;  // of the scene: how many it has of what
};

/// The facts of a scene, to be found before the render frees the scene's meshes.
[[nodiscard]] RenderFacts facts_of(const Prepared& prepared, const std::string& command);

inline constexpr int kStatsSchemaVersion = 2;  // of stats_schema.json

/// The contents of the file that --stats writes; stats_schema.json is their schema.
[[nodiscard]] Json stats_json(const RenderOutput& done, const PredictedError& error, const Prepared& prepared,
                              const CommandTimes& times, const RenderFacts& facts);
/// Writes --stats. throws InputError when the file cannot be written
void write_stats(const std::filesystem::path& path, const Json& stats);

}  // namespace eikon
