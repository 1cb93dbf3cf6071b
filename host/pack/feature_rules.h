// SPDX-License-Identifier: Apache-2.0
// Decides by one rule for each feature whether a scene and its settings need it.
#pragma once
#include <vector>

#include "pack/features.h"
#include "pack/lights/light_counts.h"

namespace eikon {

/// The facts that the rules look at, found once for all of them.
struct SceneFacts {
  const Scene& scene;
  const Settings& settings;
  std::vector<const Material*> materials;  // that some node shows
  std::vector<const Mesh*> meshes;         // likewise
  LightCounts lights;
  bool is_lit = false;  // there is a light of some kind

  SceneFacts(const Scene& of_scene, const Settings& with_settings);
};

/// Decides a feature. No decision depends on another one.
[[nodiscard]] Need need_of(Feature feature, const SceneFacts& facts);

}  // namespace eikon
