// SPDX-License-Identifier: Apache-2.0
// Makes the settings of a render from its options and the scene.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "job/log.h"
#include "job/scene_options.h"

namespace eikon {

/// A loaded scene, and everything that decides its image.
struct Prepared {
  std::shared_ptr<Scene> scene;
  Settings settings;
  std::vector<std::string> layers;  // of --aov
  std::string camera_name;
  double load_s = 0;
};

/// Loads the scene and settles camera, size, light and samples; logs what it decided for the user.
/// throws InputError, UsageError
Prepared prepare(const SceneOptions& options, const Log& log);
/// The same for a scene that is loaded already.
Prepared settle(const SceneOptions& options, std::shared_ptr<Scene> scene, const Log& log);

}  // namespace eikon
