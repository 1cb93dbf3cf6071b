// SPDX-License-Identifier: Apache-2.0
#include "render/pilot/light_trial.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "image/tonemap.h"
#include "pack/lights/light_kind.h"
#include "render/pilot/aim_learner.h"
#include "render/render.h"
#include "shared/splat.h"

namespace eikon {
namespace {

constexpr double kTrialRatio = 1.0 / 4;  // so that the trial's camera paths have little of the light that both find
constexpr double kClearly = 0.95;        // error times cost of a choice that surpasses another, over that of the other
constexpr double kLightRay = 2;          // a ray of a light path takes about twice as long as one from the camera
/// A camera path that shares its light with light paths takes so many times as long, for what it
/// must know for that.
constexpr double kSharing = 1.04;
/// Camera paths of so few samples may have missed what makes most of their error.
constexpr double kMinCameraError = 0.1;

constexpr std::size_t kUsualRatio = 3;  // of kLightPathRatios: starts that are learned for it are good for others, too
/// The least gain by learned starts with which it is tried whether they pay.
constexpr double kMinAimGain = 1.2;
constexpr double kMinHope = 0.98;  // of error times cost, if light paths have that gain, over that with even starts

static_assert(kMaxPilotPixels <= EK_SPLAT_NAMED_SIDE && EK_AIM_STARTS <= 1U << 14, "splats cannot name starts");

constexpr std::size_t kRatios = kLightPathRatios.size();
using Moments = std::array<double, kRatios>;

double cost(const LightTrial& trial, std::size_t i) {
  const double ratio = kLightPathRatios[i];
  return ratio == 0 ? trial.camera_rays : kSharing * trial.camera_rays + ratio * kLightRay * trial.light_rays;
}

double error_times_cost(const LightTrial& trial, std::size_t i) {
  return (trial.camera_error + trial.shared_error[i]) * cost(trial, i);
}

double least_error_times_cost(const LightTrial& trial) { return error_times_cost(trial, best_light_paths(trial)); }

/// The ratio of densities that a splat states: within a factor of the root of 2, as only its
/// exponent is kept.
double ratio_of(std::uint32_t info) {
  const std::uint32_t exponent = EK_SPLAT_RATIO(info);
  if (exponent == EK_SPLAT_RATIO_INFINITE) return std::numeric_limits<double>::infinity();
  return std::ldexp(std::numbers::sqrt2, int(exponent) - 127);
}

using Splat = std::array<std::uint32_t, SPLAT_WORDS>;

double luminance_of(const Splat& splat) {
  const auto channel = [&](std::size_t c) { return double(std::bit_cast<float>(splat[SPLAT_r + c])); };
  return luminance({channel(0), channel(1), channel(2)});
}

/// The sums of the trial, by pixel.
class TrialSums {
 public:
  /// aim: by which light paths start; null: evenly
  TrialSums(const Settings& picture, const Features& features, const PackedScene& scene,
            std::shared_ptr<const LightAim> aim)
      : settings_(picture),
        aim_(scene.light_target_shares, std::move(aim)),
        film_(film_layout(features, picture)),
        shared_(film_.layout().crop.pixel_count()),
        of_camera_(shared_.size()) {}

  void add(const UnitResult& unit) {
    const std::span<const std::uint32_t> words = unit.sums.splats;
    for (std::size_t at = 0; at + SPLAT_WORDS <= words.size(); at += SPLAT_WORDS)
      std::copy_n(&words[at], SPLAT_WORDS, splats_.emplace_back().begin());
    std::vector<std::uint32_t> nameless(words.begin(), words.end());
    for (std::size_t at = 0; at < nameless.size(); at += SPLAT_WORDS)
      nameless[at + SPLAT_pixel] = EK_SPLAT_PIXEL_OF_NAMED(nameless[at + SPLAT_pixel]);
    UnitSums sums = unit.sums;
    sums.splats = nameless;
    film_.add(sums);
    paths_ += double(unit.sums.pixels.size()) * double(unit.sums.sample_end - unit.sums.sample_begin);
    rays_ += double(unit.rays.total());
    light_rays_ += double(unit.light_rays.total());
  }

