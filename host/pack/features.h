// SPDX-License-Identifier: Apache-2.0
// The features of kernels that a scene and its settings need. All others are compiled out.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "film/mattes.h"
#include "pack/settings.h"

namespace eikon {

/// All features of kernels/shared/features.def, in its order.
enum class Feature : std::uint8_t {
#define EK_FEATURE(name) name,
#include "shared/features.def"
};

/// A decision about a feature, and the reason for it in words.
struct Need {
  bool on = false;
  std::string reason;  // who needs it, or why it is out
};

/// A feature, and whether the kernels are compiled with it.
struct FeatureEntry {
  std::string kind;  // "lobe", "light", "shape", "option", "layer"
  std::string name;
  int channels = 0;  // film channels of a layer
  bool on = false;
  std::string reason;  // who needs it, or why it is out
};

/// The features of features.def for which the kernels of a scene are compiled. Each is on or off,
/// and states the reason.
class Features {
 public:
  Features(const Scene& scene, const Settings& settings);

  /// One entry per feature, in the order of features.def.
  [[nodiscard]] const std::vector<FeatureEntry>& entries() const { return entries_; }
  [[nodiscard]] bool has(Feature feature) const { return entries_[std::size_t(feature)].on; }
  /// True if rays that leave the scene meet light.
  [[nodiscard]] bool has_environment() const { return has(Feature::environment) || has(Feature::environment_map); }
  /// Turns feature `instance` on or off. It depends on more than scene and settings (features_of),
  /// and is off at first.
  void set_two_level(bool on, const std::string& reason);
  /// Turns the features of path guiding on or off, which change no other one. Whether they are
  /// needed shows only when the scene is packed: path_log for the pilot's program, guiding for the
  /// render's.
  void set_guiding(bool guiding, bool path_log);
  /// Turns photons off, for the program of a pilot.
  void leave_out_merging() { entries_[std::size_t(Feature::merging)].on = false; }
  /// Turns light paths off, because a trial found that they do not pay.
  void leave_out_light_paths();
  /// The defines of a program: EK_HAS_<name> as 0 or 1 for every feature, and the numbers that some
  /// features come with.
  [[nodiscard]] std::map<std::string, std::string> defines() const;
  /// Kernel code of the scene's formulas, for the end of a program; empty if it has none.
  [[nodiscard]] const std::string& formula_code() const { return formula_code_; }
  /// Channels of the film in order: "R", "G", "B", then those of the layers.
  [[nodiscard]] std::vector<std::string> film_channels() const;
  /// Layers that count what samples meet, behind the film's channels; none of them unless asked
  /// for.
  [[nodiscard]] const Mattes& mattes() const { return *mattes_; }
  /// Shadow rays of each vertex where lights are sampled.
  [[nodiscard]] std::uint32_t light_samples() const { return light_samples_; }
  /// The names of the features that are on: "diffuse area next_event ...".
  [[nodiscard]] std::string summary() const;

 private:
  std::vector<FeatureEntry> entries_;
  std::string formula_code_;
  std::size_t formula_count_ = 0;
  std::vector<std::uint32_t> scatter_bounds_;  // layers.h
  std::vector<std::string> light_groups_;
  std::uint32_t environment_light_group_ = 0;
  std::shared_ptr<const Mattes> mattes_;  // shared by copies, because it is large
  std::uint32_t light_samples_ = 1;
  bool has_glossy_targets_ = false;  // of light paths
};

/// The layout of the fields of kernels/shared/path_state.def with these features: the first word of
/// each field by its name, and the number of words.
struct PathStateLayout {
  std::map<std::string, std::uint32_t> field;
  std::uint32_t words = 0;
};
[[nodiscard]] PathStateLayout path_state_layout(const Features& features, bool chunked);

}  // namespace eikon
