// SPDX-License-Identifier: Apache-2.0
#include "job/stop_signals.h"

#include <chrono>
#include <csignal>
#include <optional>
#include <thread>

namespace eikon {
namespace {

std::atomic<bool> stop_requested{false}, stops_are_caught{false};
std::atomic<int> stop_signal{0};
std::atomic<std::uint64_t> checkpoint_requests{0};

// A stop often comes more than once: GNU timeout signals its command and then the process group,
// and a task of a farm is signalled both by its queue and by its own script. What comes later than
// this is somebody who does not want to wait.
constexpr std::chrono::seconds kOneStop{1};

bool is_ignored(int signal) {
  struct sigaction now {};
  return sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
}

/// Lets the signal do what it would do without us.
void act_by_default(int signal) {
  std::signal(signal, SIG_DFL);
  sigset_t one;
  sigemptyset(&one);
  sigaddset(&one, signal);
  pthread_sigmask(SIG_UNBLOCK, &one, nullptr);
  (void)std::raise(signal);
}

struct Received {
  sigset_t all{}, ignored{};  // ignored: when the process started
};

void receive(const Received& signals) {
  using Clock = std::chrono::steady_clock;
  std::optional<Clock::time_point> first_stop;  // by SIGINT or SIGTERM
  for (;;) {
    int signal = 0;
    if (sigwait(&signals.all, &signal) != 0) continue;
    if (signal == SIGUSR1) {
      ++checkpoint_requests;
    } else if (!stops_are_caught) {
      if (sigismember(&signals.ignored, signal) != 1) act_by_default(signal);
    } else if (first_stop && signal != SIGHUP && Clock::now() - *first_stop >= kOneStop) {
      act_by_default(signal);
    } else {
      if (!first_stop && signal != SIGHUP) first_stop = Clock::now();
      if (!stop_requested) stop_signal = signal;
      stop_requested = true;
    }
  }
}

}  // namespace

void receive_signals() {
  Received signals;
  sigset_t blocked;
  for (sigset_t* const set : {&signals.all, &signals.ignored, &blocked}) sigemptyset(set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) {
    sigaddset(&blocked, signal);
    if (is_ignored(signal)) {
      sigaddset(&signals.ignored, signal);
      if (signal == SIGHUP) continue;  // started by nohup: stays ignored
    }
    sigaddset(&signals.all, signal);
  }
  std::signal(SIGPIPE, SIG_IGN);
  pthread_sigmask(SIG_BLOCK, &blocked, nullptr);
  std::thread([signals] { receive(signals); }).detach();
}

const std::atomic<bool>& catch_stop_signals() {
  stops_are_caught = true;
  return stop_requested;
}

ExitCode stop_exit_code() { return stop_signal == SIGINT ? ExitCode::interrupted : ExitCode::terminated; }

std::uint64_t checkpoint_signals() { return checkpoint_requests; }

}  // namespace eikon
