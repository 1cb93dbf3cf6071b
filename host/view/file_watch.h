// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace eikon {

/// Sees whether files change, by their sizes and times of writing.
class FileWatch {
 public:
  /// Watches these files from now on, and no others. They need not exist.
  void watch(const std::vector<std::filesystem::path>& files);
  /// True if one of them has changed since watch(), appeared or gone.
  [[nodiscard]] bool changed() const;

 private:
  using State = std::optional<std::pair<std::filesystem::file_time_type, std::uintmax_t>>;  // nothing: no such file
  [[nodiscard]] static State state_of(const std::filesystem::path& file);
  std::map<std::filesystem::path, State> files_;
};

}  // namespace eikon
