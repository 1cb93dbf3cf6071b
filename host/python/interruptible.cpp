// SPDX-License-Identifier: Apache-2.0
#include "python/interruptible.h"

#include <dlfcn.h>
#include <nanobind/nanobind.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <exception>
#include <future>
#include <mutex>
#include <thread>

#include "core/error.h"
#include "core/lost_threads.h"

namespace nb = nanobind;

namespace eikon::python {
namespace {

/// True if nobody handles the signal, or Python does, which all handlers of its users go through.
bool is_of_python(const struct sigaction& action) {
  const auto object_of = [](const void* address) {
    Dl_info found{};
    return dladdr(address, &found) != 0 ? found.dli_fbase : nullptr;
  };
  if (action.sa_handler == SIG_DFL || action.sa_handler == SIG_IGN) return true;
  return object_of(reinterpret_cast<const void*>(action.sa_handler)) ==
         object_of(reinterpret_cast<const void*>(&PyErr_CheckSignals));
}

/// Puts back the handlers of signals that others have replaced by their own. One that Python has
/// set meanwhile stays. Calls may overlap: the first one keeps the handlers, and each puts them
/// back at its end.
class KeptHandlers {
 public:
  KeptHandlers() {
    const std::lock_guard lock(mutex_);
    if (calls_++ > 0) return;
    for (int signal = 1; signal < kCount; ++signal)
      known_[at(signal)] = sigaction(signal, nullptr, &actions_[at(signal)]) == 0;
  }
  ~KeptHandlers() {
    const std::lock_guard lock(mutex_);
    --calls_;
    for (int signal = 1; signal < kCount; ++signal) {
      struct sigaction now {};
      if (known_[at(signal)] && sigaction(signal, nullptr, &now) == 0 && !is_of_python(now))
        sigaction(signal, &actions_[at(signal)], nullptr);
    }
  }
  KeptHandlers(const KeptHandlers&) = delete;
  KeptHandlers& operator=(const KeptHandlers&) = delete;

 private:
  static constexpr int kCount = 32;  // real-time signals, which no driver handles, begin here
  static std::size_t at(int signal) { return static_cast<std::size_t>(signal); }

  static inline std::mutex mutex_;  // guards what follows
  static inline int calls_ = 0;
  static inline std::array<struct sigaction, kCount> actions_{};
  static inline std::array<bool, kCount> known_{};
};

/// Holds SIGINT back on this thread and on those that it starts.
class HeldInterrupt {
 public:
  HeldInterrupt() {
    sigemptyset(&set_);
    sigaddset(&set_, SIGINT);
    pthread_sigmask(SIG_BLOCK, &set_, &before_);
  }
  ~HeldInterrupt() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  HeldInterrupt(const HeldInterrupt&) = delete;
  HeldInterrupt& operator=(const HeldInterrupt&) = delete;

  /// Takes one that came. Returns whether there was one.
  [[nodiscard]] bool take() const {
    const timespec none{};
    return sigtimedwait(&set_, nullptr, &none) == SIGINT;
  }

 private:
  sigset_t set_{}, before_{};
};

/// Sees to it that threads which the work has lost do not keep Python from ending.
class NotedLoss {
 public:
  NotedLoss() = default;
  ~NotedLoss() {
    if (lost_threads() > 0) leave_process_at_exit();
  }
  NotedLoss(const NotedLoss&) = delete;
  NotedLoss& operator=(const NotedLoss&) = delete;
};

bool is_main_thread() { return getpid() == static_cast<pid_t>(syscall(SYS_gettid)); }

/// Waits for the end of the work. Returns what a handler of Python raised, or null.
std::exception_ptr watch(const std::future<void>& work, const HeldInterrupt& held, std::atomic<bool>& stop) {
  constexpr std::chrono::milliseconds kInterval{20};
  std::exception_ptr raised;
  while (true) {
    bool ended = false;
    {
      const nb::gil_scoped_release released;
      ended = work.wait_for(kInterval) == std::future_status::ready;
    }
    if (held.take()) PyErr_SetInterrupt();
    if (PyErr_CheckSignals() != 0) {
      if (raised == nullptr) raised = std::make_exception_ptr(nb::python_error());
      stop = true;
    }
    if (ended) return raised;
  }
}

}  // namespace

void require_own_process() {
  static const pid_t first = getpid();
  if (getpid() != first)
    throw DeviceError(
        "this process was forked from one that has used eikon, whose devices it does not have; start processes by "
        "multiprocessing's method 'spawn'");
}

void run_interruptible(const std::function<void(std::atomic<bool>&)>& work) {
  require_own_process();
  std::atomic<bool> stop = false;
  const KeptHandlers handlers;
  const NotedLoss loss;
  if (!is_main_thread()) {
    const nb::gil_scoped_release released;
    return work(stop);
  }
  const HeldInterrupt held;
  std::promise<void> done;
  std::future<void> result = done.get_future();
  std::thread thread([&] {
    try {
      work(stop);
      done.set_value();
    } catch (...) {
      done.set_exception(std::current_exception());
    }
  });
  const std::exception_ptr raised = watch(result, held, stop);
  {
    const nb::gil_scoped_release released;
    thread.join();
  }
  if (raised != nullptr) std::rethrow_exception(raised);
  result.get();
}

}  // namespace eikon::python
