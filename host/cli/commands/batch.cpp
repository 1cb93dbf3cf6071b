// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <iterator>
#include <memory>

#include "cli/commands.h"
#include "cli/flags.h"
#include "io/atomic_file.h"
#include "io/source_file.h"
#include "job/batch/shell_words.h"
#include "job/batch/run_jobs.h"
#include "job/batch/jobs_json.h"
#include "job/file_identity.h"
#include "job/stop_signals.h"

namespace eikon {
namespace {

namespace fs = std::filesystem;

struct BatchOptions {
  std::string jobs, ledger, report, progress = "bar";
  std::uint32_t parallel = 1, retries = 0;
  bool force = false, quiet = false, list = false;
};

constexpr std::uint64_t kMaxJobsBytes = std::uint64_t{256} << 20;

std::string read_text(const std::string& file) {
  if (file == "-") return {std::istreambuf_iterator<char>(std::cin), {}};
  try {
    const Bytes bytes = read_regular_file(file, kMaxJobsBytes);
    return {reinterpret_cast<const char*>(bytes.data.get()), bytes.size};
  } catch (const InputError& error) {
    std::error_code none;
    if (fs::is_regular_file(file, none) && fs::file_size(file, none) == 0) return {};  // no jobs
    throw InputError(fmt::format("{}: {}", file, error.what()));
  }
}

/// Enters the folder of the jobs file, so that paths are relative to it. Environment variables with
/// relative paths keep their meaning.
void enter_folder(const fs::path& jobs) {
  const fs::path folder = fs::absolute(jobs).parent_path();
  const auto make_absolute = [](const char* name, const char* path) {
    setenv(name, fs::absolute(path).lexically_normal().c_str(), 1);
  };
  for (const char* name : {"EIKON_KERNEL_DIR", "EIKON_DUMP_PROGRAMS", "POCL_CACHE_DIR", "XDG_CACHE_HOME"})
    if (const char* path = std::getenv(name); path != nullptr && *path != '\0') make_absolute(name, path);
  std::error_code error;
  // These may also be bare names, which the loader searches for elsewhere.
  for (const char* name : {"OCL_ICD_VENDORS", "OCL_ICD_FILENAMES", "EIKON_OIDN"}) {
    const char* const path = std::getenv(name);
    if (path == nullptr || !fs::exists(path, error)) continue;
    if (fs::is_directory(path, error) || std::string_view(path).find('/') != std::string_view::npos)
      make_absolute(name, path);
  }
  fs::current_path(folder, error);
  if (error) throw InputError(fmt::format("{}: cannot enter its folder: {}", jobs.string(), error.message()));
}

ExitCode list_jobs(const std::vector<BatchJob>& jobs) {
  fmt::print("{}", to_json_lines(jobs));
  const auto is_wrong = [](const BatchJob& job) { return !job.options; };
  return std::ranges::any_of(jobs, is_wrong) ? ExitCode::not_as_asked : ExitCode::done;
}

ExitCode batch_command(BatchOptions options, const std::vector<std::string>& words) {
  receive_signals();
  require_writable({options.report}, {.files = {options.jobs}});
  if (!options.report.empty() && options.report != kStandardOutput) options.report = fs::absolute(options.report).string();
  const bool from_pipe = options.jobs == "-";
  const std::string name = from_pipe ? "stdin" : options.jobs;
  std::vector<BatchJob> jobs = read_jobs(read_text(options.jobs), parse_render);
  const fs::path jobs_file = from_pipe ? fs::path() : fs::absolute(options.jobs);
  fs::path ledger_file;
  if (!options.ledger.empty())
    ledger_file = fs::absolute(options.ledger);
  else if (!from_pipe)
    ledger_file = jobs_file.string() + ".ledger";
  if (!from_pipe) enter_folder(jobs_file);
  check_outputs(jobs, name, {jobs_file, ledger_file, options.report});
  if (options.list) return list_jobs(jobs);

  return run_jobs(jobs, {name, options.parallel, int(options.retries), options.force}, ledger_file,
                  {.quiet = options.quiet,
                   .progress = options.progress,
                   .report = options.report,
                   .command = "eikon batch " + quote(words)});
}

}  // namespace

void add_batch(CommandFlags& root, Command& chosen) {
  auto options = std::make_shared<BatchOptions>();
  CommandFlags flags = root.command(
      "batch", "render many images: one render command per line of a file",
      "A line is what follows `eikon` on a command line: render SCENE [flags], quoted as for a shell; nothing is "
      "expanded.\n"
      "# begins a comment. Paths are relative to the file's folder. A job whose inputs, settings and outputs are as "
      "they\n"
      "were when it was done is skipped. A job that fails, or does not parse, does not stop the others: exit code 1.\n"
      "An interrupted batch continues where it was when it is started again.\n\n"
      "Example:\n  eikon batch jobs.txt --retry 1\n\n" +
          environment_help());
  flags.text({"JOBS", "", "text file; - is standard input"}, options->jobs);
  flags.group("Devices");
  flags.number({"--jobs-parallel", "N", "jobs at a time, each with memory for a scene of its own [1]"},
               options->parallel, 1, 64);
  flags.group("Output");
  flags.text({"--ledger", "FILE", "JSON lines of what became of each job [JOBS.ledger; none for standard input]"},
             options->ledger);
  flags.number({"--retry", "N", "how often a failed job is tried again, after the others [0]"}, options->retries, 0,
               1000);
  flags.toggle("--force", "also render what is already done", options->force);
  flags.group("Diagnosis");
  flags.choice({"--progress", "HOW", "bar, on a terminal; openjd: lines on stdout for Open Job Description [bar]"},
               options->progress, {"bar", "openjd"});
  flags.toggle("--quiet", "print no progress", options->quiet);
  flags.text({"--report", "FILE.html", "write a page with a row for each job, at the end"}, options->report);
  flags.toggle("--list", "print a line of JSON for each job, with its key and words, and render nothing", options->list);
  flags.run(chosen, [options](const std::vector<std::string>& words) { return batch_command(*options, words); });
}

}  // namespace eikon
