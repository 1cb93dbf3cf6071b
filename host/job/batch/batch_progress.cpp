// SPDX-License-Identifier: Apache-2.0
#include "job/batch/batch_progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "job/log.h"
#include "core/clock.h"

namespace eikon {

BatchProgress::BatchProgress(const std::vector<BatchJob>& jobs, bool bar, bool openjd)
    : bar_(bar && isatty(STDERR_FILENO) != 0), openjd_(openjd), begin_s_(host_seconds()) {
  for (const BatchJob& job : jobs) {
    if (!job.options) continue;
    total_ += job.cost;
    ++jobs_;
  }
}

void BatchProgress::show(const BatchJob& job, double fraction) {
  const std::lock_guard lock(mutex_);
  in_hand_[&job] = fraction;
  draw();
}

void BatchProgress::end(const BatchJob& job) {
  const std::lock_guard lock(mutex_);
  in_hand_.erase(&job);
  if (job.state == JobState::interrupted) return;
  over_ += job.cost;
  if (job.state == JobState::done) rendered_ += job.cost;
  ++jobs_over_;
  draw();
}

void BatchProgress::again(const BatchJob& job) {
  const std::lock_guard lock(mutex_);
  in_hand_.erase(&job);
}

void BatchProgress::log(const std::string& line) {
  const std::lock_guard lock(mutex_);
  erase();
  print_to_stderr("eikon: {}\n", printable(line));
}

void BatchProgress::clear() {
  const std::lock_guard lock(mutex_);
  erase();
}

void BatchProgress::close(ExitCode code) {
  const std::lock_guard lock(mutex_);
  erase();
  if (code == ExitCode::done || code == ExitCode::not_as_asked) openjd_.progress(1);
  if (code == ExitCode::not_as_asked) openjd_.fail("some jobs failed; see the table");
}

void BatchProgress::erase() {
  if (shown_) print_to_stderr("\r\x1b[K");
  shown_ = false;
}

void BatchProgress::draw() {
  double now = 0;
  std::string names;
  for (const auto& [job, fraction] : in_hand_) {
    now += job->cost * fraction;
    names += (names.empty() ? "" : ", ") + printable(job->options->exr().filename().string());
  }
  const double done = total_ > 0 ? (over_ + now) / total_ : 1;
  const double seconds = host_seconds() - begin_s_;
  openjd_.status(fmt::format("{} of {} jobs", jobs_over_, jobs_));
  openjd_.progress(done);
  if (!bar_) return;
  constexpr int width = 24;
  const int filled = std::clamp(int(done * width), 0, width);
  const double rate =
      seconds > 0 ? (rendered_ + now) / seconds : 0;  // samples per second, all costs of a batch included
  print_to_stderr("\r\x1b[K[{:=<{}}{:{}}] {:3.0f} %  {} of {} jobs  {:.2f} Msamples/s  {} left  {}", "", filled, "",
       width - filled, 100 * done, jobs_over_, jobs_, 1e-6 * rate,
       rate > 0 ? fmt::format("{:.0f} s", std::max(0.0, total_ - over_ - now) / rate) : "?", names);
  std::fflush(stderr);
  shown_ = true;
}

namespace {

/// "3", of frame 12 of a line "3:12", and "12" of frames without a line.
std::string number_of(const BatchJob& job) {
  if (!job.frame) return fmt::format("{}", job.line);
  return job.line == 0 ? fmt::format("{}", *job.frame) : fmt::format("{}:{}", job.line, *job.frame);
}

}  // namespace

void print_summary(const std::vector<BatchJob>& jobs, double seconds) {
  const bool frames = std::ranges::all_of(jobs, [](const BatchJob& job) { return job.line == 0; });
  fmt::print("{:>6}  {:<11} {:>9} {:>11}  {:<9}  {}\n", frames && !jobs.empty() ? "frame" : "line", "state", "seconds", "Msamples/s", "relMSE", "output");
  std::size_t counts[5] = {};
  for (const BatchJob& job : jobs) {
    ++counts[std::size_t(job.state)];
    const bool rendered = job.render_s > 0;
    fmt::print("{:>6}  {:<11} {:>9} {:>11}  {:<9}  {}{}\n", number_of(job), name_of(job.state),
               job.seconds > 0 ? fmt::format("{:.2f}", job.seconds) : "-",
               rendered ? fmt::format("{:.2f}", 1e-6 * double(job.samples) / job.render_s) : "-",
               job.relmse ? fmt::format("{:.3e}", *job.relmse) : "-",
               job.options ? printable(job.options->exr().string()) : printable(shortened(job.text)),
               job.message.empty() ? "" : (job.options || !job.text.empty() ? ": " : "") + printable(job.message));
  }
  std::string line;
  for (const JobState state :
       {JobState::done, JobState::skipped, JobState::failed, JobState::interrupted, JobState::waiting})
    if (counts[std::size_t(state)] > 0)
      line += fmt::format("{}{} {}", line.empty() ? "" : ", ", counts[std::size_t(state)], name_of(state));
  fmt::print("{} {} in {:.2f} s: {}\n", jobs.size(), frames && !jobs.empty() ? "frames" : "jobs", seconds, line.empty() ? "nothing to do" : line);
}

}  // namespace eikon
