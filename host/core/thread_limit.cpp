// SPDX-License-Identifier: Apache-2.0
#include "core/thread_limit.h"

#include <tbb/global_control.h>

#include <algorithm>

#include "core/host_limits.h"

namespace eikon {

struct ThreadLimit::Impl {
  tbb::global_control control;
};

ThreadLimit::ThreadLimit(unsigned threads) {
  const unsigned allowed = host_limits().threads;
  const unsigned most = threads == 0 ? allowed : std::min(threads, allowed);
  impl_.reset(new Impl{tbb::global_control(tbb::global_control::max_allowed_parallelism, most)});
}
ThreadLimit::~ThreadLimit() = default;

}  // namespace eikon
