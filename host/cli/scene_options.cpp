// SPDX-License-Identifier: Apache-2.0
#include "cli/scene_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "cli/arguments.h"
#include "job/tell.h"
#include "core/error.h"
#include "core/clock.h"
#include "film/layers.h"
#include "scene/environment.h"

namespace eikon {
namespace {

constexpr std::uint32_t kDefaultRows = 720;
constexpr double kDefaultAspect = 16.0 / 9.0;
constexpr std::uint64_t kMaxSide = 65535;  // pixel coordinates travel as two 16-bit halves
constexpr double kMaxRadiance = 1e30;
constexpr double kMinFNumber = 1e-3, kMaxFNumber = 1e6;
constexpr double kMaxFocusDistance = 0x1p40;
constexpr std::uint64_t kMaxSamples = std::uint64_t{1} << 48;

void require_perspective(const Camera& camera, const std::string& flag, const char* what) {
  if (camera.projection == Projection::perspective) return;
  throw UsageError(fmt::format(
      "{}: camera '{}' is {} and has no {}; leave it out, or choose a perspective with --camera or --look-at", flag,
      camera.name, camera.projection == Projection::panorama ? "a panorama" : "orthographic", what));
}

// The file's lens, with what the flags say otherwise.
void choose_lens(const SceneOptions& options, Camera& camera) {
  const bool pinhole = options.f_number == "off";
  if (!options.f_number.empty()) {
    require_perspective(camera, "--f-number " + options.f_number, "lens");
    const double f_number = pinhole ? 0 : parse_numbers("--f-number", options.f_number, 1)[0];
    if (!pinhole && !(f_number >= kMinFNumber && f_number <= kMaxFNumber))
      throw UsageError(fmt::format("--f-number {}: lies between {:g} and {:g}; off is a pinhole", options.f_number,
                                   kMinFNumber, kMaxFNumber));
    if (!pinhole && !camera.lens && options.focus_distance.empty())
      throw UsageError("--f-number: at which distance is it sharp? Say it with --focus-distance METRES");
    if (pinhole)
      camera.lens.reset();
    else
      camera.lens.emplace(camera.lens.value_or(Lens{})).radius_m = 0, camera.lens->f_number = f_number;
  }
  if (options.focus_distance.empty()) return;
  require_perspective(camera, "--focus-distance " + options.focus_distance, "lens");
  if (!camera.lens)
    throw UsageError(
        fmt::format("--focus-distance {}: camera '{}' is a pinhole, to which everything is sharp; open it with "
                    "--f-number N",
                    options.focus_distance, camera.name));
  camera.lens->focus_distance_m = parse_numbers("--focus-distance", options.focus_distance, 1)[0];
  if (!(camera.lens->focus_distance_m > 0 && camera.lens->focus_distance_m <= kMaxFocusDistance))
    throw UsageError(
        fmt::format("--focus-distance {}: lies between 0 and {:g} metres", options.focus_distance, kMaxFocusDistance));
}

Camera choose_camera(const SceneOptions& options, const Scene& scene, double aspect, const Say& say) {
  Camera camera;
  const double fov = options.fov_deg * std::numbers::pi / 180.0;
  if (!options.look_at.empty()) {
    const std::vector<std::string> parts = split(options.look_at, ':');
    if (parts.size() != 2 && parts.size() != 3)
      throw UsageError(fmt::format("--look-at {}: takes EYE:TARGET[:UP], each x,y,z", options.look_at));
    const auto point = [&](std::size_t i) {
      const std::vector<double> n = parse_numbers("--look-at", parts[i], 3);
      return glm::dvec3(n[0], n[1], n[2]);
    };
    camera =
        look_at_camera(point(0), point(1), parts.size() == 3 ? point(2) : glm::dvec3(0, 1, 0), fov > 0 ? fov : 0.7);
    camera.name = "--look-at";
  } else if (!options.camera.empty()) {
    const auto named = std::find_if(scene.cameras.begin(), scene.cameras.end(),
                                    [&](const Camera& c) { return c.name == options.camera; });
    if (named != scene.cameras.end()) {
      camera = *named;
    } else {
      std::string known;
      for (const Camera& c : scene.cameras) known += fmt::format("{}'{}'", known.empty() ? "" : ", ", c.name);
      const bool number =
          options.camera.find_first_not_of("0123456789") == std::string::npos && options.camera.size() < 9;
      const std::size_t index = number ? std::stoul(options.camera) : scene.cameras.size();
      if (index >= scene.cameras.size())
        throw UsageError(fmt::format("--camera {}: no such camera in {}; it has {}", options.camera,
                                     scene.path.string(), known.empty() ? "none" : known));
      camera = scene.cameras[index];
    }
  } else if (!scene.cameras.empty()) {
    camera = scene.cameras.front();
  } else {
    const Bounds bounds = world_bounds(scene);
    camera = frame_camera(bounds.empty() ? Bounds{glm::dvec3(-1), glm::dvec3(1)} : bounds, aspect);
    say("the file has no camera: the whole scene is framed; choose with --look-at EYE:TARGET");
  }
  if (options.panorama) {
    camera.projection = Projection::panorama;
    camera.aspect = 2;
  }
  if (fov > 0) {
    require_perspective(camera, fmt::format("--fov {}", options.fov_deg), "field of view");
    camera.yfov_rad = fov;
  }
  choose_lens(options, camera);
  return camera;
}

void parse_size(const std::string& text, std::uint32_t& width, std::uint32_t& height) {
  const std::vector<std::string> parts = split(text, 'x');
  if (parts.size() != 2) throw UsageError(fmt::format("--size {}: takes WIDTHxHEIGHT, e.g. 1280x720", text));
  width = std::uint32_t(parse_unsigned("--size", parts[0], kMaxSide));
  height = std::uint32_t(parse_unsigned("--size", parts[1], kMaxSide));
  if (width == 0 || height == 0) throw UsageError(fmt::format("--size {}: an image has at least one pixel", text));
}

// A map, or three numbers if the first piece is one.
Environment environment_of_flag(const std::string& env, const Say& say) {
  const std::string first = env.substr(0, env.find(','));
  double number = 0;
  const auto [end, code] = std::from_chars(first.data(), first.data() + first.size(), number);
  Environment environment;
  if (code == std::errc() && end == first.data() + first.size()) {
    const std::vector<double> n = parse_numbers("--env", env, 3);
    if (std::any_of(n.begin(), n.end(), [](double x) { return x < 0 || x > kMaxRadiance; }))
      throw UsageError(fmt::format("--env {}: radiance lies between 0 and {:g}", env, kMaxRadiance));
    environment.radiance = glm::vec3(float(n[0]), float(n[1]), float(n[2]));
    return environment;
  }
  std::vector<std::string> warnings;
  environment.map = load_environment(env, warnings);
  for (const std::string& warning : warnings) say(warning);
  return environment;
}

Environment choose_environment(const SceneOptions& options, const Scene& scene, const Say& say) {
  Environment environment;
  if (!options.env.empty()) {
    environment = environment_of_flag(options.env, say);
  } else if (scene.environment) {
    environment = *scene.environment;
  } else if (needs_environment(scene)) {
    say("the scene has no light: a neutral environment of radiance 1 is used; choose with --env FILE or R,G,B");
    environment.radiance = glm::vec3(1.0F);
  } else if (options.env_scale != 1 || options.env_rotate_deg != 0) {
    say("there is no environment for --env-scale and --env-rotate; give one with --env");
  }
  environment.scale *= options.env_scale;
  environment.rotation_rad += options.env_rotate_deg * std::numbers::pi / 180.0;
  if (!environment.map) {
    environment.radiance *= float(options.env_scale);
    for (int c = 0; c < 3; ++c)
      if (!(double(environment.radiance[c]) <= kMaxRadiance))
        throw UsageError(fmt::format("--env-scale {}: the environment's radiance becomes more than {:g}",
                                     options.env_scale, kMaxRadiance));
  }
  return environment;
}

void parse_samples(const SceneOptions& options, Settings& settings) {
  settings.sample_begin = 0;
  settings.sample_end = options.spp;
  if (!options.samples.empty()) {
    const std::vector<std::string> parts = split(options.samples, ':');
    if (parts.size() != 2)
      throw UsageError(fmt::format("--samples {}: takes A:B, the half-open range of samples", options.samples));
    settings.sample_begin = parse_unsigned("--samples", parts[0], kMaxSamples);
    settings.sample_end = parse_unsigned("--samples", parts[1], kMaxSamples);
  }
  if (settings.sample_begin >= settings.sample_end)
    throw UsageError(fmt::format("--samples {}: the range is empty", options.samples));
}

void parse_crop(const SceneOptions& options, Settings& settings) {
  settings.crop = {0, 0, settings.width, settings.height};
  if (options.crop.empty()) return;
  const std::vector<std::string> parts = split(options.crop, ',');
  if (parts.size() != 4)
    throw UsageError(fmt::format("--crop {}: takes X0,Y0,X1,Y1 in pixels, the last two exclusive", options.crop));
  const auto at = [&](std::size_t i) { return std::uint32_t(parse_unsigned("--crop", parts[i], kMaxSide)); };
  settings.crop = {at(0), at(1), at(2), at(3)};
  if (settings.crop.x0 >= settings.crop.x1 || settings.crop.y0 >= settings.crop.y1 ||
      settings.crop.x1 > settings.width || settings.crop.y1 > settings.height)
    throw UsageError(
        fmt::format("--crop {}: not a window of the {} x {} image", options.crop, settings.width, settings.height));
}

}  // namespace

void SceneOptions::add_to(CLI::App& command) {
  add_scene_to(command);
  command.add_option("--size", size, "WxH: image size; without it the camera's aspect at 720 rows");
  command.add_option("--camera", camera, "camera by name or index");
  command.add_option("--look-at", look_at, "EYE:TARGET[:UP], each x,y,z: a perspective camera of your own");
  command.add_option("--fov", fov_deg, "vertical field of view in degrees, of a perspective camera")
      ->check(between(0.01, 179.0));
  command.add_flag("--panorama", panorama,
                   "every direction around the camera, equirectangular, its view in the middle");
  command.add_option("--f-number", f_number,
                     "N: how wide the lens opens, as of a camera for 35 mm film; off: a pinhole");
  command.add_option("--focus-distance", focus_distance, "METRES ahead of the lens, where it is sharp");
  add_environment_to(command);
  command.add_flag("--transparent", transparent,
                   "the camera does not see the environment: channel A, with R, G, B multiplied by it");
  command
      .add_option("--filter", filter,
                  "NAME[:WIDTH] of the pixel filter; width in pixels from rim to rim. NAME (usual WIDTH): " +
                      filter_names() + ". Only mitchell sharpens: its rim is negative")
      ->capture_default_str();
  command.add_option("--samples", samples, "A:B: only samples A to B-1 of each pixel");
  command.add_option("--crop", crop, "X0,Y0,X1,Y1: only this window; same bits as in the full image");
  add_sampling_to(command, "samples per pixel");
  command.add_option("--aov", aovs, "layers beside RGB, joined by commas, of: " + layer_names());
}

void SceneOptions::add_scene_to(CLI::App& command) {
  command.add_option("SCENE", scene, "glTF 2.0 file, .gltf or .glb")->required();
  command.add_option("--variant", variant,
                     "materials of this variant of the file's (KHR_materials_variants); see info");
  command.add_flag("--strict", strict, "what is not supported, and rejected samples, are errors");
}

void SceneOptions::add_environment_to(CLI::App& command) {
  command.add_option(
      "--env", env, "instead of the file's environment: a map, FILE.exr or .hdr (equirectangular), or constant, R,G,B");
  command.add_option("--env-scale", env_scale, "factor on whichever environment is used")
      ->check(between(0.0, 1e9))
      ->capture_default_str();
  command.add_option("--env-rotate", env_rotate_deg, "DEG: turns it about +Y, what is ahead (-Z) to the left (-X)")
      ->check(between(-36000.0, 36000.0))
      ->capture_default_str();
}

void SceneOptions::add_sampling_to(CLI::App& command, const std::string& spp_means) {
  command.add_option("--spp", spp, spp_means)->check(between(1.0, double(kMaxSamples)))->capture_default_str();
  command.add_option("--seed", seed, "another seed is another, independent image")->check(between(0.0, 4294967295.0));
  command.add_option("--max-depth", max_depth, "longest path in edges from the camera; 0: no limit")
      ->capture_default_str();
  command
      .add_option("--roulette", roulette,
                  "P: after each scattering a path goes on with this probability, instead of by what it carries")
      ->check(between(0.01, 1));
  command
      .add_option(
          "--integrator", integrator,
          "path; direct: emission and direct light only; whitted: light goes on from perfect mirrors and smooth "
          "glass alone [Whitted 1980]; raycast: a shadow ray to each light, and Blinn's highlights [Appel 1968]")
      ->check(CLI::IsMember({"path", "direct", "whitted", "raycast"}))
      ->capture_default_str();
  command
      .add_option(
          "--energy-compensation", energy_compensation,
          "on: rough metal and glass give back the light that their microfacets pass to each other, which single "
          "scattering loses")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  command.add_option("--light-sampling", light_sampling, "how light is found: same mean, other noise")
      ->check(CLI::IsMember({"mis", "light", "bsdf", "cosine", "hemisphere"}))
      ->capture_default_str();
  command.add_option("--light-samples", light_samples, "N: shadow rays of each sample, with --integrator direct")
      ->check(between(1U, kMostLightSamples))
      ->capture_default_str();
}

Say say_on_stderr(bool quiet) {
  if (quiet) return [](const std::string&) {};
  return [](const std::string& line) { tell("eikon: {}\n", line); };
}

Prepared prepare(const SceneOptions& options, const Say& say) {
  const double begin = host_seconds();
  auto scene = std::make_shared<Scene>(load_scene(options.scene, options.variant));
  const double load_s = host_seconds() - begin;
  Prepared prepared = settle(options, std::move(scene), say);
  prepared.load_s = load_s;
  return prepared;
}

Prepared settle(const SceneOptions& options, std::shared_ptr<Scene> loaded, const Say& say) {
  Prepared prepared;
  prepared.scene = std::move(loaded);
  const Scene& scene = *prepared.scene;
  const auto left_out = [](const Unsupported& feature) {
    return fmt::format("{}: {}: not supported, left out", feature.user, feature.feature);
  };
  if (options.strict) {
    if (!scene.out_of_range.empty())
      throw InputError(fmt::format("{}: {} (--strict)", options.scene, scene.out_of_range.front()));
    if (!scene.unsupported.empty())
      throw InputError(fmt::format("{}: {} (--strict)", options.scene, left_out(scene.unsupported.front())));
  }
  for (const std::string& warning : scene.warnings) say(warning);
  for (const Unsupported& feature : scene.unsupported) say(left_out(feature));

  Settings& settings = prepared.settings;
  double aspect = 0;
  if (!options.size.empty()) {
    parse_size(options.size, settings.width, settings.height);
    aspect = double(settings.width) / settings.height;
  }
  settings.camera = choose_camera(options, scene, aspect > 0 ? aspect : kDefaultAspect, say);
  prepared.camera_name = settings.camera.name;
  if (options.size.empty()) {
    const double chosen = settings.camera.aspect > 0 ? settings.camera.aspect : kDefaultAspect;
    settings.height = kDefaultRows;
    settings.width = std::uint32_t(std::clamp(std::lround(chosen * kDefaultRows), 1L, long(kMaxSide)));
  }
  parse_crop(options, settings);
  parse_samples(options, settings);
  settings.environment = choose_environment(options, scene, say);
  settings.filter = parse_filter(options.filter);
  settings.transparent = options.transparent;
  settings.seed = std::uint32_t(options.seed);
  settings.max_depth = options.max_depth;
  if (options.integrator == "direct")
    settings.max_depth = settings.max_depth == 0 ? 2 : std::min(settings.max_depth, 2U);
  settings.light_sampling = options.light_sampling == "mis"          ? LightSampling::mis
                            : options.light_sampling == "light"      ? LightSampling::light
                            : options.light_sampling == "hemisphere" ? LightSampling::hemisphere
                                                                     : LightSampling::bsdf;
  if (options.roulette == 1 && settings.max_depth == 0)
    throw UsageError("--roulette 1: no path would ever end; give --max-depth");
  settings.roulette = options.roulette;
  settings.energy_compensation = options.energy_compensation == "on";
  if (settings.roulette > 0) settings.roulette_depth = 2;
  const bool raycast = options.integrator == "raycast", whitted = options.integrator == "whitted";
  settings.integrator = raycast ? Integrator::raycast : whitted ? Integrator::whitted : Integrator::path;
  if (raycast) settings.max_depth = settings.max_depth == 0 ? 2 : std::min(settings.max_depth, 2U);
  if (raycast || whitted) {
    if (options.light_sampling != "mis" && options.light_sampling != "light")
      throw UsageError(fmt::format("--integrator {} finds light by shadow rays alone: leave out --light-sampling {}",
                                   options.integrator, options.light_sampling));
    settings.light_sampling = LightSampling::light;
  }
  const bool samples = samples_lights(settings.light_sampling);
  settings.light_samples = options.light_samples;
  if (options.light_samples > 1 && options.integrator != "direct")
    throw UsageError(
        fmt::format("--light-samples {}: {}; leave it out, or choose --integrator direct", options.light_samples,
                    raycast ? "raycast has a shadow ray for each light as it is"
                                     : "a path goes on with one ray, and is best with one light at each vertex"));
  if (options.light_samples > 1 && !samples)
    throw UsageError(fmt::format("--light-samples {}: --light-sampling {} samples no light; leave one of them out",
                                 options.light_samples, options.light_sampling));
  if (!samples && !scene.lights.empty())
    say(fmt::format("--light-sampling {}: no ray can meet a point, spot or directional light: they give no light",
                    options.light_sampling));
  const bool has_glass =
      std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) { return m.transmission > 0; });
  if (has_glass && !scene.lights.empty())
    say("light of point, spot and directional lights does not pass through transmissive surfaces: what is behind them "
        "stays in their shadow; area lights and environments light it");
  for (const std::string& layer : split(options.aovs, ',')) {
    if (!is_layer(layer))
      throw UsageError(fmt::format("--aov {}: no layer '{}'; there is {}", options.aovs, layer, layer_names()));
    if (std::find(prepared.layers.begin(), prepared.layers.end(), layer) == prepared.layers.end())
      prepared.layers.push_back(layer);
  }
  settings.aovs = prepared.layers;
  if (options.denoise)
    for (const char* guide : {"albedo", "normal"})
      if (std::ranges::find(settings.aovs, guide) == settings.aovs.end()) settings.aovs.emplace_back(guide);
  settings.depth_series.assign(options.depth_series.begin(), options.depth_series.end());
  return prepared;
}

}  // namespace eikon
