// SPDX-License-Identifier: Apache-2.0
// What animations may change: one table of places in a document, by JSON pointers [RFC 6901] as
// KHR_animation_pointer has them. glTF's own targets are such places too.
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gltf/animation/sampler.h"
#include "io/json_text.h"

namespace eikon {

inline constexpr const char* kPointerExtension = "KHR_animation_pointer";

/// A property that eikon reads and that may change over time.
struct Property {
  std::string_view pattern;  // a JSON pointer; '*' is any one name or index, '**' one or more of them
  std::uint32_t width = 1;   // numbers; 1: no array. 0: the weights of morph targets, as many as the mesh has
  ValueKind kind = ValueKind::numbers;
  double least = std::numeric_limits<double>::lowest(), most = std::numeric_limits<double>::max();
};

/// The row of the table for a pointer, or null if eikon reads no such property or cannot change it.
[[nodiscard]] const Property* find_property(std::string_view pointer);

/// The number of morph targets of which a pointer has the weights, or one of them; nothing for one
/// that leads to no mesh with targets.
[[nodiscard]] std::optional<std::size_t> weight_count(const Json& document, std::string_view pointer);

/// Checks that what holds the property is there. throws InputError, without the place of the
/// pointer
void check_pointer(const Json& document, std::string_view pointer);

/// Writes a value to a place that check_pointer has let pass. References to other values of the
/// document stay valid. Numbers beyond the property's range are brought into it. Returns whether
/// all were within.
bool write_property(Json& document, std::string_view pointer, const Property& property,
                    const std::vector<double>& value);

}  // namespace eikon
