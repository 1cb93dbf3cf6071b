// SPDX-License-Identifier: Apache-2.0
#include "render/error_counter.h"

namespace eikon {

void ErrorCounter::look(const Film& film, bool at_end) {
  constexpr double rest = 200;  // times what a look takes
  const double begin_s = host_seconds();
  if (trace_ == nullptr || (begin_s < next_s_ && !at_end)) return;
  const TraceScope scope(trace_, Trace::kMain, "predict error");
  const PredictedError error = film.predicted_error();
  const double end_s = host_seconds();
  next_s_ = end_s + rest * (end_s - begin_s);
  if (!error.known) return;
  trace_->count("predicted relMSE", end_s, end_s, error.relmse);
}

}  // namespace eikon
