// SPDX-License-Identifier: Apache-2.0
#include "job/batch/run_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/clock.h"
#include "io/atomic_file.h"
#include "job/sequence/frames.h"
#include "job/stop_signals.h"
#include "page/report_page.h"

namespace eikon {
namespace {

namespace fs = std::filesystem;

bool failed(const BatchJob& job) { return job.state == JobState::failed; }

/// The ledger stands beside the images, or where each has a folder of its own, above those.
fs::path ledger_of_frames(const std::string& output) {
  const fs::path file(output);
  fs::path folder = file.parent_path();
  while (has_number(folder.string())) folder = folder.parent_path();
  std::string name = file.stem().string();
  name = name.substr(0, name.find('%'));
  return folder / (name + (name.empty() || name.back() == '_' || name.back() == '.' ? "" : "_") + "frames.ledger");
}

std::string page_of(const std::vector<BatchJob>& jobs, const std::string& name, const std::string& command,
                    double seconds) {
  const auto known = [](bool is_known, const auto& value) { return is_known ? Json(value) : Json(nullptr); };
  Json rows = Json::array();
  for (const BatchJob& job : jobs)
    rows.push_back({{"line", job.line},
                    {"frame", known(job.frame.has_value(), job.frame.value_or(0))},
                    {"state", name_of(job.state)},
                    {"command", job.text},
                    {"output", known(job.options.has_value(), job.options ? job.options->exr().string() : "")},
                    {"seconds", known(job.seconds > 0, job.seconds)},
                    {"render_seconds", known(job.render_s > 0, job.render_s)},
                    {"samples", known(job.render_s > 0, job.samples)},
                    {"relmse", known(job.relmse.has_value(), job.relmse.value_or(0))},
                    {"message", job.message}});
  return batch_page({{"name", name},
                     {"command", command},
                     {"version", "eikon " EIKON_VERSION},
                     {"seconds", seconds},
                     {"jobs", std::move(rows)}});
}

}  // namespace

ExitCode run_jobs(std::vector<BatchJob>& jobs, const BatchSettings& settings, const fs::path& ledger_file,
                  const BatchDisplay& display) {
  Ledger ledger(ledger_file, settings.name.empty() ? "choose another folder with -o" : "choose another with --ledger");
  BatchProgress progress(jobs, !display.quiet && display.progress == "bar", display.progress == "openjd");
  if (ledger.unreadable() > 0)
    progress.log(fmt::format("{}: {} lines cannot be read and do not count: their jobs run again", ledger_file.string(),
                             ledger.unreadable()));
  for (const BatchJob& job : jobs)
    if (!job.options) progress.log(fmt::format("{}: {}", label_of(job, settings.name), job.message));

  const std::atomic<bool>& stop = catch_stop_signals();
  const double begin = host_seconds();
  BatchRun run(jobs, settings, ledger, progress, stop);
  run.run();
  const bool as_asked = std::ranges::none_of(jobs, failed) && run.ledger_is_whole();
  const ExitCode code = stop ? stop_exit_code() : as_asked ? ExitCode::done : ExitCode::not_as_asked;
  progress.close(code);
  const double seconds = host_seconds() - begin;
  print_summary(jobs, seconds);
  if (!display.report.empty()) write_text(display.report, page_of(jobs, settings.name, display.command, seconds));
  return code;
}

ExitCode run_frames(const RenderOptions& options, const ParseRender& parse) {
  std::vector<BatchJob> jobs = read_frames(options, 0, parse);
  const fs::path ledger = ledger_of_frames(jobs.front().options ? jobs.front().options->frame_pattern : options.output);
  check_outputs(jobs, "", {ledger});
  const ExitCode code = run_jobs(jobs, {.name = ""}, ledger, {.quiet = options.quiet, .progress = options.progress});
  // What is wrong with all of them, such as a scene that is not there, has its own code.
  const bool same = code == ExitCode::not_as_asked && std::ranges::all_of(jobs, [&](const BatchJob& job) {
                      return failed(job) && job.code == jobs.front().code;
                    });
  return same ? jobs.front().code : code;
}

}  // namespace eikon
