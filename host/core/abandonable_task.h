// SPDX-License-Identifier: Apache-2.0
// Work on a thread of its own that may hang in a call of a driver.
#pragma once
#include <functional>
#include <memory>
#include <thread>

namespace eikon {

/// Runs work on a thread of its own, which can be left to itself: it is lost then (lost_threads.h).
class AbandonableTask {
 public:
  /// work  must own, or share, all that it touches
  explicit AbandonableTask(std::function<void()> work);
  AbandonableTask(const AbandonableTask&) = delete;
  AbandonableTask& operator=(const AbandonableTask&) = delete;

  /// Waits for the end of the work, once. Calls `gives_up` every 50 ms, since a signal handler that
  /// sets a flag cannot notify.
  /// returns  false if `gives_up` has returned true before the work ended: the thread is lost
  /// throws   what the work threw
  [[nodiscard]] bool wait(const std::function<bool()>& gives_up);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace eikon
