// SPDX-License-Identifier: Apache-2.0
// What a render reports: the stage table and --stats.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/trace.h"
#include "image/image.h"
#include "io/json_text.h"
#include "job/prepare.h"
#include "job/render_options.h"
#include "pack/features.h"
#include "render/render.h"

namespace eikon {

/// Times that only the job knows.
struct CommandTimes {
  double load_s = 0, write_s = 0, total_s = 0;
};

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

/// "predicted relMSE 1e-3 (95 %: 9e-4 to 1.1e-3)", or what can be said instead.
[[nodiscard]] std::string in_words(const PredictedError& error);
[[nodiscard]] std::string in_words(const PilotReport& pilot);
/// "3 samples were rejected (2 not finite, ...". all: the rejected samples of this run and, by the film's counts, of the runs
/// before it
[[nodiscard]] std::string rejected_line(const RenderReport& report, std::uint64_t all);
/// "12 rays gave up the search for surface 'gyroid' after 4096 steps, ..."
[[nodiscard]] std::string given_up_line(const Scene& scene, const RenderReport& report);

/// count / seconds, or 0 when no time has passed.
[[nodiscard]] double per_second(double count, double seconds);

/// Facts that a report states beside the results of the render.
struct RenderFacts {
  std::string command;  // as the user gave it
  std::map<std::string, std::uint64_t> contents;  // of the scene: how many it has of what
  std::vector<FeatureEntry> features;
};

/// The facts of a scene and its settings, to be found before the render frees the scene's meshes.
[[nodiscard]] RenderFacts facts_of(const Prepared& prepared, const Execution& execution, const std::string& command);

inline constexpr int kStatsSchemaVersion = 2;  // of stats_schema.json

/// The contents of the file that --stats writes; stats_schema.json is their schema.
[[nodiscard]] Json stats_json(const RenderOutput& done, const PredictedError& error, const Prepared& prepared,
                              const CommandTimes& times, const RenderFacts& facts);
/// Writes --stats. throws InputError when the file cannot be written
void write_stats(const std::filesystem::path& path, const Json& stats);

struct ReportPicture {
  const Film& film;
  const Image* denoised = nullptr;  // shown instead of the film's R, G and B; null: there is none
  const PngOptions& look;           // the exposure and tone curve with which the page shows the picture first
};

/// Writes --report: a page that needs no other file.
/// trace  after Trace::end()
/// throws InputError when the file cannot be written
void write_report(const std::filesystem::path& path, const Json& stats, const ReportPicture& picture,
                  const Trace& trace);

/// Writes a text file as AtomicFile does: "-" is standard output. throws InputError
void write_text(const std::filesystem::path& path, const std::string& text);

/// Checks before the work that its outputs can be written. Empty names are left out.
/// throws InputError for an output that cannot be made or replaced; UsageError if two have the same
///        name, or one is the input
void require_writable(const std::vector<std::filesystem::path>& outputs, const std::filesystem::path& input);

/// Writes --profile as Chrome trace events, for Perfetto or chrome://tracing. Times are
/// microseconds since the command began to measure.
///   "M"  names a track, or notes that detail was left out
///   "X"  is a span. The spans of a track nest and follow each other. One that stands for several
///   has
///        the name of the longest kind, and args {"spans": how many, "busy_ms": their sum,
///        "ms": {name: milliseconds}}
///   "C"  is a counter, with args {"value"}: rates and live paths are means until the next event of
///        that name, and the last value is 0
/// throws InputError
void write_trace(const std::filesystem::path& path, const Trace& trace);
/// The same events as an array.
[[nodiscard]] Json trace_events(const Trace& trace);

}  // namespace eikon
