// SPDX-License-Identifier: Apache-2.0
// The progress of a batch in one line, and the table at its end.
#pragma once
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "job/batch/batch_job.h"
#include "job/batch/openjd.h"

namespace eikon {

class BatchProgress {
 public:
  /// bar     on a terminal, rewrite a line in place
  /// openjd  print the progress of all jobs together as lines on stdout
  BatchProgress(const std::vector<BatchJob>& jobs, bool bar, bool openjd);
  ~BatchProgress() { clear(); }

  // Any thread may call these.
  /// Shows which fraction of a job is rendered.
  void show(const BatchJob& job, double fraction);
  /// Marks a job as over. It counts for the estimate of the time left only if it was rendered.
  void end(const BatchJob& job);
  /// Marks a job as to be tried again.
  void again(const BatchJob& job);
  /// Prints a line on stderr, above the bar.
  void log(const std::string& line);
  void clear();
  /// Ends the progress. code: the exit code of the process
  void close(ExitCode code);

 private:
  std::mutex mutex_;
  bool bar_, shown_ = false;
  OpenJdLines openjd_;
  double begin_s_;
  double total_ = 0, over_ = 0, rendered_ = 0;  // costs of jobs, see BatchJob
  std::size_t jobs_ = 0, jobs_over_ = 0;
  std::map<const BatchJob*, double> in_hand_;  // and which fraction is done

  void draw();
  void erase();
};

/// Prints state, seconds, samples per second, error and message of each job, and a line for all.
void print_summary(const std::vector<BatchJob>& jobs, double seconds);

}  // namespace eikon
