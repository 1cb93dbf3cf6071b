// SPDX-License-Identifier: Apache-2.0
#include "gltf/scene_files.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "io/json_text.h"
#include "io/source_file.h"

namespace eikon {
namespace {

namespace fs = std::filesystem;

/// Collects every text under the name "uri", wherever it stands, since extensions have some too.
void collect_uris(const Json& value, std::set<std::string>& uris) {
  for (const auto& [name, member] : value.items()) {
    if (name == "uri" && member.is_string())
      uris.insert(member.get<std::string>());
    else if (member.is_structured())
      collect_uris(member, uris);
  }
}

std::map<std::string, fs::path> files_of(const fs::path& folder, std::string_view json) {
  std::set<std::string> uris;
  std::map<std::string, fs::path> files;
  try {
    collect_uris(parse_json(json), uris);
  } catch (const InputError&) {
    return files;  // the loader reports what is broken
  }
  for (const std::string& uri : uris) {
    if (is_data_uri(uri)) continue;
    try {
      files.emplace(uri, resolve_uri(folder, uri));
    } catch (const InputError&) {
      // The loader refuses it, or does not need it.
    }
  }
  return files;
}

/// The first chunk of a .glb [glTF 2.0, section 4.4]; empty if there is none.
std::string glb_document(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return {};
  const std::uintmax_t size = fs::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  std::uint32_t head[5] = {};  // magic, version, length; length and type of the chunk
  if (error || !file.read(reinterpret_cast<char*>(head), sizeof(head)) || head[3] > size - sizeof(head)) return {};
  std::string json(head[3], '\0');
  return file.read(json.data(), std::streamsize(json.size())) ? json : std::string();
}

}  // namespace

std::map<std::string, fs::path> named_files(const fs::path& folder, std::span<const std::byte> document, bool is_glb) {
  try {
    return files_of(folder, open_container(document, is_glb).json);
  } catch (const InputError&) {
    return {};
  }
}

std::vector<fs::path> scene_files(const fs::path& scene) {
  std::vector<fs::path> files = {scene};
  std::map<std::string, fs::path> named;
  if (scene.extension() == ".glb") {
    named = files_of(scene.parent_path(), glb_document(scene));
  } else {
    try {
      const Bytes text = read_regular_file(scene, usable_memory_bytes());
      named = named_files(scene.parent_path(), text.span(), false);
    } catch (const InputError&) {
      return files;
    }
  }
  for (const auto& [uri, file] : named) files.push_back(file);
  return files;
}

}  // namespace eikon
