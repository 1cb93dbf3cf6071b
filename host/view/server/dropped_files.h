// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "view/server/private_folder.h"

namespace eikon {

/// The longest scene file that a page may send, in bytes.
inline constexpr std::uint64_t kMaxDropped = std::uint64_t{256} << 20;

/// Scene files that a page has sent, in a folder of their own that is removed at the end. The last
/// one is kept, and those before it until somebody says that they are not read any more.
class DroppedFiles {
 public:
  /// A file to be written.
  struct Incoming {
    std::filesystem::path path;
    std::ofstream file;
  };
  /// Begins a file.
  /// name  as the page gives it
  /// throws UsageError unless the name is that of a .gltf or .glb, of letters, digits, blanks, -, _
  /// and .; InputError if there is no room for the file
  [[nodiscard]] Incoming begin(const std::string& name);
  /// Closes a file that has arrived completely. throws InputError if it could not be written
  static void finish(Incoming& incoming);
  /// Keeps this file instead of the one that was kept before.
  void keep(const Incoming& incoming);
  /// Removes the files that were kept before the last one.
  void remove_old();
  /// Removes a file that is not needed.
  static void drop(Incoming& incoming);

 private:
  std::mutex mutex_;  // guards what follows
  std::unique_ptr<PrivateFolder> folder_;  // null: no file has come yet
  std::filesystem::path kept_;
  std::vector<std::filesystem::path> old_;  // that were kept before, as long as they are there
  std::uint64_t count_ = 0;
};

}  // namespace eikon