  [[nodiscard]] LightTrial result() {
    std::vector<double> means(shared_.size());
    for (std::size_t i = 0; i < means.size(); ++i) means[i] = mean(i);
    const double all = std::accumulate(means.begin(), means.end(), 0.0) / double(means.size());
    means = smoothed(means, settings_.width);
    std::vector<double> scales(means.size());
    for (std::size_t i = 0; i < means.size(); ++i) scales[i] = pilot_error_scale(means[i], all);
    add_splats(scales);
    const double samples = paths_ / double(means.size());
    LightTrial trial{.camera_rays = (rays_ - light_rays_) / paths_,
                     .light_rays = light_rays_ / (samples * double(settings_.light_path_count))};
    double of_camera = 0;  // what camera paths brought of the light that both find
    for (std::size_t i = 0; i < means.size(); ++i) {
      const double scale = scales[i];
      if (scale == 0) continue;
      trial.camera_error += camera_variance(i) / scale;
      of_camera += of_camera_[i] / (samples * scale);
      for (std::size_t k = 0; k < kRatios; ++k)
        if (shared_[i][k] > 0) trial.shared_error[k] += shared_[i][k] / (samples * scale);
    }
    trial.camera_error = std::max(trial.camera_error - of_camera, kMinCameraError * trial.camera_error);
    return trial;
  }
  /// Has learned from the splats once result() has been called.
  [[nodiscard]] AimLearner& aim() { return aim_; }

 private:
  /// Sums up the splats in an order of their own. They come in whatever order a device's threads
  /// store them, and sums of floating-point numbers would differ with it in their last bits.
  void add_splats(const std::vector<double>& scales) {
    std::sort(splats_.begin(), splats_.end());
    for (const Splat& splat : splats_) {
      const std::uint32_t xy = EK_SPLAT_PIXEL_OF_NAMED(splat[SPLAT_pixel]);
      const std::size_t pixel = std::size_t{xy >> 16} * settings_.width + (xy & 0xffffU);
      const double value = luminance_of(splat) / double(settings_.light_path_count),
                   ratio = ratio_of(splat[SPLAT_info]);
      const Moments moments = splat_moments(ratio, kTrialRatio);
      for (std::size_t i = 0; i < kRatios; ++i) shared_[pixel][i] += value * value * moments[i];
      of_camera_[pixel] += std::isinf(ratio) ? 0 : value * value / ratio;
      if (scales[pixel] > 0)
        aim_.add(EK_SPLAT_REPLICATE(splat[SPLAT_info]), EK_SPLAT_START(splat[SPLAT_pixel]),
                 value * value * moments[kUsualRatio] / scales[pixel]);
    }
    splats_.clear();
  }
  [[nodiscard]] std::uint32_t x(std::size_t pixel) const { return std::uint32_t(pixel % settings_.width); }
  [[nodiscard]] std::uint32_t y(std::size_t pixel) const { return std::uint32_t(pixel / settings_.width); }
  [[nodiscard]] double mean(std::size_t pixel) const {
    const auto channel = [&](std::uint32_t c) { return film_.mean(x(pixel), y(pixel), c); };
    return luminance({channel(0), channel(1), channel(2)});
  }
  /// Variance of the luminance of a camera path, from the spread between replicates.
  [[nodiscard]] double camera_variance(std::size_t pixel) const {
    const std::uint32_t replicates = film_.layout().replicates;
    double sum = 0, square = 0, samples = 0;
    for (std::uint32_t r = 0; r < replicates; ++r) {
      const std::uint64_t count = film_.count(x(pixel), y(pixel), r);
      const auto channel = [&](std::uint32_t c) { return to_mean(film_.sum(x(pixel), y(pixel), r, c), count); };
      const double mean = luminance({channel(0), channel(1), channel(2)}), n = double(count);
      sum += n * mean, square += n * mean * mean, samples += n;
    }
    return samples > 0 ? std::max(square - sum * sum / samples, 0.0) / double(replicates - 1) : 0;
  }

