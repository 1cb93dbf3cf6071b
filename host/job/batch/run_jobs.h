// SPDX-License-Identifier: Apache-2.0
// A batch from its jobs to its table: of a file of jobs, or of the frames of a sequence.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "job/batch/batch_run.h"

namespace eikon {

/// How the progress of all jobs together is shown.
struct BatchDisplay {
  bool quiet = false;
  std::string progress = "bar";  // or "openjd"
  std::string report{};   // page that is written at the end; empty: none
  std::string command{};  // as the user gave it, for the page
};

/// Runs jobs that check_outputs has let pass, and prints a table of them. Signals stop it.
/// ledger  file of what became of each job; empty: none is kept
/// throws InputError if the ledger cannot be read or another process has it
[[nodiscard]] ExitCode run_jobs(std::vector<BatchJob>& jobs, const BatchSettings& settings,
                                const std::filesystem::path& ledger, const BatchDisplay& display);

/// Renders the frames that `options` ask for, each as a job of its own. Those that are done already
/// are skipped. The ledger stands beside the images: walk_%04d.exr has walk_frames.ledger, and
/// walk/%04d/a.exr has walk/a_frames.ledger.
/// throws UsageError: names without a place for the frame's number, or that collide; InputError as
/// run_jobs
[[nodiscard]] ExitCode run_frames(const RenderOptions& options, const ParseRender& parse);

}  // namespace eikon
