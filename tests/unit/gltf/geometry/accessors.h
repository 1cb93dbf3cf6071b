// SPDX-License-Identifier: Apache-2.0
// The one primitive of a scene that has one.
#pragma once
#include "scene/scene.h"

namespace scene_test {

inline eikon::Primitive only_primitive(const eikon::Scene& scene) { return scene.meshes.at(0).primitives.at(0); }

}  // namespace scene_test
