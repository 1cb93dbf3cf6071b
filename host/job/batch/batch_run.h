// SPDX-License-Identifier: Apache-2.0
// Runs the jobs of a batch, some at a time, in steps that overlap: while one job renders, the next
// is loaded and compiled, and the one before is written.
#pragma once
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "job/batch/ledger.h"
#include "job/batch/batch_progress.h"
#include "job/render_job.h"
#include "job/scene_cache.h"

namespace eikon {

struct BatchSettings {
  std::string name;          // of the jobs file, for messages
  std::size_t parallel = 1;  // jobs at a time
  int retries = 0;           // of a failed job
  bool force = false;        // also render jobs that are done
};

class BatchRun {
 public:
  BatchRun(std::vector<BatchJob>& jobs, const BatchSettings& settings, Ledger& ledger, BatchProgress& progress,
           const std::atomic<bool>& stop);
  /// Returns when every job is over or, after `stop`, the running ones have ended.
  /// throws what ended a worker, such as a thread that cannot be started; the other workers have
  /// then ended too
  void run();
  /// True if every event could be written to the ledger.
  [[nodiscard]] bool ledger_is_whole() const { return ledger_is_whole_; }

 private:
  struct Worker;     // renders one job at a time
  struct JobInHand;  // a job that a worker prepares, renders or writes

  std::vector<BatchJob>& jobs_;
  const BatchSettings& settings_;
  Ledger& ledger_;
  BatchProgress& progress_;
  const std::atomic<bool>& stop_;
  PilotCache pilots_;

  std::mutex mutex_;  // guards the ledger and everything below
  std::condition_variable changed_;
  std::deque<BatchJob*> waiting_;
  std::size_t in_hand_ = 0;
  std::size_t idle_ = 0;  // workers without a job, including those that have not asked for one yet
  bool ledger_is_whole_ = true;
  std::exception_ptr failure_;  // the first that ended a worker; no job begins after it
  std::set<std::string> said_;  // notes so far: one about a scene is printed for its first job only

  void work(Worker& worker);
  void work_on_jobs(Worker& worker);
  void end_early(std::exception_ptr failure);
  BatchJob* take(Worker& worker);
  BatchJob* take_ahead();
  [[nodiscard]] bool may_begin() const;
  BatchJob* take_first();
  void put_last(BatchJob& job);
  [[nodiscard]] const BatchJob* failed_writer(const BatchJob& job) const;
  [[nodiscard]] bool is_last();
  std::unique_ptr<JobInHand> prepare_ahead(Worker& worker, BatchJob& job);
  void prepare(Worker& worker, JobInHand& current);
  [[nodiscard]] bool is_done(const RenderOptions& options, const std::string& key);
  [[nodiscard]] bool was_begun(const RenderOptions& options, const std::string& key);
  /// Lets a render that was begun before go on from its checkpoint, or from its own output if that
  /// has exact sums.
  static void resume(RenderOptions& options);
  void render(Worker& worker, JobInHand& current);
  void write(JobInHand& current, bool beside_render);
  void close(JobInHand& current, JobState state);
  void fail(JobInHand& current);
  void note(const LedgerEntry& entry, bool sync);
  [[nodiscard]] LedgerEntry entry_of(const JobInHand& current, const char* state) const;
  void log_once(const BatchJob& job, const std::string& line);
  void log_failure(const BatchJob& job, const std::string& line);
  [[nodiscard]] std::string place(const BatchJob& job) const;
};

}  // namespace eikon
