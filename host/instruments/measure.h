// SPDX-License-Identifier: Apache-2.0
// A virtual gonioreflectometer.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "device/device.h"
#include "scene/scene.h"

namespace eikon {

/// f of a material of the scene in every cell of a MERL table, as the kernels have it: R, G, B in the order of read_merl, negative
/// where a direction lies below the surface. The front is measured, without its normal maps, opacity and emission; where it has
/// textures, at `uv`. Nodes, meshes and shapes of the scene are dropped.
/// optimise  of the kernel's compilation
/// throws InputError with the material: unlit, anisotropic, a perfect mirror in part, or light passes: no such table holds that
[[nodiscard]] std::vector<float> measure(Scene& scene, std::uint32_t material, const glm::vec2& uv, Device& device,
                                         bool optimise = true);

}  // namespace eikon
