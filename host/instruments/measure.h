// SPDX-License-Identifier: Apache-2.0
// A virtual gonioreflectometer: it tabulates the BRDF of a material.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "device/device.h"
#include "scene/scene.h"

namespace eikon {

/// Evaluates the BRDF of a material of the scene, as the kernels compute it, in every cell of a
/// MERL
/// table: R, G, B in the order of read_merl(), negative where a direction lies below the surface.
/// It measures the front, without normal maps, opacity and emission, with textures at `uv`. Nodes,
/// meshes and shapes of the scene are dropped.
/// optimise  compile the kernel with optimisation
/// throws InputError with the material when no such table can hold it: an unlit, anisotropic or
/// partly perfectly specular material, or one that transmits light
[[nodiscard]] std::vector<float> measure(Scene& scene, std::uint32_t material, const glm::vec2& uv, Device& device,
                                         bool optimise = true);

}  // namespace eikon
