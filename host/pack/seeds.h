// SPDX-License-Identifier: Apache-2.0
// The seeds that set parts of a render apart from the samples of its image. They stand side by
// side, so that no two of them become the same. A third one is in kernels/stages/light/generate.h:
// EK_LIGHT_PATH_SEED, 0x6c70a7b5, sets light paths apart from camera paths.
#pragma once
#include <cstdint>

namespace eikon {

/// Replaces the seed of the image in a pilot. No image has it by default, so the pilot does not see
/// the samples of the image that it decides about.
inline constexpr std::uint32_t kPilotSeed = 0x70696c6fU;
/// The light paths of photons have this XOR the seed of the image, which sets them apart from those
/// of splats.
inline constexpr std::uint32_t kPhotonSeed = 0x70686f74U;

}  // namespace eikon
