// SPDX-License-Identifier: Apache-2.0
// Cryptomatte [Friedman and Jones 2015; specification 1.2]. Ids are hashes of names. A picture
// stores for each pixel the ids that it shows, each with its share of the samples.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace eikon {

/// The id of a name in UTF-8: MurmurHash3_32 with seed 0, whose bits are changed to those of a
/// normal float as the specification demands.
[[nodiscard]] std::uint32_t matte_id(std::string_view name);
/// Formats an id as "0a1b2c3d", the form in manifests and in keys of a file's header.
[[nodiscard]] std::string matte_hex(std::uint32_t id);

/// The mattes of a render, in the order in which the kernels have them (features.def: matte_object,
/// matte_material).
struct Mattes {
  std::vector<std::string> layers;                 // "cryptomatte_object", ...
  // [matte][number of the hit object or material]; number 0: a miss, id 0.
  std::vector<std::vector<std::uint32_t>> ids;
  std::map<std::string, std::string> manifests{};  // by layer: JSON, {"name": "id", ...}
};
[[nodiscard]] Mattes make_mattes(const Scene& scene, const std::vector<std::string>& layers);
[[nodiscard]] bool is_matte(std::string_view layer);

/// The names for the numbers in layers object_id and material_id, from number 1 on; "node 3"
/// replaces a missing name. An object is a node; nodes with shapes come after those with meshes.
[[nodiscard]] std::vector<std::string> object_names(const Scene& scene);
[[nodiscard]] std::vector<std::string> material_names(const Scene& scene);
/// Formats names as a JSON array on one line, in valid UTF-8 even when a name is not.
[[nodiscard]] std::string to_json(const std::vector<std::string>& names);

}  // namespace eikon
