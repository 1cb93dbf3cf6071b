// SPDX-License-Identifier: Apache-2.0
// One line for a whole batch while it runs, and the table at its end.
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
  /// bar: on a terminal, a line that is rewritten in place; openjd: lines on stdout, with the progress of all jobs together
  BatchProgress(const std::vector<BatchJob>& jobs, bool bar, bool openjd);
  ~BatchProgress() { clear(); }

  // Any thread.
  /// So much of a job is rendered.
  void show(const BatchJob& job, double fraction);
  /// It is over; what was spent on it counts for the time left only if it was rendered.
  void end(const BatchJob& job);
  /// It will be tried again.
  void again(const BatchJob& job);
  /// A line on stderr, above the bar.
  void log(const std::string& line);
  void clear();
  /// The batch is over. code: what the process will return
  void close(ExitCode code);

 private:
  std::mutex mutex_;
  bool bar_, shown_ = false;
  OpenJdLines openjd_;
  double begin_s_;
  double total_ = 0, over_ = 0, rendered_ = 0;  // costs
  std::size_t jobs_ = 0, jobs_over_ = 0;
  std::map<const BatchJob*, double> in_hand_;  // with the fraction that is done

  void draw();
  void erase();
};

/// Job, state, seconds, samples per second, error and message of each job, and a line for all.
void print_summary(const std::vector<BatchJob>& jobs, double seconds);

}  // namespace eikon
