// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "core/trace.h"
#include "render/film.h"

namespace eikon {

/// The predicted error over the time of a render, for --profile. The devices wait for the film while it is looked at, so that is
/// done in a two-hundredth of the time.
class ErrorCounter {
 public:
  explicit ErrorCounter(Trace* trace) : trace_(trace) {}
  /// at_end: whatever it takes
  void look(const Film& film, bool at_end);

 private:
  Trace* trace_;
  double next_s_ = 0;
};

}  // namespace eikon
