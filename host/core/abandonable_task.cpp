// SPDX-License-Identifier: Apache-2.0
#include "core/abandonable_task.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <utility>

#include "core/lost_threads.h"

namespace eikon {
namespace {

constexpr std::chrono::milliseconds kPollInterval{50};

}  // namespace

struct AbandonableTask::Shared {
  std::mutex mutex;  // guards all below
  std::condition_variable changed;
  bool ended = false, lost = false;
  std::exception_ptr error;

  void run(const std::function<void()>& work) noexcept {
    std::exception_ptr thrown;
    try {
      work();
    } catch (...) {
      thrown = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    error = thrown;
    ended = true;
    if (lost) lost_thread_ended();
    changed.notify_all();
  }
};

AbandonableTask::AbandonableTask(std::function<void()> work)
    : shared_(std::make_shared<Shared>()), thread_([shared = shared_, own = std::move(work)] { shared->run(own); }) {}

bool AbandonableTask::wait(const std::function<bool()>& gives_up) {
  {
    std::unique_lock lock(shared_->mutex);
    while (!shared_->changed.wait_for(lock, kPollInterval, [&] { return shared_->ended; })) {
      if (!gives_up()) continue;
      shared_->lost = true;
      thread_is_lost();
      thread_.detach();
      return false;
    }
  }
  thread_.join();
  if (shared_->error) std::rethrow_exception(shared_->error);
  return true;
}

}  // namespace eikon
