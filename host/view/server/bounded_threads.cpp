// SPDX-License-Identifier: Apache-2.0
#include "view/server/bounded_threads.h"

#include <chrono>
#include <utility>

namespace eikon {

BoundedThreads::BoundedThreads(std::size_t count, const std::atomic<bool>& ending) : ending_(ending) {
  for (std::size_t i = 0; i < count; ++i) threads_.emplace_back([this] { work(); });
}

void BoundedThreads::enqueue(std::function<void()> connection) {
  constexpr std::chrono::milliseconds kWake(50);
  std::unique_lock lock(mutex_);
  while (!ending_ && idle_ <= connections_.size()) changed_.wait_for(lock, kWake);
  connections_.push_back(std::move(connection));
  changed_.notify_all();
}

void BoundedThreads::shutdown() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
    changed_.notify_all();
  }
  for (std::thread& thread : threads_) thread.join();
}

void BoundedThreads::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    ++idle_;
    changed_.notify_all();
    changed_.wait(lock, [&] { return over_ || !connections_.empty(); });
    --idle_;
    if (connections_.empty()) return;
    const std::function<void()> connection = std::move(connections_.front());
    connections_.pop_front();
    lock.unlock();
    connection();
    lock.lock();
  }
}

}  // namespace eikon
