// SPDX-License-Identifier: Apache-2.0
// The part of a pilot that decides how many light paths an image has.
//
// Light paths and camera paths find the same light, and each has the share that the balance
// heuristic gives it. So one picture with many light paths tells the error that any other number of
// them would leave. The second moment of what both bring to a pixel is the integral, over all
// paths, of
//   f^2 / (p + n q)   [Veach 1997, section 9.2]
// with
//   f  the light that a path carries
//   p  its density as a camera path
//   q  its density as a light path
//   n  the number of light paths for each sample of a pixel
//
// A light path of the trial samples this integral at any n, because its splat has f / q and the
// ratio q / p (kernels/shared/splat.h). It does so also at n = 0: then camera paths alone have the
// light, and show it as a few very bright pixels. The trial knows of these without having met any.
//
// Cost is counted in rays and never in time, so every part of an image decides alike.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "render/pilot/pilot_picture.h"

namespace eikon {

/// The numbers of light paths for each path from the camera that are weighed against each other.
inline constexpr std::array<double, 7> kLightPathRatios = {0, 1.0 / 128, 1.0 / 64, 1.0 / 16, 1.0 / 4, 1, 4};

/// The error that each number of light paths leaves, and its cost.
struct LightTrial {
  double camera_error = 0;  // of the light that only camera paths find
  /// The same of the light that both find. It is infinite with no light paths if some light is
  /// found by them alone.
  std::array<double, kLightPathRatios.size()> shared_error{};
  double camera_rays = 0, light_rays = 0;  // of a path
};

struct LightTrialResult {
  LightTrial trial;                     // with the starts that were chosen
  std::shared_ptr<const LightAim> aim;  // what was learned about these, if that pays; else null, and they are even
  double aim_gain = 0;                  // error times cost with even starts over that with these; 0: they are even
};

/// An index into kLightPathRatios: of the least number of light paths that no larger one surpasses
/// clearly.
[[nodiscard]] std::size_t best_light_paths(const LightTrial& trial);
/// Error times cost with no light paths over that with the ratio of this index; 0 if only light
/// paths find some light.
[[nodiscard]] double light_path_gain(const LightTrial& trial, std::size_t ratio);

/// The factors by which the square of a splat's value counts in LightTrial::shared_error, for each
/// ratio of kLightPathRatios. The splat's value includes its share of the light.
/// ratio     of the densities in the trial, q n / p; infinite for light that camera paths do not
///           find
/// of_trial  light paths of the trial for each path from the camera
[[nodiscard]] std::array<double, kLightPathRatios.size()> splat_moments(double ratio, double of_trial);

/// The settings of the trial's picture.
[[nodiscard]] Settings light_trial_settings(const Settings& settings);
/// The number of paths from the camera in it.
[[nodiscard]] std::uint64_t paths_of_light_trial(const Settings& settings);

/// picture   of a program with the stages of light paths
/// settings  of the image. throws DeviceError
[[nodiscard]] LightTrialResult run_light_trial(PilotPicture& picture, const PackedScene& scene,
                                               const Features& features, const Settings& settings);

}  // namespace eikon
