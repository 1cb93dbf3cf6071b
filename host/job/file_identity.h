// SPDX-License-Identifier: Apache-2.0
// Recognises a file by any of its names, so that no output replaces an input or another output.
#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace eikon {

/// The absolute path that a name leads to, with links followed; the name as an absolute path if
/// they cannot be followed.
[[nodiscard]] std::filesystem::path place_of(const std::filesystem::path& path);

/// True if two names lead to the same file, be it by a hard link.
[[nodiscard]] bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// Gives files numbers, which are found again by any name of the file.
class FileTable {
 public:
  /// Keeps the number if the file has one already.
  void put(const std::filesystem::path& file, std::size_t number);
  [[nodiscard]] std::optional<std::size_t> find(const std::filesystem::path& file) const;

 private:
  std::map<std::string, std::size_t> numbers_;  // by path, and by device and inode
};

/// The files that a command reads.
struct Inputs {
  std::string scene{};               // with the files that it names; empty: none
  std::vector<std::string> files{};  // all others; empty names are left out
};

/// Checks before the work that its outputs can be written, and that they replace no input. Empty
/// names are left out.
/// throws InputError for an output that cannot be made or replaced; UsageError if two outputs are
/// the same file, or one is an input
void require_writable(const std::vector<std::filesystem::path>& outputs, const Inputs& inputs);

}  // namespace eikon
