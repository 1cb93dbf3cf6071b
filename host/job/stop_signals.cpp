// SPDX-License-Identifier: Apache-2.0
#include "job/stop_signals.h"

#include <csignal>
#include <thread>

namespace eikon {
namespace {

std::atomic<bool> stop_requested{false}, stops_are_caught{false};
std::atomic<int> stop_signal{0};
std::atomic<std::uint64_t> checkpoint_requests{0};

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
  bool is_last = false;  // the next SIGINT or SIGTERM ends the process
  for (;;) {
    int signal = 0;
    if (sigwait(&signals.all, &signal) != 0) continue;
    if (signal == SIGUSR1) {
      ++checkpoint_requests;
    } else if (!stops_are_caught) {
      if (sigismember(&signals.ignored, signal) != 1) act_by_default(signal);
    } else if (is_last && signal != SIGHUP) {
      act_by_default(signal);
    } else {
      is_last = is_last || signal != SIGHUP;
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
