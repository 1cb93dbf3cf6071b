// SPDX-License-Identifier: Apache-2.0
// The flags that say what is rendered and from where; shared by `render`, `info` and `bench rays`.
#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "pack/settings.h"

namespace eikon {

struct SceneOptions {
  std::string scene;
  std::string size, camera, look_at, env, variant, integrator = "path", light_sampling = "mis", aovs, samples, crop,
                                                   filter = "box", f_number, focus_distance;
  double fov_deg = 0, env_scale = 1, env_rotate_deg = 0;
  std::uint64_t spp = 64;
  std::uint64_t seed = 0;
  std::uint32_t max_depth = 0, light_samples = 1;
  float roulette = 0;
  std::string energy_compensation = "off";
  std::set<std::uint32_t> depth_series;  // of `render` alone, as is denoise
  bool transparent = false, strict = false, panorama = false, denoise = false;

  /// Adds the flags to a subcommand. The object must live as long as the parser.
  void add_to(CLI::App& command);
  /// Some of them: the scene, and how strictly it is read; the environment; how paths are sampled and where they end.
  void add_scene_to(CLI::App& command);
  void add_environment_to(CLI::App& command);
  void add_sampling_to(CLI::App& command, const std::string& spp_means);
};

/// Everything `render` needs of the flags and the scene, with defaults by the scene.
struct Prepared {
  std::shared_ptr<Scene> scene;
  Settings settings;
  std::vector<std::string> layers;  // of --aov
  std::string camera_name;
  double load_s = 0;
};

/// Takes one line of what the user should know, without an end of line.
using Say = std::function<void(const std::string&)>;
/// After "eikon: " on stderr, or nowhere.
[[nodiscard]] Say say_on_stderr(bool quiet);

/// Loads the scene and settles camera, size, light and samples; says what was decided for the user.
/// throws InputError, UsageError
Prepared prepare(const SceneOptions& options, const Say& say);
/// The same for a scene that is loaded already.
Prepared settle(const SceneOptions& options, std::shared_ptr<Scene> scene, const Say& say);

}  // namespace eikon
