// SPDX-License-Identifier: Apache-2.0
// When a render has done enough: --target-error and --time.
#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "job/log.h"
#include "pack/settings.h"
#include "render/render.h"

namespace eikon {

/// Samples per pixel of a render that is to end by its time or error, unless --spp says otherwise.
inline constexpr std::uint64_t kMaxSppOfGoals = std::uint64_t{1} << 24;

/// The goals that a user may set for a render.
struct GoalOptions {
  std::optional<double> relmse{};   // --target-error, as a relMSE
  std::optional<double> seconds{};  // --time
  // `seconds` are of rendering, from the first unit on; else from the command's start to the last
  // file.
  bool times_rendering = false;
  [[nodiscard]] bool any() const { return relmse || seconds; }
};

/// Divides a render into rounds, and ends it when its error is below the target, or so that its
/// files are written in time.
///
/// The error is judged at 16 samples per pixel and four times in each doubling after that, always
/// with the same number of samples in every pixel. So the number of samples at which a render ends,
/// and with it every bit of the image, depends neither on the devices nor on interruptions. 16
/// samples are the least, because with fewer nothing is known of rare bright paths.
///
/// The error is judged many times, and the render ends at the first time that it seems low enough,
/// so chance would end it too early more often than a single judgement errs (optional stopping). So
/// the upper bound that the i-th judgement uses is exceeded by the true error with a probability of
/// 0.05 / (i (i + 1)) only. These probabilities add up to 0.05: in 95 % of renders no bound of any
/// judgement lies below the true error [Robbins 1970, "Statistical methods related to the law of
/// the iterated logarithm"; Howard et al. 2021, "Time-uniform, nonparametric, nonasymptotic
/// confidence sequences", which calls judgements "looks"].
class Goal {
 public:
  /// end_s: host_seconds() by which --time wants all to be done, unless it times rendering
  /// finish_s: estimates the seconds between the last sample and the last file, with a film between
  /// two rounds
  Goal(const GoalOptions& options, const Settings& settings, double end_s, std::function<double(const Film&)> finish_s,
       Log log);

  /// Lets a render end by this goal. The goal must outlive the render.
  void attach(RenderHooks& hooks);
  /// For RenderHooks::next_round.
  [[nodiscard]] Round next(const RoundEnd& now);
  /// When the first round should have ended, by what is known before it; on the clock of
  /// host_seconds().
  [[nodiscard]] double latest_s() const;
  /// Replaces the share of the work and the seconds left by those until the goal.
  void tell(Progress& progress) const;

  /// Samples per pixel that a render with this goal is likely to take.
  [[nodiscard]] static std::uint64_t likely_samples(const GoalOptions& options, const Crop& crop);

 private:
  [[nodiscard]] bool is_reached(std::uint64_t samples, const Film& film);
  [[nodiscard]] std::uint64_t next_end(std::uint64_t samples) const;
  [[nodiscard]] double latest_s(std::uint64_t samples, const RoundEnd& now);
  void warn_if_out_of_reach(std::uint64_t samples);

  GoalOptions options_;
  std::uint64_t begin_, most_;  // samples per pixel
  double begin_s_, end_s_;
  std::function<double(const Film&)> finish_s_;
  Log log_;
  double finish_estimate_s_, latest_s_ = std::numeric_limits<double>::infinity();
  bool finish_known_ = false, warned_ = false;
  std::uint64_t judged_ = 0;  // samples per pixel at the last judgement; 0: there was none
  PredictedError error_;      // at the last judgement
  double bound_ = std::numeric_limits<double>::infinity();  // of the relMSE, at the last judgement
};

}  // namespace eikon
