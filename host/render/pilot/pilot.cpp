// SPDX-License-Identifier: Apache-2.0
#include "render/pilot/pilot.h"

#include <algorithm>
#include <bit>

#include "core/clock.h"
#include "pack/lights/light_kind.h"
#include "render/pilot/guiding_pilot.h"
#include "render/pilot/light_trial.h"
#include "shared/lobe_traits.h"

namespace eikon {
namespace {

// Smaller images have no pilot unless guiding is on or only light paths find some light.
constexpr std::uint64_t kMinPixels = 1U << 14;
constexpr std::uint64_t kMinPaths = 1U << 15;
constexpr std::uint64_t kPathsPerPixel = 2;  // a thirty-second of the usual 64 samples
constexpr std::uint64_t kMinTrialPaths = 1U << 14, kMaxTrialPaths = 1U << 16;

std::uint64_t pixels_of(const Settings& settings) { return std::uint64_t{settings.width} * settings.height; }

bool wants_light_trial(const Features& features, const Settings& settings) {
  return settings.light_trial_paths > 0 && features.has(Feature::light_paths);
}

/// Returns true if there is something in the scene that the pilot of the settings could guide.
bool wants_guiding(const Features& features, const Settings& settings) {
  const bool lit = features.has(Feature::next_event) || features.has(Feature::bsdf_emission);
  bool diffuse = false;
#define EK_LOBE(name, bit, traits) \
  diffuse |= ((traits) & (EK_TRAIT_LAMBERT | EK_TRAIT_GUIDED)) != 0 && features.has(Feature::name);
#include "shared/features.def"
  if (settings.pilot_paths == 0 || settings.guide != nullptr || !lit || !diffuse) return false;
  // Caustics of small lights are rare events, which a pilot of this size does not see: its tables
  // then lead away from them, and it cannot tell what that costs. Light paths bring those that they
  // can find.
  const bool caustics = !features.has(Feature::light_paths) &&
                        (features.has(Feature::transmissive_hits) || features.has(Feature::conductor)) &&
                        has_light(features, [](const LightKindInfo& kind) { return !kind.distant; });
  return !caustics || settings.guiding == Guiding::on;
}

}  // namespace

std::uint64_t usual_pilot_paths(const Settings& settings) {
  if (settings.guiding == Guiding::off || settings.integrator != Integrator::path || settings.roulette_survival > 0 ||
      settings.light_samples > 1 || settings.light_sampling == LightSampling::hemisphere)
    return 0;
  if (pixels_of(settings) < kMinPixels && settings.guiding != Guiding::on) return 0;
  return std::bit_floor(std::clamp(kPathsPerPixel * pixels_of(settings), kMinPaths, kMaxPilotPaths));
}

std::uint64_t usual_light_trial_paths(const Settings& settings, bool light_paths_needed) {
  if (pixels_of(settings) < kMinPixels && !light_paths_needed) return 0;
  return std::bit_floor(std::clamp(pixels_of(settings) / 2, kMinTrialPaths, kMaxTrialPaths));
}

bool wants_pilot(const Features& features, const Settings& settings) {
  return wants_light_trial(features, settings) || wants_guiding(features, settings);
}

void apply(const Pilot& pilot, Features& features, Settings& settings) {
  settings.guide = pilot.table;
  features.set_guiding(pilot.table != nullptr, false);
  if (pilot.report.light_trial_paths == 0) return;
  settings.light_path_count = pilot.report.light_path_count;
  settings.light_aim = pilot.light_aim;
  // Light that is merged comes by light paths alone, so they stay even if those to the camera do
  // not pay.
  if (settings.merges_caustics && settings.light_path_count == 0)
    settings.light_path_count = light_paths_of_ratio(settings, kLightPathRatios[1]);
  if (settings.light_path_count == 0) features.leave_out_light_paths();
}

Pilot run_pilot(DevicePool::Lease& device, const ReadyWavefronts::SharedScene& scene, const Features& features,
                const Settings& settings, const Execution& execution, PilotSteps& steps) {
  const double begin = host_seconds();
  const bool tries_lights = wants_light_trial(features, settings);
  Features own = features, then = features;
  Settings of_image = settings;
  own.set_guiding(false, wants_guiding(features, settings));
  own.leave_out_merging();  // a pilot looks at light that is found without a bias
  of_image.merges_caustics = false;
  if (own.has(Feature::path_log)) of_image.guide = std::make_shared<const GuideTable>(make_guide_table({}, 1));
  const Settings first = tries_lights ? light_trial_settings(of_image) : guiding_picture_settings(of_image);
  const std::uint64_t largest = std::max(tries_lights ? paths_of_light_trial(settings) : 0,
                                         own.has(Feature::path_log) ? largest_guiding_round(settings) : 0);
  PilotPicture picture({device, scene, own, execution, steps}, first, largest);

  Pilot pilot;
  PilotReport& report = pilot.report;
  report.arithmetic = picture.wavefront().arithmetic().name();
  if (tries_lights) {
    const auto [trial, aim, aim_gain] = run_light_trial(picture, *scene, own, of_image);
    const std::size_t best = best_light_paths(trial);
    report.light_trial_paths = paths_of_light_trial(settings);
    report.light_path_count = of_image.light_path_count = light_paths_of_ratio(settings, kLightPathRatios[best]);
    report.light_path_gain = light_path_gain(trial, best);
    if (best > 0) pilot.light_aim = aim, report.light_aim_gain = aim_gain;
    of_image.light_aim = pilot.light_aim;
    if (best == 0) then.leave_out_light_paths();
  }
  if (wants_guiding(then, settings)) run_guiding_pilot(picture, of_image, pilot);
  report.seconds = host_seconds() - begin;
  return pilot;
}

}  // namespace eikon
