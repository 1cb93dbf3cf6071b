// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>

#include "core/time_share.h"
#include "core/trace.h"
#include "render/film_store.h"

namespace eikon {

/// The curve of the predicted error over the time of a render, with both ends of its interval:
/// three counters of the trace, which --profile and --report show. A prediction keeps processors
/// and the film from the devices, so predictions take at most a share of the time.
class ErrorCurve {
 public:
  /// trace        null: nothing is recorded
  /// pixel_count  of the film
  /// share        of the time, above 0
  ErrorCurve(Trace* trace, std::uint64_t pixel_count, double share) : trace_(trace), share_(share) {
    share_.rest(kPixel_s * double(pixel_count));
  }

  void add_point_if_due(FilmStore& film) {
    if (trace_ == nullptr || !share_.is_due()) return;
    PredictedError error;
    share_.run([&] {
      const TraceScope predicting(trace_, Trace::kMain, "predict error");
      film.read([&](const Film& seen) { error = seen.predicted_error(); });
    });
    add_point(trace_, error);
  }

  /// Adds an error that was just predicted.
  static void add_point(Trace* trace, const PredictedError& error) {
    if (trace == nullptr || !error.known) return;
    const double now_s = host_seconds();
    trace->count("predicted relMSE", now_s, now_s, error.relmse);
    trace->count("predicted relMSE, low", now_s, now_s, error.lo);
    if (std::isfinite(error.hi)) trace->count("predicted relMSE, high", now_s, now_s, error.hi);
  }

 private:
  static constexpr double kPixel_s = 0.5e-6;  // that a pixel takes before anything was measured (Film::predicted_error)
  Trace* trace_;
  TimeShare share_;
};

}  // namespace eikon
