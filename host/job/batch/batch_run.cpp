// SPDX-License-Identifier: Apache-2.0
#include "job/batch/batch_run.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <future>
#include <new>
#include <thread>

#include "core/clock.h"
#include "job/batch/job_key.h"
#include "io/source_file.h"
#include "job/report/metadata.h"

namespace eikon {
namespace {

// Scenes that may be needed again take at most one part in so many of the machine's memory.
constexpr std::uint64_t kMemoryShare = 8;

std::uint64_t scene_budget(const std::vector<BatchJob>& jobs, std::size_t workers) {
  std::uint64_t budget = usable_memory_bytes() / kMemoryShare;
  for (const BatchJob& job : jobs)
    if (job.options && job.options->execution.memory_bytes > 0)
      budget = std::min(budget, job.options->execution.memory_bytes / kMemoryShare);
  return budget / std::max<std::size_t>(1, workers);
}

std::string time_now() { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))); }

}  // namespace

/// Renders one job at a time, with scenes and devices of its own.
struct BatchRun::Worker {
  SceneCache scenes;
  DevicePrefetcher devices;
  Worker(std::uint64_t budget_bytes, const DevicePool& known) : scenes(budget_bytes), devices(known) {}
  bool busy = false;  // has a job
};

/// A job between its preparation and its end.
struct BatchRun::JobInHand {
  BatchJob& job;
  double begin_s = host_seconds();    // moved forward by the time that it waited for its turn
  double prepared_s = 0;              // seconds that its preparation took
  std::string key{};                  // job_key()
  Digest scene{};                     // of the scene's files
  std::optional<RenderJob> render{};  // none before its inputs are read, and once it is over
  bool loaded = false;                // its scene is in memory; a large one is loaded only when it is rendered
  bool over = false;                  // close() or fail() was called
};

BatchRun::BatchRun(std::vector<BatchJob>& jobs, const BatchSettings& settings, Ledger& ledger, BatchProgress& progress,
                   const std::atomic<bool>& stop)
    : jobs_(jobs), settings_(settings), ledger_(ledger), progress_(progress), stop_(stop) {
  for (BatchJob& job : jobs_)
    if (job.state == JobState::waiting) waiting_.push_back(&job);
}

std::string BatchRun::place(const BatchJob& job) const { return label_of(job, settings_.name); }

void BatchRun::run() {
  const std::size_t count = std::clamp<std::size_t>(waiting_.size(), 1, settings_.parallel);
  const std::uint64_t budget = scene_budget(jobs_, count);
  const DevicePool known;  // a device that hangs for one of them does so for all
  std::deque<Worker> workers;
  for (std::size_t i = 0; i < count; ++i) workers.emplace_back(budget, known);
  idle_ = count;
  std::vector<std::jthread> threads;
  try {
    for (Worker& worker : workers) threads.emplace_back([&] { work(worker); });
  } catch (...) {
    end_early(std::current_exception());
  }
  for (std::jthread& thread : threads) thread.join();
  if (failure_ != nullptr) std::rethrow_exception(failure_);
}

void BatchRun::work(Worker& worker) {
  try {
    work_on_jobs(worker);
  } catch (...) {  // it would end the process
    end_early(std::current_exception());
  }
}

void BatchRun::end_early(std::exception_ptr failure) {
  const std::lock_guard lock(mutex_);
  if (failure_ == nullptr) failure_ = std::move(failure);
  changed_.notify_all();
}

void BatchRun::work_on_jobs(Worker& worker) {
  const auto begin_to_prepare = [&](BatchJob* job) {
    return job == nullptr
               ? std::future<std::unique_ptr<JobInHand>>()
               : std::async(std::launch::async, [this, &worker, job] { return prepare_ahead(worker, *job); });
  };
  std::future<std::unique_ptr<JobInHand>> next;
  std::future<void> writing;
  for (;;) {
    if (!next.valid()) {
      if (writing.valid()) writing.get();  // its job may have to be retried, or its files be what the next one reads
      BatchJob* const job = take(worker);
      if (job == nullptr) return;
      next = begin_to_prepare(job);
    }
    std::shared_ptr<JobInHand> current = next.get();
    next = begin_to_prepare(take_ahead());
    if (current->over) continue;
    render(worker, *current);
    if (writing.valid()) writing.get();
    if (!current->over)
      writing = std::async(std::launch::async, [this, current, beside = next.valid()] { write(*current, beside); });
    if (!next.valid() && is_last()) worker.devices.close_idle();  // while the files are written
  }
}

/// The next job, for a worker without one; nullptr when there is none.
BatchJob* BatchRun::take(Worker& worker) {
  std::unique_lock lock(mutex_);
  idle_ += worker.busy ? 1 : 0;
  worker.busy = false;
  while (!stop_ && failure_ == nullptr && !waiting_.empty()) {
    if (may_begin()) {
      worker.busy = true;
      --idle_;
      return take_first();
    }
    changed_.wait_for(lock, std::chrono::milliseconds(100));  // a signal wakes nobody
  }
  return nullptr;
}

