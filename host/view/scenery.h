// SPDX-License-Identifier: Apache-2.0
// A scenery is all that a render of a look needs; its loader makes it of the look.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "job/batch/batch_job.h"
#include "job/batch/job_key.h"
#include "job/scene_cache.h"
#include "pack/features.h"
#include "render/film_store.h"
#include "render/pilot/pilot.h"
#include "view/file_watch.h"
#include "view/view_look.h"

namespace eikon {

/// Samples per pixel of a view, unless the user says otherwise.
inline constexpr std::uint64_t kUsualViewSpp = 1024;

/// All that rendering a look needs, and the samples that were rendered so far.
struct Scenery {
  Prepared prepared;
  Execution execution;
  std::shared_ptr<SceneCache::Kept> kept;
  Features features;  // of the scene with the settings
  std::shared_ptr<PackedScene> packed;
  std::vector<std::string> words;   // that follow `eikon render` for the same picture, without names of output files
  std::vector<std::string> notes;   // for the user
  Bounds bounds;                    // of the scene
  bool has_layers = false;          // those of view_layers()
  std::optional<Pilot> pilot{};     // of the whole picture, once it is known
  std::optional<FilmState> film{};  // of the samples so far; none: of none
};

/// The words of a view for another scene than before: without what was meant for that one.
[[nodiscard]] std::vector<std::string> words_of_other_scene(const std::string& scene, std::vector<std::string> given);

/// Makes sceneries, and keeps what the next look is likely to need again: the scene, its trees, and
/// the environment. Only one thread may use it.
class SceneryLoader {
 public:
  /// given  the words behind `eikon view` that `eikon render` knows, too
  /// parse  reads such words
  /// is_dropped  the scene came from a page
  SceneryLoader(std::vector<std::string> given, ParseRender parse, bool is_dropped);
  /// Loads the scene as a look asks for it, or finds it in memory.
  /// begins  gets "loading" and "building" before they are done; for most looks there is nothing to
  ///         be done
  /// throws UsageError, InputError
  [[nodiscard]] Scenery load(const ViewLook& look, const std::function<void(const char*)>& begins);
  /// True if a file of the scene that was loaded last, or that could not be loaded, is another one
  /// now.
  [[nodiscard]] bool is_outdated() const { return watch_.changed(); }

 private:
  /// Holds what is the same for every look at the same files.
  struct Source {
    Digest scene, environment;
    std::string environment_words{};  // of --env, for which `environment_map` stands
    std::shared_ptr<const EnvironmentMap> environment_map{};
    std::string default_environment{};  // what eikon chose where neither the user nor the file did: a value of --env
  };

  [[nodiscard]] RenderOptions options_of(const ViewLook& look, std::vector<std::string>& words) const;
  void forget();
  void read_source(const RenderOptions& options);
  void keep_environment(const EnvironmentOptions& asked, const Prepared& prepared, bool is_given);
  static void add_layers(const Scene& scene, std::vector<std::string>& aovs, std::vector<std::string>& words);

  std::vector<std::string> given_;
  ParseRender parse_;
  SceneCache scenes_;
  FileWatch watch_;
  std::optional<Source> source_{};
  std::shared_ptr<const SceneCache::Kept> bounded_{};  // the scene that has these bounds
  Bounds bounds_{};
  bool is_dropped_;
  bool layers_ = false;  // some look has asked for a layer: programs and films have all of them from then on
};

}  // namespace eikon
