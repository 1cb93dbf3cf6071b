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
  fs::path real = fs::weakly_canonical(whole, error);
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

std::vector<fs::path> inputs_of(const std::string& scene, const std::string& environment) {
  std::vector<fs::path> files = scene_files(scene);
  if (!environment.empty()) files.emplace_back(environment);
  return files;
}

void require_writable(const std::vector<fs::path>& outputs, const fs::path& input) {
  std::vector<fs::path> seen;
  for (const fs::path& path : outputs) {
    if (path.empty()) continue;
    const AtomicFile probe(path);  // made under its temporary name, and removed again
    const fs::path real = place_of(path);
    if (is_same_file(path, input))
      throw UsageError(fmt::format("cannot write {}: it is the input; choose another name", path.string()));
    if (std::find(seen.begin(), seen.end(), real) != seen.end())
      throw UsageError(
          fmt::format("cannot write {}: two outputs have that name; choose another for one of them", path.string()));
    seen.push_back(real);
  }
}

void refuse_to_replace_inputs(const std::vector<fs::path>& outputs, const std::string& scene,
                              const std::string& environment, const std::vector<std::string>& parts) {
  std::error_code absent;
  std::vector<fs::path> there;  // others replace nothing
  for (const fs::path& output : outputs)
    if (!output.empty() && fs::exists(output, absent)) there.push_back(output);
  if (there.empty()) return;
  FileTable inputs;
  for (const fs::path& input : inputs_of(scene, environment)) inputs.put(input, 0);
  for (const std::string& part : parts) inputs.put(part, 0);
  for (const fs::path& output : there)
    if (inputs.find(output))
      throw UsageError(
          fmt::format("cannot write {}: it is an input of the render; choose another name", output.string()));
}

}  // namespace eikon
