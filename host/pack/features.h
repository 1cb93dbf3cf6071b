// SPDX-License-Identifier: Apache-2.0
// What a scene and its settings need of the kernels. Everything else is compiled out.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "film/mattes.h"
#include "pack/settings.h"

namespace eikon {

struct Feature {
  std::string kind;  // "lobe", "light", "shape", "option", "layer"
  std::string name;
  int channels = 0;  // film channels of a layer
  bool on = false;
  std::string who;  // who needs it, or why it is out
};

/// The lobe of features.def that scatters as this material does.
[[nodiscard]] std::string lobe_of(const Material& material);

/// Whether its surfaces are the boundary of something that light goes into.
[[nodiscard]] bool is_solid(const Material& material);

class Features {
 public:
  Features(const Scene& scene, const Settings& settings);

  [[nodiscard]] const std::vector<Feature>& ledger() const { return ledger_; }
  [[nodiscard]] bool has(const std::string& name) const;
  /// Feature `instance`, which hangs on more than scene and settings (features_of); off at first.
  void set_two_level(bool on, const std::string& why);
  /// EK_HAS_<name> = 0 | 1 for every feature there is; and the numbers that some of them come with.
  [[nodiscard]] std::map<std::string, std::string> defines() const;
  /// Kernel code of the scene's formulas, for the end of a program; empty if it has none.
  [[nodiscard]] const std::string& formula_code() const { return formula_code_; }
  /// Channels of the film in order: "R", "G", "B", then those of the layers.
  [[nodiscard]] std::vector<std::string> film_channels() const;
  /// Layers that count what samples meet, behind the film's channels; none of them unless asked for.
  [[nodiscard]] const Mattes& mattes() const { return *mattes_; }
  /// Shadow rays of each vertex where lights are sampled.
  [[nodiscard]] std::uint32_t light_samples() const { return light_samples_; }
  /// "diffuse area next_event ...": those that are on.
  [[nodiscard]] std::string summary() const;

 private:
  std::vector<Feature> ledger_;
  std::string formula_code_;
  std::size_t formula_count_ = 0;
  std::vector<std::uint32_t> scatter_bounds_;  // layers.h
  std::vector<std::string> light_groups_;
  std::uint32_t environment_light_group_ = 0;
  std::shared_ptr<const Mattes> mattes_;  // large, and of no copy's own
  std::uint32_t light_samples_ = 1;
};

/// Where the fields of kernels/shared/path_state.def lie with these features: word index by name, and how many there are.
struct PathStateLayout {
  std::map<std::string, std::uint32_t> field;
  std::uint32_t words = 0;
};
[[nodiscard]] PathStateLayout path_state_layout(const Features& features, bool chunked);

}  // namespace eikon
