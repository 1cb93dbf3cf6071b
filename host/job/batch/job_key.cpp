// SPDX-License-Identifier: Apache-2.0
#include "job/batch/job_key.h"

#include <fmt/format.h>

#include <map>

#include "core/error.h"
#include "gltf/scene_files.h"
#include "io/source_file.h"

namespace eikon {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

}  // namespace

Digest digest_file(const std::filesystem::path& path) {
  Digest digest;
  try {
    digest.add(read_regular_file(path, usable_memory_bytes()).span());
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", path.string(), error.what()));
  }
  return digest;
}

Digest digest_scene_files(const std::filesystem::path& scene) {
  Digest digest;
  std::map<std::string, std::filesystem::path> named;
  try {
    const Bytes file = read_regular_file(scene, usable_memory_bytes());
    digest.add(file.span());
    named = named_files(scene.parent_path(), file.span(), scene.extension() == ".glb");
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", scene.string(), error.what()));
  }
  for (const auto& [uri, file] : named) {
    digest.add(bytes_of(uri));
    std::error_code unreadable;
    if (!std::filesystem::is_regular_file(file, unreadable)) continue;
    const Digest read = digest_file(file);
    digest.add(std::as_bytes(std::span(&read.hash, 1)));
    digest.bytes += read.bytes;
  }
  return digest;
}

Digest digest_environment(const std::string& map) {
  std::error_code none;
  return !map.empty() && std::filesystem::is_regular_file(map, none) ? digest_file(map) : Digest{};
}

std::string job_key(const Digest& scene, const Digest& environment, const std::string& settings) {
  const std::string text =
      fmt::format("{}\n{:016x}\n{:016x}\n{}", EIKON_VERSION, scene.hash, environment.hash, settings);
  return fmt::format("{:016x}", xxhash64(bytes_of(text), 0));
}

}  // namespace eikon
