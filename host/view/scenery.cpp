// SPDX-License-Identifier: Apache-2.0
#include "view/scenery.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "gltf/scene_files.h"
#include "pack/geometry/instanced_meshes.h"

namespace eikon {
namespace {

constexpr std::uint64_t kSceneBytes = std::uint64_t{4} << 30;  // of scenes in memory, roughly
constexpr const char* kNeutral = "neutral";

/// A text that is the same whenever packing the scene for the environment gives the same. The
/// rotation is not packed.
std::string text_of(const Environment& environment, const Digest& file) {
  const glm::vec3& sky = environment.radiance;
  return fmt::format("{} {:016x} {} {},{},{}", environment.map ? environment.map->name : "", file.hash,
                     environment.scale, sky.x, sky.y, sky.z);
}

/// The file of an environment that the command line names; empty: none.
std::string given_map(const std::vector<std::string>& given) {
  constexpr std::string_view kFlag = "--env=";
  std::string map;
  for (const std::string& word : given)
    if (word.starts_with(kFlag)) map = word.substr(kFlag.size());
  return names_environment_file(map) ? map : "";
}

}  // namespace

std::vector<std::string> words_of_other_scene(const std::string& scene, std::vector<std::string> given) {
  const std::set<std::string_view> of_scene = {"--camera",     "--look-at",        "--fov",      "--f-number",
                                               "--panorama",   "--focus-distance", "--variant",  "--frame",
                                               "--scene-time", "--loop",           "--animation"};
  std::erase_if(given, [&](const std::string& word) {
    return !word.starts_with('-') || of_scene.contains(std::string_view(word).substr(0, word.find('=')));
  });
  given.insert(given.begin(), scene);
  return given;
}

SceneryLoader::SceneryLoader(std::vector<std::string> given, ParseRender parse, bool is_dropped)
    : given_(std::move(given)), parse_(std::move(parse)), scenes_(kSceneBytes), is_dropped_(is_dropped) {}

/// Drops all that is in memory, so the next look is loaded from its files.
void SceneryLoader::forget() {
  scenes_.clear();
  source_.reset();
  bounded_.reset();
}

/// words  get what the options were made of
RenderOptions SceneryLoader::options_of(const ViewLook& look, std::vector<std::string>& words) const {
  words = words_of(look, given_);
  if (!has_flag(words, "--spp")) words.push_back(fmt::format("--spp={}", kUsualViewSpp));
  if (source_ && !source_->default_environment.empty() && !has_flag(words, "--env"))
    words.push_back("--env=" + source_->default_environment);
  RenderOptions options = parse_(words);
  read_execution_environment(options.execution);
  EnvironmentOptions& environment = options.scene.environment;
  const std::string wanted = environment.neutral ? kNeutral : environment.map;
  if (source_ && !wanted.empty() && source_->environment_words == wanted) environment.loaded = source_->environment_map;
  return options;
}

/// Watches the files from before they are read, so that no change is missed. A page may choose
/// another environment than the file that the command line names, and go back to that, so it is
/// watched under any.
void SceneryLoader::read_source(const RenderOptions& options) {
  const std::string map = given_map(given_);
  std::vector<std::filesystem::path> files = scene_files(options.scene.scene);
  if (!map.empty()) files.emplace_back(map);
  watch_.watch(files);
  const Digest scene = digest_scene_files(options.scene.scene);
  source_ = Source{.scene = scene, .environment = digest_environment(map)};
}

/// Keeps the map for the next look, and the choice that depends on what the camera sees: the light
/// shall not change while somebody turns the camera.
void SceneryLoader::keep_environment(const EnvironmentOptions& asked, const Prepared& prepared, bool is_given) {
  const Environment& used = prepared.settings.environment;
  if (is_given) {
    source_->environment_words = asked.neutral ? kNeutral : asked.map;
    source_->environment_map = used.map;
  } else if (!prepared.scene->environment) {
    source_->default_environment = used.map ? kNeutral : "none";
  }
}

/// Adds the layers that a page may ask for.
void SceneryLoader::add_layers(const Scene& scene, std::vector<std::string>& aovs, std::vector<std::string>& words) {
  std::vector<std::string> wanted = {"albedo", "normal", "depth"};
  if (scene.light_groups.size() > 1) wanted.emplace_back("light_groups");
  for (const std::string& layer : wanted)
    if (std::ranges::count(aovs, layer) == 0) aovs.push_back(layer);
  std::erase_if(words, [](const std::string& word) { return word.starts_with("--aov="); });
  words.push_back(fmt::format("--aov={}", fmt::join(aovs, ",")));
}

Scenery SceneryLoader::load(const ViewLook& look, const std::function<void(const char*)>& begins) {
  const auto loading = [&] { begins("loading"); };
  std::vector<std::string> words, notes;
  if (is_dropped_)
    notes.emplace_back("this scene is a copy of the dropped file, which goes with the view; the command names it");
  if (watch_.changed()) forget();
  RenderOptions options = options_of(look, words);
  if (!source_) {
    loading();  // files are read to know whether they are the same
    read_source(options);
  }
  const std::shared_ptr<SceneCache::Kept> kept =
      scenes_.load(options.scene.scene, options.scene.choice(), source_->scene, loading);
  layers_ = layers_ || look.needs_layers();
  if (layers_) add_layers(*kept->scene, options.scene.aovs, words);
  Prepared prepared = prepare(options.scene, kept->scene, [&](const std::string& note) { notes.push_back(note); });
  keep_environment(options.scene.environment, prepared, has_flag(words, "--env"));
  const Settings& settings = prepared.settings;
  const Features features = features_of(*kept->scene, settings, options.execution);
  std::shared_ptr<PackedScene> packed =
      scenes_.pack(*kept, settings, options.execution, text_of(settings.environment, source_->environment),
                   [&] { begins("building"); });
  if (bounded_ != kept) bounds_ = world_bounds(*kept->scene);
  bounded_ = kept;
  return {.prepared = std::move(prepared),
          .execution = options.execution,
          .kept = kept,
          .features = features,
          .packed = std::move(packed),
          .words = std::move(words),
          .notes = std::move(notes),
          .bounds = bounds_,
          .has_layers = layers_};
}

}  // namespace eikon
