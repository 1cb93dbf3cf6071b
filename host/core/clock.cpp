// SPDX-License-Identifier: Apache-2.0
#include "core/clock.h"

#include <chrono>

namespace eikon {

double host_seconds() {
  using clock = std::chrono::steady_clock;
  static const clock::time_point start = clock::now();
  return std::chrono::duration<double>(clock::now() - start).count();
}

}  // namespace eikon
