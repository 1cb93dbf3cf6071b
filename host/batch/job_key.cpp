// SPDX-License-Identifier: Apache-2.0
#include "batch/job_key.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "scene/digest.h"
#include "scene/json_text.h"
#include "scene/source_file.h"

namespace eikon {
namespace {

/// Every text under the name "uri", wherever it stands: extensions have some too.
void collect_uris(const Json& value, std::set<std::string>& uris) {
  for (const auto& [name, member] : value.items()) {
    if (name == "uri" && member.is_string())
      uris.insert(member.get<std::string>());
    else if (member.is_structured())
      collect_uris(member, uris);
  }
}

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

}  // namespace

InputsDigest digest_file(const std::filesystem::path& path) {
  Digest digest;
  try {
    digest.add(read_regular_file(path, physical_memory_bytes()).span());
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", path.string(), error.what()));
  }
  return {digest.hash, digest.bytes};
}

InputsDigest digest_scene_files(const std::filesystem::path& scene) {
  Digest digest;
  std::set<std::string> uris;
  try {
    const Bytes file = read_regular_file(scene, physical_memory_bytes());
    digest.add(file.span());
    try {
      collect_uris(parse_json(open_container(file.span(), scene.extension() == ".glb").json), uris);
    } catch (const InputError&) {
      // The loader says what is broken.
    }
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", scene.string(), error.what()));
  }
  for (const std::string& uri : uris) {
    if (uri.rfind("data:", 0) == 0) continue;
    std::filesystem::path file;
    try {
      file = resolve_uri(scene.parent_path(), uri);
    } catch (const InputError&) {
      continue;  // the loader refuses it, or does not need it
    }
    digest.add(bytes_of(uri));
    std::error_code unreadable;
    if (!std::filesystem::is_regular_file(file, unreadable)) continue;
    const InputsDigest read = digest_file(file);
    digest.add(std::as_bytes(std::span(&read.hash, 1)));
    digest.bytes += read.bytes;
  }
  return {digest.hash, digest.bytes};
}

std::string job_key(const InputsDigest& scene, const InputsDigest& environment, const std::string& settings) {
  const std::string text =
      fmt::format("{}\n{:016x}\n{:016x}\n{}", EIKON_VERSION, scene.hash, environment.hash, settings);
  return fmt::format("{:016x}", xxhash64(bytes_of(text), 0));
}

}  // namespace eikon
