// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace eikon {

struct Scene;

/// Collects what a reader leaves out of a scene or changes in it. Each unsupported feature is
/// listed once, with its first user and the number of the others.
class Notes {
 public:
  void unsupported(const std::string& feature, const std::string& user);
  /// The same warning is given once.
  void warn(const std::string& warning);
  /// Warns of a broken rule of the format where the meaning is beyond doubt, or of a number that
  /// was brought into its range. Both are errors under --strict.
  void mended(const std::string& warning);
  /// The number of different warnings so far.
  [[nodiscard]] std::size_t warning_count() const { return warnings_.size(); }
  /// Moves everything into `scene`.
  void finish(Scene& scene);

 private:
  struct Feature {
    std::string name, first_user;
    std::set<std::string> users;  // a user counts once
  };
  std::vector<Feature> features_;  // in the order in which they were met
  std::map<std::string, std::size_t> feature_index_;
  std::vector<std::string> warnings_, strict_errors_;
  std::set<std::string> said_;
};

}  // namespace eikon
