// SPDX-License-Identifier: Apache-2.0
#include "core/clock.h"

#include <chrono>
#include <ctime>
#include <fstream>
#include <sstream>
#include <string>
#include <unistd.h>

#include "core/error.h"

namespace eikon {

double host_seconds() {
  using clock = std::chrono::steady_clock;
  static const clock::time_point start = clock::now();
  return std::chrono::duration<double>(clock::now() - start).count();
}

namespace {

/// Reads field 22 of /proc/self/stat: the start of the process in seconds since boot [man proc].
double process_start() {
  std::ifstream file("/proc/self/stat");
  std::string text;
  std::getline(file, text);
  // The second field is the name of the program in parentheses. It may contain spaces and
  // parentheses.
  const std::size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) throw InternalError("cannot read /proc/self/stat: no time of the process's start");
  std::istringstream fields(text.substr(name_end + 1));
  std::string skipped;
  for (int field = 3; field < 22; ++field) fields >> skipped;
  double ticks = 0;
  if (!(fields >> ticks)) throw InternalError("/proc/self/stat has no time of the process's start");
  return ticks / double(sysconf(_SC_CLK_TCK));
}

}  // namespace

double process_seconds() {
  static const double start = process_start();
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec) - start;
}

}  // namespace eikon
