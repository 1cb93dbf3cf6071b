// SPDX-License-Identifier: Apache-2.0
#include "job/goal.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "core/clock.h"

namespace eikon {
namespace {

constexpr std::uint64_t kFirstJudgement = 16;  // samples per pixel
constexpr std::uint64_t kJudgementsPerDoubling = 4;
constexpr double kDoubt = 0.05;  // probability that a render ends although its error is above the target
// Before it is measured: writing a pixel and predicting its error.
constexpr double kUsualFinish_s = 0.5e-6;
constexpr double kUsualRate = 2e6;            // samples per second
constexpr std::uint64_t kUsualTargetSpp = 256;

/// The number of the judgement at so many samples per pixel, counted from 1, which is that at
/// kFirstJudgement samples.
std::uint64_t judgement_number(std::uint64_t samples) {
  const std::uint64_t doubling = std::bit_floor(samples);
  const auto doublings = std::uint64_t(std::countr_zero(doubling) - std::countr_zero(kFirstJudgement));
  return 1 + kJudgementsPerDoubling * doublings + (samples - doubling) * kJudgementsPerDoubling / doubling;
}

/// True if the error is judged at so many samples per pixel.
bool is_judged_at(std::uint64_t samples) {
  return samples >= kFirstJudgement && samples % (std::bit_floor(samples) / kJudgementsPerDoubling) == 0;
}

}  // namespace

Goal::Goal(const GoalOptions& options, const Settings& settings, double end_s,
           std::function<double(const Film&)> finish_s, Log log)
    : options_(options),
      begin_(settings.sample_begin),
      most_(settings.sample_end - settings.sample_begin),
      begin_s_(host_seconds()),
      end_s_(end_s),
      finish_s_(std::move(finish_s)),
      log_(std::move(log)),
      finish_estimate_s_(kUsualFinish_s * double(settings.crop.pixel_count())) {}

std::uint64_t Goal::likely_samples(const GoalOptions& options, const Crop& crop) {
  if (!options.seconds) return kUsualTargetSpp;
  return std::max<std::uint64_t>(std::uint64_t(*options.seconds * kUsualRate / double(crop.pixel_count())), 1);
}

/// The samples per pixel after the next round. With --time the first rounds are short, since
/// seconds may be, too.
std::uint64_t Goal::next_end(std::uint64_t samples) const {
  if (samples < kFirstJudgement)
    return !options_.seconds ? kFirstJudgement : samples == 0 ? 1 : 2 * std::bit_floor(samples);
  const std::uint64_t doubling = std::bit_floor(samples);
  if (!options_.relmse) return 2 * doubling;
  const std::uint64_t step = doubling / kJudgementsPerDoubling;
  const std::uint64_t next = (samples / step + 1) * step;
  if (judged_ == 0 || error_.relmse <= 0) return next;
  // No error falls faster than the square of the number of samples, so judgements that cannot find
  // the target reached are left out.
  const double least = double(judged_) * std::sqrt(error_.lo / *options_.relmse);
  return double(next) < least ? next_end(next) : next;
}

bool Goal::is_reached(std::uint64_t samples, const Film& film) {
  error_ = film.predicted_error();
  judged_ = samples;
  const auto i = double(judgement_number(samples));
  bound_ = error_.upper(kDoubt / (i * (i + 1)));
  return bound_ <= *options_.relmse;
}

void Goal::warn_if_out_of_reach(std::uint64_t samples) {
  constexpr std::uint64_t kEnoughToJudge = 64;
  if (warned_ || samples < kEnoughToJudge || !std::isfinite(bound_)) return;
  const double needed = double(samples) * bound_ / *options_.relmse;
  if (needed < 4 * double(kMaxSppOfGoals) || most_ < kMaxSppOfGoals) return;
  warned_ = true;
  log_(fmt::format("--target-error: about {:.1e} samples per pixel would reach it, and {} are the most; the render goes on "
                   "to them unless it is interrupted",
                   needed, most_));
}

void Goal::attach(RenderHooks& hooks) {
  hooks.next_round = [this](const RoundEnd& now) { return next(now); };
  hooks.latest_s = latest_s();
  hooks.progress = [this, usual = std::move(hooks.progress)](Progress now, const Film& film) {
    tell(now);
    if (usual) usual(now, film);
  };
}

Round Goal::next(const RoundEnd& now) {
  const std::uint64_t samples = now.done - begin_;
  if (options_.relmse && now.exact && is_judged_at(samples)) {
    if (is_reached(samples, now.film)) return {.end = now.done};
    warn_if_out_of_reach(samples);
  }
  latest_s_ = latest_s(samples, now);
  // Time to open devices does not count, and until a sample is done it is not known when rendering
  // began.
  const bool begins = options_.seconds && options_.times_rendering && now.render_s == 0;
  return {.end = begin_ + std::min(begins ? samples + 1 : next_end(samples), most_), .latest_s = latest_s_};
}

double Goal::latest_s() const {
  if (!options_.seconds) return std::numeric_limits<double>::infinity();
  return options_.times_rendering ? begin_s_ + *options_.seconds : end_s_ - finish_estimate_s_;
}

/// When units should have ended.
double Goal::latest_s(std::uint64_t samples, const RoundEnd& now) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  if (!options_.seconds) return kNever;
  if (options_.times_rendering) return now.render_s > 0 ? host_seconds() + *options_.seconds - now.render_s : kNever;
  if (!finish_known_ && samples >= 2) {
    finish_estimate_s_ = finish_s_(now.film);
    finish_known_ = true;
  }
  return end_s_ - finish_estimate_s_;
}

void Goal::tell(Progress& progress) const {
  const double now_s = host_seconds();
  double left_s = progress.left_s;
  if (options_.relmse && std::isfinite(bound_) && progress.samples_per_second > 0) {
    // The error goes as 1 / samples, at the slowest.
    const double pixels = double(progress.samples_total) / double(most_);
    const double needed = pixels * std::min(double(judged_) * bound_ / *options_.relmse, double(most_));
    left_s = std::min(left_s, std::max(0.0, needed - double(progress.samples)) / progress.samples_per_second);
  }
  left_s = std::min(left_s, std::max(0.0, latest_s_ - now_s));
  progress.left_s = left_s;
  const double spent_s = std::max(now_s - begin_s_, 0.0);
  progress.share = left_s + spent_s > 0 ? spent_s / (spent_s + left_s) : 0;
}

}  // namespace eikon
