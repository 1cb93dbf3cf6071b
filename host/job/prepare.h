// SPDX-License-Identifier: Apache-2.0
// Makes the settings of a render from its options and the scene.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>
#include <glm/glm.hpp>

#include "job/log.h"
#include "pack/settings.h"

namespace eikon {

struct ImageSize {
  std::uint32_t width = 0, height = 0;  // pixels, at least 1
};

struct SampleRange {
  std::uint64_t begin = 0, end = 0;  // half-open
};

/// A perspective camera given by hand; world space, metres.
struct LookAt {
  glm::dvec3 eye{}, target{}, up{0, 1, 0};
};

/// The lens: what is unset comes from the scene's camera.
struct LensOptions {
  std::optional<double> f_number;  // 0: a pinhole
  std::optional<double> focus_distance_m;
};

/// At most one of `map`, `radiance` and `neutral`; none: the scene's environment, or the neutral
/// studio where the scene is dark without it.
struct EnvironmentOptions {
  std::string map;                    // OpenEXR or Radiance file
  std::shared_ptr<const EnvironmentMap> loaded{};  // what `map` or `neutral` stand for, if that is in memory already
  std::optional<glm::vec3> radiance;  // constant, W/(sr m^2)
  bool neutral = false;               // scene/environment/studio.h
  double scale = 1, rotate_deg = 0;   // of whichever environment is used
};

/// Returns true if what --env takes names the file of a map. Else it is `none`, `neutral`, or
/// R,G,B, as all is that begins with a number.
[[nodiscard]] bool names_environment_file(const std::string& text);

/// `direct` is `path` with at most two edges.
enum class IntegratorChoice { path, direct, whitted, raycast };

/// A time by seconds or by the number of a frame.
struct AnimationOptions {
  std::string name;  // as AnimationChoice::animation
  double time_s = 0;
  bool loop = false;
  std::optional<std::uint64_t> frame{};
  double fps = 24;                 // frames per second
  double shutter = 0;              // frames for which it is open
  double shutter_at = 0;           // share of that time that has passed at the time of the frame: 0, 0.5 or 1
  std::uint32_t motion_steps = 0;  // Shutter::steps

  [[nodiscard]] AnimationChoice choice() const;
};

inline constexpr std::uint64_t kUsualSpp = 64;  // samples per pixel
// Light paths for each path from the camera, of an image without a trial; and those of one that
// needs them, because only light paths find some of its light (only_light_paths_find_some).
inline constexpr double kUsualLightPaths = 1.0 / 16, kUsualNeededLightPaths = 1.0 / 4;

/// The wishes of a user for the scene, the camera and the picture. They decide all of the Settings.
struct SceneOptions {
  std::string scene;    // glTF file
  std::string variant;  // KHR_materials_variants; empty: none
  AnimationOptions animation;
  bool strict = false;  // what is not supported, and rejected samples, are errors

  std::string camera;  // by name or index; empty: the first
  std::optional<LookAt> look_at;
  std::optional<double> fov_deg;  // vertical
  bool panorama = false;
  LensOptions lens;

  std::optional<ImageSize> size;  // default: 720 rows at the camera's aspect
  std::optional<Crop> crop;
  Culling culling = Culling::camera;
  std::optional<double> light_paths;  // for each path from the camera; 0: none; default: by a trial, or the usual ones
  bool tries_light_paths = true;  // false: no trial decides on their number
  bool merges_caustics = false;  // with a bias: Settings::merges_caustics
  Guiding guiding = Guiding::automatic;
  std::optional<std::uint64_t> pilot_paths;  // default: usual_pilot_paths()
  PixelFilter filter;
  bool transparent = false;
  std::vector<std::string> aovs;         // each once
  std::set<std::uint32_t> depth_series;  // of `render` alone, as is denoise
  bool denoise = false;

  EnvironmentOptions environment;

  std::optional<std::uint64_t> spp;    // default: kUsualSpp
  std::optional<SampleRange> samples;  // default: 0 to spp
  std::uint64_t seed = 0;
  std::uint32_t max_depth = 0;  // 0: no limit
  float roulette_survival = 0;  // constant survival probability; 0: by throughput
  IntegratorChoice integrator = IntegratorChoice::path;
  LightSampling light_sampling = LightSampling::mis;
  std::uint32_t light_samples = 1;
  bool energy_compensation = false;

  [[nodiscard]] SceneChoice choice() const;
};

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
Prepared prepare(const SceneOptions& options, const Log& log, MissingTangents missing_tangents = MissingTangents::make);
/// The same for a scene that is loaded already.
Prepared prepare(const SceneOptions& options, std::shared_ptr<Scene> scene, const Log& log);

}  // namespace eikon
