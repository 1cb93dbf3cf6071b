// SPDX-License-Identifier: Apache-2.0
#include "view/file_watch.h"

#include <algorithm>

namespace eikon {

FileWatch::State FileWatch::state_of(const std::filesystem::path& file) {
  std::error_code error;
  const auto time = std::filesystem::last_write_time(file, error);
  if (error) return std::nullopt;
  const auto size = std::filesystem::file_size(file, error);
  return error ? State() : State({time, size});
}

void FileWatch::watch(const std::vector<std::filesystem::path>& files) {
  files_.clear();
  for (const std::filesystem::path& file : files) files_[file] = state_of(file);
}

bool FileWatch::changed() const {
  return std::ranges::any_of(files_, [](const auto& entry) { return state_of(entry.first) != entry.second; });
}

}  // namespace eikon
