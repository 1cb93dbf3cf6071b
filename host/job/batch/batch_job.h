// SPDX-License-Identifier: Apache-2.0
// The jobs of a batch, read and checked before any of them runs.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "job/render_options.h"
#include "core/error.h"

namespace eikon {

/// The states of a job. A job is `skipped` if an earlier run of the batch has done it.
enum class JobState { waiting, skipped, done, failed, interrupted };
[[nodiscard]] const char* name_of(JobState state);

/// A render of a batch: a line of the jobs file, or a frame of one.
struct BatchJob {
  std::size_t line = 0;                    // in the jobs file, from 1; 0: there is none
  std::optional<std::uint64_t> frame{};    // of --frames
  std::string text{};                      // its words, quoted
  std::vector<std::string> words{};        // those that follow `eikon render`
  std::optional<RenderOptions> options{};  // nullopt: the line does not parse
  double cost = 0;                         // pixels times samples, roughly
  std::vector<std::size_t> writers{};      // indices of the jobs before it that write what it reads
  int attempts = 0;                        // renders that were begun

  JobState state = JobState::waiting;
  ExitCode code = ExitCode::done;
  std::string message{};  // why it failed
  double seconds = 0, render_s = 0;
  std::uint64_t samples = 0;
  std::optional<double> relmse{};
};

/// Reads the words behind `eikon render`. throws UsageError
using ParseRender = std::function<RenderOptions(std::vector<std::string>)>;

/// Parses every line of `text`. Jobs whose line does not parse have failed, with a message. A line
/// with --frames becomes a job for each frame.
[[nodiscard]] std::vector<BatchJob> read_jobs(std::string_view text, const ParseRender& parse);

/// The jobs of the frames that `options` ask for. line: of the jobs file, or 0
/// throws UsageError: a name without a place for the frame's number
[[nodiscard]] std::vector<BatchJob> read_frames(const RenderOptions& options, std::size_t line,
                                                const ParseRender& parse);

/// "jobs.txt:3", "jobs.txt:3, frame 12", or without a jobs file "line 3" or "frame 12", for
/// messages.
[[nodiscard]] std::string label_of(const BatchJob& job, const std::string& jobs_file = {});

/// Checks that the jobs' outputs do not collide, and sets `writers`.
/// name      the name of the jobs file, for messages
/// reserved  files that no job may write: the jobs file, the ledger
/// throws UsageError if two jobs write the same file, or a job writes a reserved file or one that
///        it reads itself
void check_outputs(std::vector<BatchJob>& jobs, const std::string& name,
                   const std::vector<std::filesystem::path>& reserved);

/// At most 300 bytes of a text, for messages: a line of a batch may have megabytes.
[[nodiscard]] std::string shortened(const std::string& text);

/// The name of a file in the ledger: relative if it lies below the current folder, else absolute.
[[nodiscard]] std::string ledger_name(const std::filesystem::path& file);

}  // namespace eikon
