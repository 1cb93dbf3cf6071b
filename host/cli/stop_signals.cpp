// SPDX-License-Identifier: Apache-2.0
#include "cli/stop_signals.h"

#include <csignal>

namespace eikon {
namespace {

std::atomic<bool> stop_requested{false};
std::atomic<int> stop_signal{0};

void on_signal(int signal) {
  stop_signal = signal;
  stop_requested = true;
  std::signal(signal, SIG_DFL);
}

}  // namespace

const std::atomic<bool>& catch_stop_signals() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  return stop_requested;
}

ExitCode stop_exit_code() { return stop_signal == SIGTERM ? ExitCode::terminated : ExitCode::interrupted; }

}  // namespace eikon
