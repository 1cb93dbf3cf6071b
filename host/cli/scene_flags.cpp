// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "cli/flags.h"
#include "film/layers.h"
#include "pack/settings.h"
#include "render/pilot/pilot.h"

namespace eikon {
namespace {

constexpr double kMinFNumber = 1e-3, kMaxFNumber = 1e6;
constexpr double kMaxFocusDistance = 0x1p40;
constexpr double kMaxSeconds = 1e9;

ImageSize parse_size(const std::string& text) {
  const std::vector<std::string> parts = split(text, 'x');
  if (parts.size() != 2) throw UsageError(fmt::format("--size {}: takes WIDTHxHEIGHT, e.g. 1280x720", text));
  const ImageSize size = {std::uint32_t(parse_unsigned("--size", parts[0], kMaxImageSide)),
                          std::uint32_t(parse_unsigned("--size", parts[1], kMaxImageSide))};
  if (size.width == 0 || size.height == 0)
    throw UsageError(fmt::format("--size {}: an image has at least one pixel", text));
  return size;
}

Crop parse_crop(const std::string& text) {
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() != 4)
    throw UsageError(fmt::format("--crop {}: takes X0,Y0,X1,Y1 in pixels, the last two exclusive", text));
  const auto at = [&](std::size_t i) { return std::uint32_t(parse_unsigned("--crop", parts[i], kMaxImageSide)); };
  return {at(0), at(1), at(2), at(3)};
}

SampleRange parse_samples(const std::string& text) {
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() != 2) throw UsageError(fmt::format("--samples {}: takes A:B, the half-open range of samples", text));
  const SampleRange range = {parse_unsigned("--samples", parts[0], kMaxSamples),
                             parse_unsigned("--samples", parts[1], kMaxSamples)};
  if (range.begin >= range.end) throw UsageError(fmt::format("--samples {}: the range is empty", text));
  return range;
}

LookAt parse_look_at(const std::string& text) {
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() != 2 && parts.size() != 3)
    throw UsageError(fmt::format("--look-at {}: takes EYE:TARGET[:UP], each x,y,z", text));
  LookAt view{parse_vector("--look-at", parts[0]), parse_vector("--look-at", parts[1])};
  if (parts.size() == 3) view.up = parse_vector("--look-at", parts[2]);
  return view;
}

double parse_f_number(const std::string& text) {
  if (text == "off") return 0;
  const double f_number = parse_numbers("--f-number", text, 1)[0];
  if (f_number >= kMinFNumber && f_number <= kMaxFNumber) return f_number;
  throw UsageError(
      fmt::format("--f-number {}: lies between {:g} and {:g}; off is a pinhole", text, kMinFNumber, kMaxFNumber));
}

double parse_focus_distance(const std::string& text) {
  const double distance_m = parse_numbers("--focus-distance", text, 1)[0];
  if (distance_m > 0 && distance_m <= kMaxFocusDistance) return distance_m;
  throw UsageError(fmt::format("--focus-distance {}: lies between 0 and {:g} metres", text, kMaxFocusDistance));
}

void parse_guiding(const std::string& text, SceneOptions& options) {
  options.pilot_paths.reset();
  options.guiding = Guiding::on;
  for (const Guiding guiding : {Guiding::automatic, Guiding::on, Guiding::off})
    if (text == name_of(guiding)) {
      options.guiding = guiding;
      return;
    }
  if (text.empty() || !std::isdigit(static_cast<unsigned char>(text.front())))
    refuse_choice("--guiding", text, {"auto", "on", "off", "a number of paths"});
  options.pilot_paths = parse_unsigned("--guiding", text, kMaxPilotPaths, 64);
}

void parse_light_paths(const std::string& text, SceneOptions& options) {
  options.light_paths.reset();
  options.tries_light_paths = text != "usual";
  if (text == "auto" || text == "usual") return;
  if (text == "off") {
    options.light_paths = 0;
    return;
  }
  if (text.find_first_of("0123456789.") != 0)
    refuse_choice("--light-paths", text, {"auto", "usual", "off", "a number"});
  options.light_paths = parse_number<double>("--light-paths", text, 0, kMaxLightPathRatio);
}

