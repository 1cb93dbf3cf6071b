// SPDX-License-Identifier: Apache-2.0
// The header of an image.
#pragma once
#include "job/prepare.h"
#include "image/image.h"
#include "render/render.h"

namespace eikon {

/// "r,g,b", or a map's file with its scale and rotation.
[[nodiscard]] std::string describe(const Environment& environment);

/// Describes what decides the converged picture: scene, camera, size, environment, filter, depth.
/// Two renders that agree in it differ by noise alone.
[[nodiscard]] Metadata describe_picture(const Prepared& prepared);

/// Describes that, and what decides the noise: seed, range of samples, how light is sampled.
[[nodiscard]] Metadata describe_image(const Prepared& prepared);

/// Counts the samples that were rendered but left out of the film's sums, because their radiance
/// was not finite or beyond the film's range. done: all samples that were rendered
[[nodiscard]] std::uint64_t rejected_in(const Film& film, const SampleSet& done);

/// Adds what a film holds: its samples, how many of them were rejected, and the classes of
/// arithmetic that they come from.
void add_sample_counts(Metadata& metadata, const Film& film, const SampleSet& done,
                       const std::set<std::string>& arithmetic);
void add_error(Metadata& metadata, const PredictedError& error);

/// Describes all that, and how it was rendered: devices, time.
[[nodiscard]] Metadata describe_render(const Prepared& prepared, const RenderOutput& done, const PredictedError& error);

}  // namespace eikon
