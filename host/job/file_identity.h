// SPDX-License-Identifier: Apache-2.0
// Files by what they are, rather than by one of their names.
#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace eikon {

/// Where a name leads to, absolute, links followed; as it is written, where that cannot be followed.
[[nodiscard]] std::filesystem::path place_of(const std::filesystem::path& path);

/// Whether two names lead to one file, also by a hard link.
[[nodiscard]] bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// A number for each file, found again by any of its names.
class FileTable {
 public:
  /// The first number of a file stays.
  void put(const std::filesystem::path& file, std::size_t number);
  [[nodiscard]] std::optional<std::size_t> find(const std::filesystem::path& file) const;

 private:
  std::map<std::string, std::size_t> numbers_;  // by place, and by what the file system calls what is there
};

/// Everything that a render of a scene reads: the scene, what it names, and the map `environment` unless that is empty.
[[nodiscard]] std::vector<std::filesystem::path> inputs_of(const std::string& scene, const std::string& environment);

/// throws UsageError when one of the outputs is what a render of the scene reads. Empty names are left out.
void refuse_to_replace_inputs(const std::vector<std::filesystem::path>& outputs, const std::string& scene,
                              const std::string& environment);

}  // namespace eikon