void parse_environment(const std::string& text, EnvironmentOptions& environment) {
  if (names_environment_file(text)) {
    environment.map = text;
    return;
  }
  if (text == "none") {
    environment.radiance = glm::vec3(0.0F);
    return;
  }
  if (text == "neutral") {
    environment.neutral = true;
    return;
  }
  const glm::dvec3 radiance = parse_vector("--env", text);
  for (int c = 0; c < 3; ++c)
    if (radiance[c] < 0 || radiance[c] > kMaxRadiance)
      throw UsageError(fmt::format("--env {}: radiance lies between 0 and {:g}", text, kMaxRadiance));
  environment.radiance = glm::vec3(radiance);
}

void parse_aovs(const std::string& text, std::vector<std::string>& aovs) {
  for (const std::string& layer : split(text, ',')) {
    if (!is_layer(layer))
      throw UsageError(fmt::format("--aov {}: no layer '{}'; there is {}", text, layer, layer_names()));
    if (std::ranges::find(aovs, layer) == aovs.end()) aovs.push_back(layer);
  }
}

void add_camera_flags(CommandFlags& flags, SceneOptions& options) {
  flags.text({"--camera", "NAME|INDEX", "camera of the scene, by its name or its index from 0 [the first]"},
             options.camera);
  flags.parsed({"--look-at", "EYE:TARGET[:UP]", "a perspective camera of your own; each point is x,y,z in metres"},
               [&](const std::string& text) { options.look_at = parse_look_at(text); });
  flags.parsed({"--fov", "DEGREES", "vertical field of view of a perspective camera"},
               [&](const std::string& text) { options.fov_deg = parse_real("--fov", text, 0.01, 179); });
  flags.toggle("--panorama", "every direction around the camera, as an equirectangular image", options.panorama);
  flags.parsed({"--f-number", "N|off", "aperture of the lens, as of a camera for 35 mm film; off: a pinhole"},
               [&](const std::string& text) { options.lens.f_number = parse_f_number(text); });
  flags.parsed({"--focus-distance", "METRES", "distance from the lens at which the image is sharp"},
               [&](const std::string& text) { options.lens.focus_distance_m = parse_focus_distance(text); });
  flags.choice<Culling>(
      {"--cull", "NAME",
       "camera: the camera does not see the backs of surfaces that are not double-sided; none [camera]"},
      options.culling, {{"camera", Culling::camera}, {"none", Culling::none}});
  flags.parsed(
      {"--light-paths", "NAME|RATIO",
       "paths from lights by way of glass and mirrors to what they light up: auto (as many as a trial finds to pay), "
       "usual (no trial), off, or their number for each path from the camera, up to 4 [auto]"},
      [&](const std::string& text) { parse_light_paths(text, options); });
  flags.suggest("--light-paths", {"auto", "usual", "off"});
  flags.choice<bool>(
      {"--caustics", "NAME",
       "unbiased; merge: caustics that are seen through glass or in a mirror are lit by photons, with a bias "
       "that falls as samples are added [unbiased]"},
      options.merges_caustics, {{"unbiased", false}, {"merge", true}});
  flags.parsed(
      {"--guiding", "NAME|PATHS",
       "auto; on; off: paths follow what a small pilot render learned about where light comes from, where that "
       "pays; a number of paths for the pilot turns it on [auto]"},
      [&](const std::string& text) { parse_guiding(text, options); });
  flags.suggest("--guiding", {"auto", "on", "off"});
}

void add_environment_flags(CommandFlags& flags, EnvironmentOptions& environment) {
  flags.parsed({"--env", "NAME|FILE|R,G,B",
                "environment: none, neutral (a studio), an equirectangular .exr or .hdr, or a constant radiance [the "
                "scene's; neutral if it is dark without]"},
               [&](const std::string& text) { parse_environment(text, environment); });
  flags.suggest("--env", {"none", "neutral"});
  flags.number({"--env-scale", "FACTOR", "multiply the environment's radiance [1]"}, environment.scale, 0, 1e9);
  flags.number({"--env-rotate", "DEGREES", "turn the environment about +Y, from -Z towards -X [0]"},
               environment.rotate_deg, -36000, 36000);
}

void add_animation_flags(CommandFlags& flags, AnimationOptions& options) {
  flags.text({"--animation", "NAME|INDEX", "an animation, all that do not contradict each other, or none [all]"},
             options.name);
  flags.number({"--scene-time", "SECONDS", "time on the clock of the animations [0]"}, options.time_s, -kMaxSeconds,
               kMaxSeconds);
  flags.parsed({"--frame", "N", "time as the number of a frame, from 0"},
               [&](const std::string& text) { options.frame = parse_unsigned("--frame", text, kMaxFrame); });
  flags.number({"--fps", "N", "frames per second [24]"}, options.fps, 1e-3, 1e6);
  flags.toggle("--loop", "begin an animation again after its end", options.loop);
  flags.exclude("--frame", "--scene-time");
}

}  // namespace

