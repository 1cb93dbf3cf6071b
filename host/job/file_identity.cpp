// SPDX-License-Identifier: Apache-2.0
#include "job/file_identity.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>

#include "core/error.h"
#include "gltf/scene_files.h"
#include "io/atomic_file.h"

namespace eikon {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> names_of(const fs::path& file) {
  std::vector<std::string> names = {place_of(file).string()};
  struct stat found {};
  if (stat(file.c_str(), &found) == 0) names.push_back(fmt::format("inode {} {}", found.st_dev, found.st_ino));
  return names;
}

}  // namespace

fs::path place_of(const fs::path& path) {
  std::error_code error;  // such as a loop of links: opening the file will report it
  // weakly_canonical alone leaves a relative path relative if nothing of it exists.
  const fs::path whole = fs::absolute(path, error);
  // Nor does it follow a link to what does not exist yet.
  fs::path real = fs::weakly_canonical(behind_links(whole).value_or(whole), error);
  return error ? whole.lexically_normal() : real;
}

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code absent;
  return place_of(a) == place_of(b) || fs::equivalent(a, b, absent);
}

void FileTable::put(const fs::path& file, std::size_t number) {
  for (const std::string& name : names_of(file)) numbers_.emplace(name, number);
}

std::optional<std::size_t> FileTable::find(const fs::path& file) const {
  for (const std::string& name : names_of(file))
    if (const auto found = numbers_.find(name); found != numbers_.end()) return found->second;
  return std::nullopt;
}

void require_writable(const std::vector<fs::path>& outputs, const Inputs& inputs) {
  std::vector<fs::path> seen, there;  // outputs that are not there replace nothing
  std::error_code absent;
  for (const fs::path& path : outputs) {
    if (path.empty()) continue;
    const AtomicFile probe(path);  // made under its temporary name, and removed again
    const fs::path real = place_of(path);
    if (std::find(seen.begin(), seen.end(), real) != seen.end())
      throw UsageError(
          fmt::format("cannot write {}: two outputs have that name; choose another for one of them", path.string()));
    seen.push_back(real);
    if (path != kStandardOutput && fs::exists(path, absent)) there.push_back(path);
  }
  if (there.empty()) return;
  FileTable read;
  if (!inputs.scene.empty())
    for (const fs::path& input : scene_files(inputs.scene)) read.put(input, 0);
  for (const std::string& input : inputs.files)
    if (!input.empty()) read.put(input, 0);
  for (const fs::path& output : there)
    if (read.find(output))
      throw UsageError(fmt::format("cannot write {}: it is an input; choose another name", output.string()));
}

}  // namespace eikon
