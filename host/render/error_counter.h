// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>

#include "core/trace.h"
#include "render/film_store.h"

namespace eikon {

/// Records the predicted error over the time of a render, and the ends of its interval, for --profile and --report.
/// Predicting keeps processors and the film from the devices, so it takes at most a given share of the time.
class ErrorCounter {
 public:
  /// pixel_count: of the film
  /// share: of the time, above 0
  ErrorCounter(Trace* trace, std::uint64_t pixel_count, double share)
      : trace_(trace), rest_(1 / share), next_s_(host_seconds() + rest_ * kPixel_s * double(pixel_count)) {}

  void update_if_due(FilmStore& film) {
    const double begin_s = host_seconds();
    if (trace_ == nullptr || begin_s < next_s_) return;
    TraceScope scope(trace_, Trace::kMain, "predict error");
    PredictedError error;
    film.read([&](const Film& seen) { error = seen.predicted_error(); });
    scope.end();
    const double end_s = host_seconds();
    next_s_ = end_s + rest_ * (end_s - begin_s);
    count(trace_, error);
  }

  static void count(Trace* trace, const PredictedError& error) {
    if (trace == nullptr || !error.known) return;
    const double now_s = host_seconds();
    trace->count("predicted relMSE", now_s, now_s, error.relmse);
    trace->count("predicted relMSE, low", now_s, now_s, error.lo);
    if (std::isfinite(error.hi)) trace->count("predicted relMSE, high", now_s, now_s, error.hi);
  }

 private:
  static constexpr double kPixel_s = 0.5e-6;  // duration per pixel before one was measured (film.h)
  Trace* trace_;
  double rest_;  // times the duration of a prediction pass until the next one
  double next_s_;
};

}  // namespace eikon
