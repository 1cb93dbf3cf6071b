// SPDX-License-Identifier: Apache-2.0
// Materials to choose from: KHR_materials_variants.
#pragma once
#include <string>
#include <vector>

#include "gltf/document/document.h"
#include "io/json_text.h"

namespace eikon {

inline constexpr const char* kVariantsExtension = "KHR_materials_variants";

/// Checks the document's list of variants. throws InputError with the place
void check_variants(const Json& document);

/// Checks a primitive's mappings. throws InputError with the place
void check_variant_mappings(const JsonView& primitive, std::size_t material_count, std::size_t variant_count);

/// The names of the variants of a checked document, in its order.
[[nodiscard]] std::vector<std::string> variants_of(const Json& document);

/// Gives every primitive the material that it has in the first variant of this name; those that do
/// not mention the variant keep theirs. throws InputError, with the names that there are, if there
/// is no such variant
void choose_variant(Document& document, const std::string& name);

}  // namespace eikon
