// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <httplib.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace eikon {

/// The threads of a server, one for each connection. While all are busy, further connections wait
/// where the operating system keeps them, which has a limit of its own.
class BoundedThreads : public httplib::TaskQueue {
 public:
  /// ending  the server is about to end: no call of enqueue() waits any more
  BoundedThreads(std::size_t count, const std::atomic<bool>& ending);
  ~BoundedThreads() override = default;
  BoundedThreads(const BoundedThreads&) = delete;
  BoundedThreads& operator=(const BoundedThreads&) = delete;

  /// Waits for an idle thread.
  void enqueue(std::function<void()> connection) override;
  void shutdown() override;

 private:
  void work();

  const std::atomic<bool>& ending_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::deque<std::function<void()>> connections_;
  std::size_t idle_ = 0;
  bool over_ = false;

  std::vector<std::thread> threads_;
};

}  // namespace eikon
