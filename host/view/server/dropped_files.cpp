// SPDX-License-Identifier: Apache-2.0
#include "view/server/dropped_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <system_error>

#include "core/error.h"

namespace eikon {
namespace {

void check_name(const std::string& name) {
  constexpr std::size_t kLongest = 120;
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view(" -_.").find(c) != std::string_view::npos;
  };
  const bool ends_well = name.ends_with(".gltf") || name.ends_with(".glb");
  if (!ends_well || name.size() > kLongest || name.front() == '.' || name.front() == '-' ||
      !std::ranges::all_of(name, is_plain))
    throw UsageError(
        "view: a dropped file is a .gltf or .glb whose name has letters, digits, blanks, -, _ and .; name others on "
        "the "
        "command line");
}

}  // namespace

DroppedFiles::Incoming DroppedFiles::begin(const std::string& name) {
  check_name(name);
  const std::lock_guard lock(mutex_);
  if (!folder_) folder_ = std::make_unique<PrivateFolder>();
  const std::filesystem::path own = folder_->path() / std::to_string(++count_);
  std::error_code ignored;  // the file then cannot be written
  std::filesystem::create_directory(own, ignored);
  Incoming incoming{.path = own / name, .file = std::ofstream(own / name, std::ios::binary)};
  if (!incoming.file) throw InputError(fmt::format("{}: cannot be written", incoming.path.string()));
  return incoming;
}

void DroppedFiles::finish(Incoming& incoming) {
  incoming.file.close();
  if (incoming.file) return;
  drop(incoming);
  throw InputError(fmt::format("{}: cannot be written; the disk may be full", incoming.path.string()));
}

void DroppedFiles::keep(const Incoming& incoming) {
  const std::lock_guard lock(mutex_);
  if (!kept_.empty()) old_.push_back(kept_);
  kept_ = incoming.path;
}

void DroppedFiles::remove_old() {
  const std::lock_guard lock(mutex_);
  std::error_code ignored;
  for (const std::filesystem::path& file : old_) std::filesystem::remove_all(file.parent_path(), ignored);
  old_.clear();
}

void DroppedFiles::drop(Incoming& incoming) {
  incoming.file.close();
  std::error_code ignored;
  std::filesystem::remove_all(incoming.path.parent_path(), ignored);
}

}  // namespace eikon
