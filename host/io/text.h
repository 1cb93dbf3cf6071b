// SPDX-License-Identifier: Apache-2.0
// How the loader speaks of the things of a file. Names come from the file, so they may hold anything.
#pragma once
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace eikon {

/// `text` in single quotes, fit for one line: control characters and quotes escaped, cut after 80 bytes.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// "node 'lamp'", or "node 3" where it has no name.
[[nodiscard]] std::string label(std::string_view kind, std::uint64_t index, std::string_view name);

/// The same line without control characters, for messages of libraries.
[[nodiscard]] std::string one_line(std::string_view text);

/// Collects what a load leaves out or changes, each feature once, with its first user and the number of the others.
class Notes {
 public:
  void unsupported(const std::string& feature, const std::string& user);
  void warn(std::string warning);
  /// Warns of a number that was brought into its range; an error under --strict.
  void clamped(const std::string& warning);
  /// Moves everything into `scene`.
  void finish(Scene& scene);

 private:
  struct Feature {
    std::string name, first_user;
    std::set<std::string> users;  // a user counts once
  };
  std::vector<Feature> features_;  // in the order in which they were met
  std::map<std::string, std::size_t> feature_index_;
  std::vector<std::string> warnings_, clamped_;
};

}  // namespace eikon
