// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "core/trace.h"
#include "render/film_store.h"

namespace eikon {

/// Records the predicted error over the time of a render, for --profile. Predicting keeps
/// processors and the film from the devices, so it takes at most a two-hundredth of the time.
class ErrorCounter {
 public:
  /// pixel_count: of the film
  ErrorCounter(Trace* trace, std::uint64_t pixel_count);
  void update_if_due(FilmStore& film);
  static void count(Trace* trace, const PredictedError& error);

 private:
  Trace* trace_;
  double next_s_;
};

}  // namespace eikon
