// SPDX-License-Identifier: Apache-2.0
#include "job/prepare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/clock.h"
#include "core/error.h"
#include "io/text.h"
#include "job/sequence/poses.h"
#include "scene/environment/environment.h"
#include "scene/environment/studio.h"
#include "pack/lights/arriving_light.h"
#include "pack/lights/pack_light_paths.h"
#include "render/pilot/pilot.h"

namespace eikon {
namespace {

constexpr std::uint32_t kDefaultRows = 720;
constexpr double kDefaultAspect = 16.0 / 9.0;
constexpr double kDefaultFovRad = 0.7;
constexpr double kMinLight = 0.01;  // see arriving_light(): less is too dark to show a shape

void require_perspective(const Camera& camera, const std::string& flag, const char* what) {
  if (camera.projection == Projection::perspective) return;
  throw UsageError(fmt::format(
      "{}: camera '{}' is {} and has no {}; leave it out, or choose a perspective with --camera or --look-at", flag,
      camera.name, camera.projection == Projection::panorama ? "a panorama" : "orthographic", what));
}

/// Changes the camera's own lens by what was asked for.
void choose_lens(const LensOptions& options, Camera& camera) {
  if (options.f_number) {
    const double f_number = *options.f_number;
    require_perspective(camera, f_number == 0 ? "--f-number off" : fmt::format("--f-number {}", f_number), "lens");
    if (f_number > 0 && !camera.lens && !options.focus_distance_m)
      throw UsageError("--f-number: at which distance is it sharp? Say so with --focus-distance METRES");
    if (f_number == 0) {
      camera.lens.reset();
    } else {
      if (!camera.lens) camera.lens.emplace();
      camera.lens->radius_m = 0;
      camera.lens->f_number = f_number;
    }
  }
  if (!options.focus_distance_m) return;
  const std::string flag = fmt::format("--focus-distance {}", *options.focus_distance_m);
  require_perspective(camera, flag, "lens");
  if (!camera.lens)
    throw UsageError(fmt::format(
        "{}: camera '{}' is a pinhole, to which everything is sharp; open it with --f-number N", flag, camera.name));
  camera.lens->focus_distance_m = *options.focus_distance_m;
}

const Camera& camera_called(const std::string& wanted, const Scene& scene) {
  const auto named = std::ranges::find(scene.cameras, wanted, &Camera::name);
  if (named != scene.cameras.end()) return *named;
  const bool is_number = wanted.find_first_not_of("0123456789") == std::string::npos && wanted.size() < 9;
  if (const std::size_t index = is_number ? std::stoul(wanted) : scene.cameras.size(); index < scene.cameras.size())
    return scene.cameras[index];
  std::string known;
  for (const Camera& camera : scene.cameras) known += fmt::format("{}'{}'", known.empty() ? "" : ", ", camera.name);
  throw UsageError(fmt::format("--camera {}: no such camera in {}; it has {}", wanted, scene.path.string(),
                               known.empty() ? "none" : known));
}

Camera choose_camera(const SceneOptions& options, const Scene& scene, double aspect, const Log& log) {
  Camera camera;
  const double fov_rad = options.fov_deg.value_or(0) * std::numbers::pi / 180.0;
  if (options.look_at) {
    const LookAt& view = *options.look_at;
    camera = look_at_camera(view.eye, view.target, view.up, options.fov_deg ? fov_rad : kDefaultFovRad);
    camera.name = "--look-at";
  } else if (!options.camera.empty()) {
    camera = camera_called(options.camera, scene);
  } else if (!scene.cameras.empty()) {
    camera = scene.cameras.front();
  } else {
    camera = framing_camera(options, scene, aspect);
    log("the file has no camera: the whole scene is framed; choose with --look-at EYE:TARGET");
  }
  if (options.panorama) {
    camera.projection = Projection::panorama;
    camera.aspect = 2;
  }
  if (options.fov_deg) {
    require_perspective(camera, fmt::format("--fov {}", *options.fov_deg), "field of view");
    camera.yfov_rad = fov_rad;
  }
  choose_lens(options.lens, camera);
  return camera;
}

double asked_aspect(const SceneOptions& options) {
  return options.size ? double(options.size->width) / options.size->height : kDefaultAspect;
}

/// Decides whether the neutral studio lights a scene that has no environment, and logs why. The
/// time of an animation does not count, so that the studio is on or off for a whole sequence.
bool needs_studio(const SceneOptions& options, const Scene& scene, const Settings& settings, const Log& log) {
  constexpr const char* kChoose = "choose with --env none, neutral, FILE or R,G,B";
  if (!is_lit_at_some_time(options, scene)) {
    log(fmt::format("the scene has no light: the neutral studio is used; {}", kChoose));
    return true;
  }
  if (first_emitter(scene) == nullptr && scene.lights.empty()) return false;  // all of it is unlit
  const double aspect = asked_aspect(options);
  const double arriving = most_light(options, scene, aspect, kMinLight, [&](const Scene& pose) {
    Settings seen = settings;
    if (&pose != &scene) seen.camera = choose_camera(options, pose, aspect, [](const std::string&) {});
    return arriving_light(pose, seen);
  });
  if (arriving >= kMinLight) return false;
  log(
      fmt::format("the scene's own lights leave what the camera sees dark (white paper would have a radiance of {:.1e} "
                  "there): the neutral studio is added; {}",
                  arriving, kChoose));
  return true;
}

Environment choose_environment(const SceneOptions& asked, const Scene& scene, const Settings& settings,
                               const Log& log) {
  const EnvironmentOptions& options = asked.environment;
  Environment environment;
  if (options.loaded) {
    environment.map = options.loaded;
  } else if (!options.map.empty()) {
    std::vector<std::string> warnings;
    environment.map = load_environment(options.map, warnings);
    for (const std::string& warning : warnings) log(warning);
  } else if (options.radiance) {
    environment.radiance = *options.radiance;
  } else if (!options.neutral && scene.environment) {
    environment = *scene.environment;
  } else if (options.neutral || needs_studio(asked, scene, settings, log)) {
    environment.map = neutral_studio();
  } else if (options.scale != 1 || options.rotate_deg != 0) {
    log("there is no environment for --env-scale and --env-rotate; give one with --env");
  }
  environment.scale *= options.scale;
  environment.rotation_rad += options.rotate_deg * std::numbers::pi / 180.0;
  if (environment.map) return environment;
  environment.radiance *= float(options.scale);
  for (int c = 0; c < 3; ++c)
    if (!(double(environment.radiance[c]) <= kMaxRadiance))
      throw UsageError(fmt::format("--env-scale {}: the environment's radiance becomes more than {:g}", options.scale,
                                   kMaxRadiance));
  return environment;
}

/// Logs what was left out of the scene; with --strict that is an error.
void report_unsupported(const SceneOptions& options, const Scene& scene, const Log& log) {
  const auto left_out = [](const Unsupported& feature) {
    return fmt::format("{}: {}: not supported, left out", feature.user, feature.feature);
  };
  if (options.strict && !scene.out_of_range.empty())
    throw InputError(fmt::format("{}: {} (--strict)", options.scene, scene.out_of_range.front()));
  if (options.strict && !scene.unsupported.empty())
    throw InputError(fmt::format("{}: {} (--strict)", options.scene, left_out(scene.unsupported.front())));
  for (const std::string& warning : scene.warnings) log(warning);
  for (const Unsupported& feature : scene.unsupported) log(left_out(feature));
}

/// The poses of the camera while the shutter is open; none if it stands still.
std::vector<Camera> camera_poses(const SceneOptions& options, const Scene& scene, double aspect, const Camera& camera) {
  std::vector<Camera> poses;
  if (options.look_at || scene.cameras.empty()) return poses;
  for (const auto& pose : scene.poses)
    poses.push_back(choose_camera(options, *pose, aspect, [](const std::string&) {}));
  if (std::ranges::all_of(poses, [&](const Camera& pose) { return same_view(pose, camera); })) poses.clear();
  return poses;
}

bool has_motion_layer(const SceneOptions& options) {
  return std::ranges::find(options.aovs, "motion") != options.aovs.end();
}

/// The camera as it stands in the next frame, for the layer `motion`; nothing without it. throws
/// UsageError
std::optional<Camera> next_camera(const SceneOptions& options, const Scene& scene, double aspect,
                                  const Camera& camera) {
  if (!has_motion_layer(options)) return std::nullopt;
  if (camera.projection == Projection::panorama)
    throw UsageError(
        "--aov motion: a panorama has no way on the picture that is straight; leave out the layer or --panorama");
  if (scene.next == nullptr || options.look_at || scene.cameras.empty()) return std::nullopt;
  return choose_camera(options, *scene.next, aspect, [](const std::string&) {});
}

/// Logs what the shutter blurs.
void log_shutter(const SceneOptions& options, const Scene& scene, const Settings& settings, const Log& log) {
  const Shutter shutter = options.animation.choice().shutter;
  if (!shutter.is_open()) return;
  if (!moves(scene, settings)) {
    log(fmt::format("--shutter {}: nothing moves while it is open", options.animation.shutter));
    return;
  }
  const bool has_targets = std::ranges::any_of(scene.materials, is_light_target);
  std::string left_out = options.light_paths.value_or(kUsualLightPaths) > 0 && has_targets ? "no light paths" : "";
  if (options.guiding != settings.guiding) left_out += left_out.empty() ? "no guiding" : " and no guiding";
  log(fmt::format("the shutter is open from {:.6g} to {:.6g} s, in {} step{}{}{}", shutter.open_s, shutter.close_s,
                  scene.shutter.steps, scene.shutter.steps == 1 ? "" : "s", left_out.empty() ? "" : "; with ",
                  left_out));
}

void settle_camera_and_size(const SceneOptions& options, const Scene& scene, Settings& settings, const Log& log) {
  const double asked = asked_aspect(options);
  settings.camera = choose_camera(options, scene, asked, log);
  if (options.size) {
    settings.width = options.size->width;
    settings.height = options.size->height;
  } else {
    const double aspect = settings.camera.aspect > 0 ? settings.camera.aspect : kDefaultAspect;
    settings.height = kDefaultRows;
    settings.width = std::uint32_t(std::lround(std::clamp(aspect * kDefaultRows, 1.0, double(kMaxImageSide))));
  }
  settings.camera_poses = camera_poses(options, scene, asked, settings.camera);
  settings.next_camera = next_camera(options, scene, asked, settings.camera);
  const Crop whole{0, 0, settings.width, settings.height};
  const Crop crop = settings.crop = options.crop.value_or(whole);
  if (crop.x0 >= crop.x1 || crop.y0 >= crop.y1 || crop.x1 > whole.x1 || crop.y1 > whole.y1)
    throw UsageError(fmt::format("--crop {},{},{},{}: not a window of the {} x {} image", crop.x0, crop.y0, crop.x1,
                                 crop.y1, settings.width, settings.height));
}

/// The integrator, with the rules of which flags go together.
void settle_integrator(const SceneOptions& options, Settings& settings) {
  const IntegratorChoice integrator = options.integrator;
  const bool raycast = integrator == IntegratorChoice::raycast, whitted = integrator == IntegratorChoice::whitted;
  settings.integrator = raycast ? Integrator::raycast : whitted ? Integrator::whitted : Integrator::path;
  const bool is_direct = integrator == IntegratorChoice::direct;
  if (options.roulette_survival == 1 && options.max_depth == 0 && !is_direct)
    throw UsageError("--roulette 1: no path would ever end; give --max-depth");
  settings.max_depth = options.max_depth;
  if (is_direct || raycast) settings.max_depth = settings.max_depth == 0 ? 2 : std::min(settings.max_depth, 2U);
  settings.roulette_survival = options.roulette_survival;
  if (settings.roulette_survival > 0) settings.roulette_depth = 2;

  settings.light_sampling = options.light_sampling;
  const bool samples = samples_lights(options.light_sampling);
  if (whitted || raycast) {
    if (!samples)
      throw UsageError(fmt::format("--integrator {} finds light by shadow rays alone: leave out --light-sampling {}",
                                   name_of(settings.integrator), name_of(options.light_sampling)));
    settings.light_sampling = LightSampling::light;
  }
  settings.light_samples = options.light_samples;
  if (options.light_samples == 1) return;
  if (!is_direct)
    throw UsageError(fmt::format("--light-samples {}: {}; leave it out, or choose --integrator direct",
                                 options.light_samples,
                                 raycast ? "raycast has a shadow ray for each light as it is"
                                         : "a path goes on with one ray, and is best with one light at each vertex"));
  if (!samples)
    throw UsageError(fmt::format("--light-samples {}: --light-sampling {} samples no light; leave one of them out",
                                 options.light_samples, name_of(options.light_sampling)));
}

/// Logs which lights of the scene will give less than one may expect.
void log_unseen_lights(const Scene& scene, const Settings& settings, const Log& log) {
  if (scene.lights.empty()) return;
  if (!samples_lights(settings.light_sampling))
    log(fmt::format("--light-sampling {}: no ray can meet a point, spot or directional light: they give no light",
                    name_of(settings.light_sampling)));
  const auto hides_light = [&](const Material& m) {
    return m.transmission > 0 && (settings.light_path_count == 0 || !is_light_target(m));
  };
  if (std::ranges::any_of(scene.materials, hides_light))
    log(fmt::format(
        "light of point, spot and directional lights does not pass through {}transmissive surfaces: what is "
        "behind them stays in their shadow; area lights and environments light it",
        settings.light_path_count == 0 ? "" : "very rough "));
}

/// throws UsageError, with the flag that asks for them, if the way of rendering has no light paths
void require_light_paths(const SceneOptions& options, const std::string& flag) {
  const auto refuse = [&](const std::string& why) { throw UsageError(flag + ": " + why); };
  if (options.integrator != IntegratorChoice::path)
    refuse("this --integrator has no light paths; leave it out, or choose --integrator path");
  if (options.light_sampling != LightSampling::mis)
    refuse(
        fmt::format("--light-sampling {} has no light paths; leave one of them out", name_of(options.light_sampling)));
}

/// throws UsageError if the other flags leave no light to merge, or do not allow a bias
void settle_caustics(const SceneOptions& options, Settings& settings) {
  settings.merges_caustics = options.merges_caustics;
  if (!options.merges_caustics) return;
  const auto refuse = [](const std::string& why) { throw UsageError("--caustics merge: " + why); };
  if (options.strict) refuse("the image would have a bias, which --strict does not allow; leave one of them out");
  require_light_paths(options, "--caustics merge");
  if (options.light_paths == 0.0) refuse("photons come by light paths; leave out --light-paths off");
}

/// The number of light paths that is asked for, or a trial of it. A picture without a trial has
/// light paths if they find light that nothing else finds.
/// throws UsageError if the way of rendering has none of those that are asked for
void settle_light_paths(const SceneOptions& options, const Scene& scene, Settings& settings) {
  if (options.light_paths.value_or(0) > 0) require_light_paths(options, "--light-paths");
  const bool light_paths_needed = only_light_paths_find_some(scene);
  const double usual = light_paths_needed ? kUsualNeededLightPaths : kUsualLightPaths;
  settings.light_path_count = light_paths_of_ratio(settings, options.light_paths.value_or(usual));
  if (options.light_paths) return;
  if (options.tries_light_paths) settings.light_trial_paths = usual_light_trial_paths(settings, light_paths_needed);
  const bool finds_more = options.merges_caustics || std::ranges::any_of(scene.materials, is_specular_light_target);
  if (settings.light_trial_paths == 0 && !finds_more) settings.light_path_count = 0;
}

}  // namespace

bool names_environment_file(const std::string& text) {
  return text != "none" && text != "neutral" && !number_in<double>(text.substr(0, text.find(',')));
}

AnimationChoice AnimationOptions::choice() const {
  AnimationChoice choice{.animation = name, .time_s = frame ? double(*frame) / fps : time_s, .loop = loop};
  const double open_for_s = shutter / fps, open_s = choice.time_s - shutter_at * open_for_s;
  if (shutter > 0) choice.shutter = {.open_s = open_s, .close_s = open_s + open_for_s, .steps = motion_steps};
  return choice;
}

SceneChoice SceneOptions::choice() const {
  SceneChoice choice{.variant = variant, .animation = animation.choice()};
  if (has_motion_layer(*this)) choice.animation.next_s = choice.animation.time_s + 1 / animation.fps;
  return choice;
}

Prepared prepare(const SceneOptions& options, const Log& log, MissingTangents missing_tangents) {
  const double begin = host_seconds();
  auto scene = std::make_shared<Scene>(load_scene(options.scene, options.choice(), missing_tangents));
  const double load_s = host_seconds() - begin;
  Prepared prepared = prepare(options, std::move(scene), log);
  prepared.load_s = load_s;
  return prepared;
}

Prepared prepare(const SceneOptions& options, std::shared_ptr<Scene> loaded, const Log& log) {
  Prepared prepared;
  prepared.scene = std::move(loaded);
  const Scene& scene = *prepared.scene;
  report_unsupported(options, scene, log);
  Settings& settings = prepared.settings;
  settle_camera_and_size(options, scene, settings, log);
  prepared.camera_name = settings.camera.name;
  const SampleRange samples = options.samples.value_or(SampleRange{0, options.spp.value_or(kUsualSpp)});
  settings.sample_begin = samples.begin;
  settings.sample_end = samples.end;
  if (samples.end - samples.begin > kMaxImagePaths / settings.crop.pixel_count())
    throw UsageError(
        fmt::format("{} samples of each of {} pixels are more than 2^60 in all; ask for fewer by --spp or --samples",
                    samples.end - samples.begin, settings.crop.pixel_count()));
  settings.culling = options.culling;
  settings.guiding = scene.moves_surfaces || scene.moves_lights ? Guiding::off : options.guiding;
  settings.environment = choose_environment(options, scene, settings, log);
  settings.filter = options.filter;
  settings.transparent = options.transparent;
  settings.seed = std::uint32_t(options.seed);
  settings.energy_compensation = options.energy_compensation;
  settle_integrator(options, settings);
  settle_light_paths(options, scene, settings);
  settle_caustics(options, settings);
  settings.pilot_paths = usual_pilot_paths(settings);
  if (options.pilot_paths && settings.pilot_paths > 0) settings.pilot_paths = *options.pilot_paths;
  prepared.layers = settings.aovs = options.aovs;
  if (options.denoise)
    for (const char* auxiliary : {"albedo", "normal"})
      if (std::ranges::find(settings.aovs, auxiliary) == settings.aovs.end()) settings.aovs.emplace_back(auxiliary);
  settings.depth_series.assign(options.depth_series.begin(), options.depth_series.end());
  // So that the record of a film without them is that of earlier versions.
  if (!Features(scene, settings).has(Feature::light_paths)) {
    settings.light_path_count = settings.light_trial_paths = 0;
    if (std::exchange(settings.merges_caustics, false))
      log("--caustics merge: this scene has no light paths, so nothing is merged, and the image has no bias");
  }
  if (settings.merges_caustics)
    log("--caustics merge: the image has a bias, which falls as samples are added: what glass and mirrors light up is "
        "blurred where it is seen through glass or in a mirror");
  log_unseen_lights(scene, settings, log);
  log_shutter(options, scene, settings, log);
  return prepared;
}

}  // namespace eikon