void add_scene_flags(CommandFlags& flags, SceneOptions& options) {
  flags.group("Scene");
  flags.text({"SCENE", "", "glTF 2.0 file, .gltf or .glb"}, options.scene);
  flags.text({"--variant", "NAME", "material variant (KHR_materials_variants); `eikon info` lists them"},
             options.variant);
  add_animation_flags(flags, options.animation);
  flags.toggle("--strict", "treat unsupported features and rejected samples as errors", options.strict);
}

void add_image_flags(CommandFlags& flags, SceneOptions& options, const std::string& size_default) {
  add_camera_flags(flags, options);
  flags.group("Image");
  flags.parsed({"--size", "WxH", "width and height in pixels [" + size_default + "]"},
               [&](const std::string& text) { options.size = parse_size(text); });
  flags.parsed({"--crop", "X0,Y0,X1,Y1", "render this window only, with the bits of the full image"},
               [&](const std::string& text) { options.crop = parse_crop(text); });
  flags.parsed({"--samples", "A:B", "render samples A to B-1 of each pixel only, to be merged later"},
               [&](const std::string& text) { options.samples = parse_samples(text); });
  flags.parsed({"--filter", "NAME[:WIDTH]", "pixel filter, full width in pixels: " + filter_names() + " [box]"},
               [&](const std::string& text) { options.filter = parse_filter(text); });
  flags.suggest("--filter", filter_words());
  flags.toggle("--transparent", "leave the environment out of the picture: adds channel A, R, G, B are premultiplied",
               options.transparent);
  flags.parsed({"--aov", "LIST", "additional layers, separated by commas: " + layer_names()},
               [&](const std::string& text) { parse_aovs(text, options.aovs); });
  std::vector<std::string> names;
  for (const LayerInfo& layer : layers()) names.emplace_back(layer.name);
  flags.suggest("--aov", names);
}

void add_light_flags(CommandFlags& flags, SceneOptions& options, const std::string& spp_about) {
  flags.group("Light");
  flags.parsed({"--spp", "N", spp_about},
               [&](const std::string& text) { options.spp = parse_unsigned("--spp", text, kMaxSamples, 1); });
  flags.number({"--seed", "N", "seed of the random numbers; images of different seeds are independent [0]"},
               options.seed, 0, 4294967295.0);
  add_environment_flags(flags, options.environment);
  flags.choice<IntegratorChoice>(
      {"--integrator", "NAME",
       "path; direct: no indirect light; whitted: only mirrors and glass scatter; raycast: one shadow ray per light "
       "[path]"},
      options.integrator,
      {{"path", IntegratorChoice::path},
       {"direct", IntegratorChoice::direct},
       {"whitted", IntegratorChoice::whitted},
       {"raycast", IntegratorChoice::raycast}});
  flags.number(
      {"--max-depth", "N", "longest path in edges from the camera: 1 emission, 2 direct light; 0: no limit [0]"},
      options.max_depth, 0, 4294967295.0);
  flags.number({"--roulette", "P", "constant survival probability for Russian roulette [by throughput]"},
               options.roulette_survival, 0.01, 1);
  flags.choice<LightSampling>(
      {"--light-sampling", "NAME",
       "strategy for direct light: mis, light, bsdf, hemisphere; same mean, different variance [mis]"},
      options.light_sampling,
      {{"mis", LightSampling::mis},
       {"light", LightSampling::light},
       {"bsdf", LightSampling::bsdf},
       {"cosine", LightSampling::bsdf},
       {"hemisphere", LightSampling::hemisphere}});
  flags.number({"--light-samples", "N", "shadow rays per sample, with --integrator direct [1]"}, options.light_samples,
               1, kMaxLightSamples);
  flags.choice<bool>({"--energy-compensation", "on|off", "add the light that microfacets scatter more than once [off]"},
                     options.energy_compensation, {{"on", true}, {"off", false}});
}

void add_all_scene_flags(CommandFlags& flags, SceneOptions& options) {
  add_scene_flags(flags, options);
  add_image_flags(flags, options, "720 rows at the camera's aspect");
  add_light_flags(flags, options, "samples per pixel [64, or at most 2^24 where an error or a time ends it]");
}

}  // namespace eikon
