// SPDX-License-Identifier: Apache-2.0
// Cryptomatte [Friedman and Jones 2015; specification 1.2]: ids that are hashes of names, and of which a picture keeps those that
// each of its pixels shows, with the share of its samples.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace eikon {

/// Of a name in UTF-8: MurmurHash3_32 with seed 0 as the bits of a float, of which the exponent is made that of a normal number,
/// as the specification says.
[[nodiscard]] std::uint32_t matte_id(std::string_view name);
/// "0a1b2c3d", as manifests and the keys of a file's header have it.
[[nodiscard]] std::string matte_hex(std::uint32_t id);

/// The mattes of a render, in the order in which the kernels have them (features.def: matte_object, matte_material).
struct Mattes {
  std::vector<std::string> layers;                 // "cryptomatte_object", ...
  std::vector<std::vector<std::uint32_t>> ids;     // [matte][number of what a ray met]; number 0: nothing, id 0
  std::map<std::string, std::string> manifests{};  // by layer: JSON, {"name": "id", ...}
};
[[nodiscard]] Mattes make_mattes(const Scene& scene, const std::vector<std::string>& layers);
[[nodiscard]] bool is_matte(std::string_view layer);

/// What the numbers of layers object_id and material_id stand for, from number 1 on: names, or "node 3" where there is none.
/// Nodes stand for what they place; shapes come behind those with meshes.
[[nodiscard]] std::vector<std::string> object_names(const Scene& scene);
[[nodiscard]] std::vector<std::string> material_names(const Scene& scene);
/// ["name", ...], on one line, in UTF-8 whatever the names are.
[[nodiscard]] std::string to_json(const std::vector<std::string>& names);

}  // namespace eikon