  const Settings& settings_;
  AimLearner aim_;
  Film film_;
  std::vector<Splat> splats_;      // of all units
  std::vector<Moments> shared_;    // sums over splats
  std::vector<double> of_camera_;  // as shared_, of what the trial's camera paths had of that light
  double paths_ = 0, rays_ = 0, light_rays_ = 0;
};

}  // namespace

std::array<double, kRatios> splat_moments(double ratio, double of_trial) {
  Moments moments{};
  for (std::size_t i = 0; i < kRatios; ++i) {
    const double scale = kLightPathRatios[i] / of_trial;
    // Without the share ratio / (1 + ratio), the value is f / (n q) of the trial's n.
    moments[i] = std::isinf(ratio) ? 1 / scale : (1 + ratio) * (1 + ratio) / (ratio * (1 + ratio * scale));
  }
  return moments;
}

std::size_t best_light_paths(const LightTrial& trial) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < kRatios; ++i)
    if (!(error_times_cost(trial, i) >= kClearly * error_times_cost(trial, best))) best = i;
  return best;
}

double light_path_gain(const LightTrial& trial, std::size_t ratio) {
  const double with = error_times_cost(trial, ratio), without = error_times_cost(trial, 0);
  if (std::isinf(without)) return 0;
  return with > 0 ? without / with : 1;
}

Settings light_trial_settings(const Settings& settings) {
  Settings all = settings;
  all.light_path_count = light_paths_of_ratio(settings, kTrialRatio);
  return pilot_picture_settings(all, kMaxPilotPixels);
}

std::uint64_t paths_of_light_trial(const Settings& settings) {
  const std::uint64_t pixels = light_trial_settings(settings).crop.pixel_count();
  return std::max<std::uint64_t>(settings.light_trial_paths / pixels, 2) * pixels;
}

LightTrialResult run_light_trial(PilotPicture& picture, const PackedScene& scene, const Features& features,
                                 const Settings& settings) {
  // Behind glass and mirrors paths from the camera never find these lights, whether the trial has
  // seen what they light up or not.
  const bool has_unmet_lights = has_light(features, [](const LightKindInfo& kind) { return !kind.met; });
  const bool only_light_paths = has_unmet_lights && scene.has_specular_light_targets;
  Settings own = light_trial_settings(settings);
  const auto render = [&](const LightAim& aim, TrialSums& sums) {
    own.light_aim = std::make_shared<const LightAim>(with_named_starts(aim));
    picture.restart(own);
    picture.render(0, paths_of_light_trial(settings) / picture.pixel_count(), false,
                   [&](const PilotUnit& unit) { sums.add(unit.result); });
    LightTrial trial = sums.result();
    if (only_light_paths) trial.shared_error[0] = std::numeric_limits<double>::infinity();
    return trial;
  };
  TrialSums even_sums(own, features, scene, nullptr);
  const LightTrial even = render({}, even_sums);
  const double error_times_cost_of_even = least_error_times_cost(even);
  AimLearner& learner = even_sums.aim();
  const double gain_of_light = learner.gain();
  LightTrial hoped = even;
  for (std::size_t i = 1; i < kRatios; ++i) hoped.shared_error[i] /= gain_of_light;
  // Photons of merging light what the camera sees otherwise, of which splats tell nothing.
  if (settings.merges_caustics || !(gain_of_light > kMinAimGain) ||
      !(least_error_times_cost(hoped) < kMinHope * error_times_cost_of_even))
    return {even, nullptr, 0};

  const auto aim = std::make_shared<const LightAim>(learner.result());
  TrialSums aimed_sums(own, features, scene, aim);
  LightTrial aimed = render(*aim, aimed_sums);
  // Both errors are the same with any starts, so their noise is kept out of the decision.
  aimed.camera_error = even.camera_error, aimed.shared_error[0] = even.shared_error[0];
  const double gain = error_times_cost_of_even / least_error_times_cost(aimed);
  if (!(gain > 1)) return {even, nullptr, 0};
  learner.add(aimed_sums.aim());
  return {aimed, std::make_shared<const LightAim>(learner.result()), gain};
}

}  // namespace eikon
