// SPDX-License-Identifier: Apache-2.0
// What stands in the header of an image.
#pragma once
#include "cli/scene_options.h"
#include "image/image.h"
#include "render/render.h"

namespace eikon {

/// What decides the converged picture: scene, camera, size, environment, filter, depth. Two renders that agree in it differ by
/// noise alone.
[[nodiscard]] Metadata describe_picture(const Prepared& prepared);

/// That, and how it was rendered: samples, seed, devices, predicted error.
[[nodiscard]] Metadata describe_render(const Prepared& prepared, const RenderReport& report,
                                       const PredictedError& error);

}  // namespace eikon
