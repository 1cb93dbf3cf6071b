// SPDX-License-Identifier: Apache-2.0
// The component types of accessors by glTF's numbers, and the one primitive of a scene that has
// one.
#pragma once
#include "scene/scene.h"

namespace scene_test {

inline constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125,
                     kFloat = 5126;

inline eikon::Primitive only_primitive(const eikon::Scene& scene) { return scene.meshes.at(0).primitives.at(0); }

}  // namespace scene_test
