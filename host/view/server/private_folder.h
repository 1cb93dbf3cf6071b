// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

namespace eikon {

/// A temporary folder that no other user can enter, and that is removed at the end.
class PrivateFolder {
 public:
  /// throws InputError if it cannot be made
  PrivateFolder();
  ~PrivateFolder();
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace eikon
