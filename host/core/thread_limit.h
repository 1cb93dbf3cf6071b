// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

namespace eikon {

/// While it lives, host-side work of the whole process uses at most so many threads at once; the
/// least of several such limits holds. 0 stands for what the machine, the affinity mask and the
/// quota of the control group allow.
class ThreadLimit {
 public:
  explicit ThreadLimit(unsigned threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace eikon
