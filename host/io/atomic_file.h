// SPDX-License-Identifier: Apache-2.0
// A file that appears complete or not at all.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace eikon {

/// Names standard output where a file is to be written.
inline constexpr const char* kStandardOutput = "-";

/// The file that a path names behind symbolic links, whether it exists or not; nothing if they lead
/// round in a loop.
[[nodiscard]] std::optional<std::filesystem::path> behind_links(const std::filesystem::path& path);

/// Writes under a temporary name in the folder of the final one; commit() flushes it to the disk
/// and renames it. Without a commit the temporary file is removed. Symbolic links are followed, so
/// that the link stays one.
/// A file named "-" is kept in memory until commit() writes it to standard output. From the first
/// such file on, everything that the process prints goes to stderr, so that standard output holds
/// the file alone. It is refused at once if standard output was closed when the process started.
class AtomicFile {
 public:
  /// Removes what a process that was killed while it wrote the same file has left, if it ran on
  /// this machine since its start and in this PID namespace: whether others live cannot be seen
  /// from here.
  /// throws InputError when the folder does not exist or cannot be written, or the path is a folder
  ///        or a device.
  explicit AtomicFile(const std::filesystem::path& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// At the current position. throws InputError (disk full, file size limit).
  void write(const void* data, std::size_t size_bytes);
  [[nodiscard]] std::uint64_t position() const { return position_; }
  void seek(std::uint64_t position) { position_ = position; }

  /// throws InputError; also when an earlier write failed and whoever called it swallowed the
  ///        exception.
  void commit();

 private:
  std::filesystem::path path_, temporary_;
  int descriptor_ = -1;
  std::uint64_t position_ = 0;
  int error_ = 0;  // errno of the first failure

  void copy_to_standard_output();

  [[noreturn]] void fail() const;
};

/// Writes a whole text file; "-" is standard output. throws InputError
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace eikon