/// The next job, to be prepared while another one renders. Returns nullptr if there is none, if it
/// has to wait for others, or if an idle worker can take it.
BatchJob* BatchRun::take_ahead() {
  const std::lock_guard lock(mutex_);
  return !stop_ && failure_ == nullptr && waiting_.size() > idle_ && may_begin() ? take_first() : nullptr;
}

bool BatchRun::may_begin() const { return waiting_.front()->writers.empty() || in_hand_ == 0; }

BatchJob* BatchRun::take_first() {
  BatchJob* const job = waiting_.front();
  waiting_.pop_front();
  ++in_hand_;
  return job;
}

/// Puts a job at the end of the queue, and behind it those that read what it or they write.
void BatchRun::put_last(BatchJob& job) {
  std::set<const BatchJob*> moved = {&job};
  std::deque<BatchJob*> others, last = {&job};
  for (BatchJob* const other : waiting_) {
    const bool reads = std::ranges::any_of(other->writers, [&](std::size_t i) { return moved.count(&jobs_[i]) > 0; });
    if (reads) moved.insert(other);
    (reads ? last : others).push_back(other);
  }
  others.insert(others.end(), last.begin(), last.end());
  waiting_ = std::move(others);
}

/// A job that did not write what this one reads, or nullptr. To be called while no other job is in
/// hand.
const BatchJob* BatchRun::failed_writer(const BatchJob& job) const {
  for (const std::size_t writer : job.writers)
    if (jobs_[writer].state != JobState::done && jobs_[writer].state != JobState::skipped) return &jobs_[writer];
  return nullptr;
}

bool BatchRun::is_last() {
  const std::lock_guard lock(mutex_);
  return waiting_.empty();
}

/// Prepares a job before its turn.
std::unique_ptr<BatchRun::JobInHand> BatchRun::prepare_ahead(Worker& worker, BatchJob& job) {
  auto current = std::make_unique<JobInHand>(JobInHand{.job = job});
  ++job.attempts;
  try {
    prepare(worker, *current);
  } catch (...) {
    fail(*current);
  }
  current->prepared_s = host_seconds() - current->begin_s;
  return current;
}

bool BatchRun::is_done(const RenderOptions& options, const std::string& key) {
  std::vector<LedgerOutput> written;
  {
    const std::lock_guard lock(mutex_);
    const LedgerEntry* const last = ledger_.last(ledger_name(options.exr()));
    if (last == nullptr || last->state != "done" || last->key != key) return false;
    written = last->outputs;
  }
  for (const LedgerOutput& output : written) {
    try {
      const LedgerOutput now = describe_output(output.path);
      if (now.bytes != output.bytes || now.hash != output.hash) return false;
    } catch (const InputError&) {
      return false;
    }
  }
  return true;
}

/// True if the job was started before with the same key, and not finished: its checkpoint may be of
/// this image.
bool BatchRun::was_begun(const RenderOptions& options, const std::string& key) {
  const std::lock_guard lock(mutex_);
  const LedgerEntry* const last = ledger_.last(ledger_name(options.exr()));
  return last != nullptr && last->state != "done" && last->key == key;
}

void BatchRun::resume(RenderOptions& options) {
  CheckpointOptions& checkpoint = options.checkpoint;
  if (!checkpoint.file.empty())
    checkpoint.implied = !std::exchange(checkpoint.resume, true);
  else if (options.keeps_sums() && checkpoint.parts.empty())
    checkpoint.left = options.exr().string();
}

void BatchRun::log_once(const BatchJob& job, const std::string& line) {
  constexpr std::size_t kMost = 10000;  // beyond it, notes may repeat rather than memory grow
  {
    const std::lock_guard lock(mutex_);
    if (said_.count(line) != 0) return;
    if (said_.size() < kMost) said_.insert(line);
  }
  progress_.log(fmt::format("{}: {}", place(job), line));
}

void BatchRun::log_failure(const BatchJob& job, const std::string& line) {
  if (job.frame)
    log_once(job, line);  // what is wrong with one frame is often wrong with all
  else
    progress_.log(fmt::format("{}: {}", place(job), line));
}

void BatchRun::prepare(Worker& worker, JobInHand& current) {
  if (const BatchJob* const writer = failed_writer(current.job)) {
    current.job.code = ExitCode::input;
    current.job.message = fmt::format("not rendered: it reads what {} writes, which {}; mend that one first",
                                      place(*writer), writer->state == JobState::failed ? "failed" : "did not end");
    log_failure(current.job, current.job.message);
    return close(current, JobState::failed);
  }
  const RenderOptions& options = *current.job.options;
  current.scene = digest_scene_files(options.scene.scene);
  const Digest environment = digest_environment(options.scene.environment.map);
  current.key = job_key(current.scene, environment, options.settings_text);
  if (!settings_.force && !options.force && is_done(options, current.key)) return close(current, JobState::skipped);
  const auto log = [this, &job = current.job](const std::string& line) { log_once(job, line); };
  RenderOptions own = options;
  own.goal.times_rendering = true;  // other images are loaded and written beside it
  if (was_begun(options, current.key)) resume(own);
  current.render.emplace(std::move(own), log, process_seconds());
  current.render->share(pilots_);
  if (!worker.scenes.takes(current.scene))
    return current.render->take_devices(worker.devices, stop_);  // not two large ones at a time
  const auto kept = worker.scenes.load(options.scene.scene, options.scene.choice(), current.scene);
  current.render->load(kept->scene, kept->load_s);
  const Settings& settings = current.render->settings();
  const std::string light = fmt::format("{:016x} {}", environment.hash, describe(settings.environment));
  current.render->use(worker.scenes.pack(*kept, settings, options.execution, light));
  current.loaded = true;
  current.render->take_devices(worker.devices, stop_);
}

