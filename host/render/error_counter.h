// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "core/trace.h"
#include "render/film_store.h"

namespace eikon {

/// The predicted error over the time of a render, for --profile. It takes processors and the film from the devices while it is
/// computed, so that is done in a two-hundredth of the time.
class ErrorCounter {
 public:
  /// From now on; of so many pixels
  ErrorCounter(Trace* trace, std::uint64_t pixel_count);
  void look_if_due(FilmStore& film);
  static void count(Trace* trace, const PredictedError& error);

 private:
  Trace* trace_;
  double next_s_;
};

}  // namespace eikon
