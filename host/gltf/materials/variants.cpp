// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/variants.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "io/text.h"

namespace eikon {
namespace {

/// The member `key` of an owner's extension, if there is one.
const Json* part_of(const Json& owner, const char* key) {
  const Json* extensions = member(owner, "extensions");
  const Json* extension = extensions == nullptr ? nullptr : member(*extensions, kVariantsExtension.data());
  return extension == nullptr ? nullptr : member(*extension, key);
}

/// Calls check with the elements of an extension's array.
template <class Check>
void check_parts(const Place& owner, const char* key, std::string_view kind, const Check& check) {
  const Json* extensions = as_object(owner, "extensions");
  if (extensions == nullptr) return;
  const Place list{.value = *extensions, .kind = "extensions", .parent = &owner};
  const Json* json = as_object(list, kVariantsExtension.data());
  if (json == nullptr) return;
  const Place extension{.value = *json, .kind = kVariantsExtension, .parent = &owner};
  const Json* parts = as_array(extension, key);
  if (parts == nullptr) extension.fail(fmt::format("'{}' is missing", key));
  for (std::size_t i = 0; i < parts->size(); ++i) {
    const Place part{.value = (*parts)[i], .kind = kind, .index = static_cast<std::int64_t>(i), .parent = &extension};
    if (!part.value.is_object()) part.fail("is not an object");
    check(part);
  }
}

}  // namespace

void check_variants(const Json& document) {
  check_parts({.value = document, .kind = "document"}, "variants", "variant", [](const Place& variant) {
    check_string(variant, "name");
    if (member(variant.value, "name") == nullptr) variant.fail("'name' is missing");
  });
}

void check_variant_mappings(const Place& primitive, std::size_t material_count, std::size_t variant_count) {
  check_parts(primitive, "mappings", "mapping", [&](const Place& mapping) {
    required_integer(mapping, "material", ~std::uint64_t{0});
    as_index(mapping, "material", material_count, "material");
    const Json* variants = as_array(mapping, "variants");
    if (variants == nullptr) mapping.fail("'variants' is missing");
    for (const Json& variant : *variants) {
      const double index = variant.is_number_integer() ? variant.get<double>() : -1;
      if (!(index >= 0 && index < static_cast<double>(variant_count)))
        mapping.fail(fmt::format("'variants' has {}, but the file has {} variants",
                                 one_line(variant.dump()).substr(0, 40), variant_count));
    }
  });
}

std::vector<std::string> variants_of(const Json& document) {
  std::vector<std::string> names;
  const Json* variants = part_of(document, "variants");
  for (std::size_t i = 0; variants != nullptr && i < variants->size(); ++i)
    names.push_back((*variants)[i]["name"].get<std::string>());
  return names;
}

void choose_variant(Json& document, const std::string& name) {
  const std::vector<std::string> names = variants_of(document);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    std::vector<std::string> quoted;
    for (const std::string& known : names) quoted.push_back(in_quotes(known));
    throw InputError(fmt::format("it has no variant {}; {}", in_quotes(name),
                                 names.empty() ? "it has none at all: leave --variant out"
                                               : fmt::format("choose one of {}", fmt::join(quoted, ", "))));
  }
  const auto wanted = static_cast<std::uint64_t>(found - names.begin());
  if (items(document, "meshes").empty()) return;
  for (Json& mesh : document["meshes"]) {
    for (Json& primitive : mesh["primitives"]) {
      const Json* mappings = part_of(primitive, "mappings");
      if (mappings == nullptr) continue;
      const auto mapping = std::find_if(mappings->begin(), mappings->end(), [&](const Json& candidate) {
        const Json& variants = candidate["variants"];
        return std::find(variants.begin(), variants.end(), wanted) != variants.end();
      });
      if (mapping == mappings->end()) continue;
      const Json material = (*mapping)["material"];
      primitive["material"] = material;
    }
  }
}

}  // namespace eikon
