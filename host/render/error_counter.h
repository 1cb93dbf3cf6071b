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
  ErrorCounter(Trace* trace, std::uint64_t pixel_count)
      : trace_(trace), next_s_(host_seconds() + kRest * kPixel_s * double(pixel_count)) {}

  void update_if_due(FilmStore& film) {
    const double begin_s = host_seconds();
    if (trace_ == nullptr || begin_s < next_s_) return;
    TraceScope scope(trace_, Trace::kMain, "predict error");
    PredictedError error;
    film.read([&](const Film& seen) { error = seen.predicted_error(); });
    scope.end();
    const double end_s = host_seconds();
    next_s_ = end_s + kRest * (end_s - begin_s);
    count(trace_, error);
  }

  static void count(Trace* trace, const PredictedError& error) {
    if (trace == nullptr || !error.known) return;
    const double now_s = host_seconds();
    trace->count("predicted relMSE", now_s, now_s, error.relmse);
  }

 private:
  static constexpr double kRest = 200;        // times the duration of a prediction pass until the next one
  static constexpr double kPixel_s = 0.5e-6;  // duration per pixel before one was measured (film.h)
  Trace* trace_;
  double next_s_;
};

}  // namespace eikon