void BatchRun::render(Worker& worker, JobInHand& current) {
  current.begin_s = host_seconds() - current.prepared_s;
  try {
    if (!current.loaded) {
      worker.scenes.clear();
      worker.devices.close_idle();  // frees what is prepared on them
      current.render->load();
    }
    if (stop_) return close(current, JobState::waiting);
    note(entry_of(current, "started"), false);
    progress_.show(current.job, 0);
    RenderHooks hooks;
    hooks.devices_stay_ready = current.loaded;
    hooks.progress = [&](const Progress& now, const Film&) { progress_.show(current.job, now.share); };
    current.render->render(stop_, std::move(hooks));
  } catch (...) {
    fail(current);
  }
}

void BatchRun::write(JobInHand& current, bool beside_render) {
  try {
    // Beside a render, one thread writes: helpers would take time from it, also when they look for
    // more to do.
    tbb::task_arena threads(beside_render ? 1 : tbb::task_arena::automatic);
    threads.execute([&] { current.render->write(false); });  // a restarted batch renders it again
    BatchJob& job = current.job;
    const RenderReport& report = current.render->report();
    job.samples = report.samples;
    job.render_s = report.render_s;
    if (current.render->error().known) job.relmse = current.render->error().relmse;
    job.code = current.render->code();
    if (job.code == ExitCode::not_as_asked) throw Error(job.code, "done, but not as asked; see above");
    close(current, job.code == ExitCode::done ? JobState::done : JobState::interrupted);
  } catch (...) {
    fail(current);
  }
}

LedgerEntry BatchRun::entry_of(const JobInHand& current, const char* state) const {
  const BatchJob& job = current.job;
  LedgerEntry entry;
  entry.state = state;
  entry.time = time_now();
  entry.job = job.text;
  entry.key = current.key;
  entry.message = job.message;
  entry.line = job.line;
  entry.exit_code = int(job.code);
  entry.seconds = job.seconds;
  entry.render_seconds = job.render_s;
  entry.samples = job.samples;
  entry.relmse = job.relmse;
  for (const std::filesystem::path& file : job.options->results()) {
    LedgerOutput output;
    if (entry.state == "done") output = describe_output(file);
    output.path = ledger_name(file);
    entry.outputs.push_back(std::move(output));
  }
  return entry;
}

void BatchRun::note(const LedgerEntry& entry, bool sync) {
  const std::lock_guard lock(mutex_);
  try {
    ledger_.add(entry, sync);
  } catch (const InputError& error) {
    if (ledger_is_whole_) progress_.log(fmt::format("{}; what is done from here on will be done again", error.what()));
    ledger_is_whole_ = false;
  }
}

void BatchRun::close(JobInHand& current, JobState state) {
  BatchJob& job = current.job;
  job.seconds += host_seconds() - current.begin_s;
  job.state = state;
  current.over = true;
  if (state == JobState::done || state == JobState::failed || state == JobState::interrupted)
    note(entry_of(current, name_of(state)), true);
  if (state != JobState::waiting) progress_.end(job);
  current.render.reset();
  const std::lock_guard lock(mutex_);
  --in_hand_;
  changed_.notify_all();
}

/// Handles the current exception: the job goes to the end of the queue again, or has failed.
void BatchRun::fail(JobInHand& current) {
  BatchJob& job = current.job;
  try {
    throw;
  } catch (const Error& error) {
    job.code = error.code();
    job.message = error.what();
  } catch (const std::bad_alloc&) {
    job.code = ExitCode::internal;
    job.message = "out of memory; try a smaller image or scene";
  } catch (const std::exception& error) {
    job.code = ExitCode::internal;
    job.message = fmt::format("internal error: {}", error.what());
  }
  // A retry does not help against usage errors, nor where the image is there but not as asked.
  const bool again =
      job.attempts <= settings_.retries && job.code != ExitCode::usage && job.code != ExitCode::not_as_asked && !stop_;
  log_failure(job, job.message + (again ? "; it will be tried again" : ""));
  if (!again) return close(current, JobState::failed);
  job.seconds += host_seconds() - current.begin_s;
  job.code = ExitCode::done;
  job.message.clear();
  progress_.again(job);
  current.over = true;
  current.render.reset();
  const std::lock_guard lock(mutex_);
  put_last(job);
  --in_hand_;
  changed_.notify_all();
}

}  // namespace eikon
