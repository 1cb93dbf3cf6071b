// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/variants.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.h"
#include "gltf/extensions.h"
#include "io/text.h"

namespace eikon {
namespace {

/// Calls `check` with the elements of an array of the owner's extension.
template <class Check>
void check_parts(const JsonView& owner, const char* key, std::string_view kind, const Check& check) {
  const Json* extensions = as_object(owner, "extensions");
  if (extensions == nullptr) return;
  const JsonView list{.value = *extensions, .kind = "extensions", .parent = &owner};
  const Json* json = as_object(list, kVariantsExtension);
  if (json == nullptr) return;
  const JsonView extension{.value = *json, .kind = kVariantsExtension, .parent = &owner};
  const Json* parts = as_array(extension, key);
  if (parts == nullptr) extension.fail(fmt::format("'{}' is missing", key));
  for (std::size_t i = 0; i < size_of(*parts); ++i) {
    const JsonView part{
        .value = element(*parts, i), .kind = kind, .index = static_cast<std::int64_t>(i), .parent = &extension};
    if (!is_object(part.value)) part.fail("is not an object");
    check(part);
  }
}

/// True if a mapping of a primitive is for variant `wanted`.
bool is_for(const Json& mapping, std::size_t wanted) {
  const Json& variants = *member(mapping, "variants");
  for (std::size_t i = 0; i < size_of(variants); ++i)
    if (to_index(element(variants, i)) == wanted) return true;
  return false;
}

}  // namespace

void check_variants(const Json& document) {
  check_parts({.value = document, .kind = "document"}, "variants", "variant", [](const JsonView& variant) {
    if (as_string(variant, "name") == nullptr) variant.fail("'name' is missing");
  });
}

void check_variant_mappings(const JsonView& primitive, std::size_t material_count, std::size_t variant_count) {
  check_parts(primitive, "mappings", "mapping", [&](const JsonView& mapping) {
    required_integer(mapping, "material", ~std::uint64_t{0});
    as_index(mapping, "material", material_count, "material");
    const Json* variants = as_array(mapping, "variants");
    if (variants == nullptr) mapping.fail("'variants' is missing");
    for (std::size_t i = 0; i < size_of(*variants); ++i)
      if (!is_index(element(*variants, i), variant_count))
        mapping.fail(fmt::format("'variants' has {}, but the file has {} variants", excerpt(element(*variants, i)),
                                 variant_count));
  });
}

std::vector<std::string> variants_of(const Json& document) {
  std::vector<std::string> names;
  const Json* variants = member(extension_of(document, kVariantsExtension), "variants");
  for (std::size_t i = 0; variants != nullptr && i < size_of(*variants); ++i)
    names.push_back(to_string(*member(element(*variants, i), "name")));
  return names;
}

void choose_variant(Document& document, const std::string& name) {
  const std::vector<std::string> names = variants_of(document.json);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    std::vector<std::string> quoted;
    for (const std::string& known : names) quoted.push_back(in_quotes(known));
    throw InputError(fmt::format("it has no variant {}; {}", in_quotes(name),
                                 names.empty() ? "it has none at all: leave --variant out"
                                               : fmt::format("choose one of {}", fmt::join(quoted, ", "))));
  }
  const auto wanted = static_cast<std::size_t>(found - names.begin());
  for (GltfMesh& mesh : document.meshes) {
    for (GltfPrimitive& primitive : mesh.primitives) {
      const Json* mappings = member(extension_of(primitive.json, kVariantsExtension), "mappings");
      for (std::size_t i = 0; mappings != nullptr && i < size_of(*mappings); ++i) {
        if (!is_for(element(*mappings, i), wanted)) continue;
        primitive.material = to_index(*member(element(*mappings, i), "material"));
        break;
      }
    }
  }
}

}  // namespace eikon
