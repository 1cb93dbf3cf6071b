// SPDX-License-Identifier: Apache-2.0
// The flags that say what is rendered and from where; shared by `render`, `info` and `bench rays`.
#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "render/settings.h"

namespace eikon {

struct SceneOptions {
  std::string scene;
  std::string size, camera, look_at, env, integrator = "path", light_sampling = "mis", aovs, samples, crop,
                                          filter = "box";
  double fov_deg = 0, env_scale = 1, env_rotate_deg = 0;
  std::uint64_t spp = 64;
  std::uint64_t seed = 0;
  std::uint32_t max_depth = 0;
  bool transparent = false, strict = false;

  /// Adds the flags to a subcommand. The object must live as long as the parser.
  void add_to(CLI::App& command);
};

/// Everything `render` needs of the flags and the scene, with defaults by the scene.
struct Prepared {
  Scene scene;
  Settings settings;
  std::vector<std::string> layers;  // of --aov
  std::string camera_name;
  double load_s = 0;
};

/// Loads the scene and settles camera, size, light and samples; says on stderr what was decided for the user.
/// throws InputError, UsageError
Prepared prepare(const SceneOptions& options, bool quiet);

}  // namespace eikon
