// SPDX-License-Identifier: Apache-2.0
#include "film/mattes.h"

#include <algorithm>
#include <bit>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/json_dump.h"

namespace eikon {
namespace {

using nlohmann::json;

constexpr std::string_view kObject = "cryptomatte_object", kMaterial = "cryptomatte_material";

/// Replaces what is not UTF-8 in a name as dump_json() does, so that the hashed name is the name in
/// the manifest.
std::string in_utf8(const std::string& name) { return json::parse(dump_json(json(name))).get<std::string>(); }

std::uint32_t murmur_hash(std::string_view key) {
  const auto byte = [&](std::size_t i) { return std::uint32_t{static_cast<unsigned char>(key[i])}; };
  const auto mixed = [](std::uint32_t k) { return std::rotl(k * 0xcc9e2d51U, 15) * 0x1b873593U; };
  std::uint32_t hash = 0;
  std::size_t i = 0;
  for (; i + 4 <= key.size(); i += 4) {
    hash ^= mixed(byte(i) | byte(i + 1) << 8U | byte(i + 2) << 16U | byte(i + 3) << 24U);
    hash = std::rotl(hash, 13) * 5 + 0xe6546b64U;
  }
  std::uint32_t rest = 0;
  for (std::size_t k = 0; i + k < key.size(); ++k) rest |= byte(i + k) << (8 * k);
  hash ^= mixed(rest);
  hash ^= static_cast<std::uint32_t>(key.size());
  hash = (hash ^ hash >> 16U) * 0x85ebca6bU;
  hash = (hash ^ hash >> 13U) * 0xc2b2ae35U;
  return hash ^ hash >> 16U;
}

void add(Mattes& mattes, std::string_view layer, const std::vector<std::string>& names) {
  std::vector<std::uint32_t> ids{0};
  json manifest = json::object();
  for (const std::string& name : names) {
    const std::string known = in_utf8(name);
    ids.push_back(matte_id(known));
    manifest[known] = matte_hex(ids.back());
  }
  mattes.layers.emplace_back(layer);
  mattes.ids.push_back(std::move(ids));
  mattes.manifests.emplace(layer, dump_json(manifest));
}

}  // namespace

std::uint32_t matte_id(std::string_view name) {
  const std::uint32_t hash = murmur_hash(name), exponent = hash >> 23U & 0xffU;
  // Neither denormal nor infinite nor NaN.
  return exponent == 0 || exponent == 0xff ? hash ^ 1U << 23U : hash;
}

std::string matte_hex(std::uint32_t id) { return fmt::format("{:08x}", id); }

bool is_matte(std::string_view layer) { return layer == kObject || layer == kMaterial; }

Mattes make_mattes(const Scene& scene, const std::vector<std::string>& layers) {
  Mattes mattes;
  if (std::ranges::find(layers, kObject) != layers.end()) add(mattes, kObject, object_names(scene));
  if (std::ranges::find(layers, kMaterial) != layers.end()) add(mattes, kMaterial, material_names(scene));
  return mattes;
}

std::vector<std::string> object_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const Node& node : scene.nodes) names.push_back(node.name);
  for (const Shape& shape : scene.shapes) names.push_back(shape.name);
  return names;
}

std::vector<std::string> material_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const Material& material : scene.materials)
    names.push_back(material.name.empty() ? fmt::format("material {}", names.size()) : material.name);
  return names;
}

std::string to_json(const std::vector<std::string>& names) { return dump_json(json(names)); }

}  // namespace eikon
