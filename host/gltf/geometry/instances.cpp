// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/instances.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/text.h"
#include "scene/transform.h"

namespace eikon {
namespace {

constexpr const char* kExtension = "EXT_mesh_gpu_instancing";

/// An attribute that places instances; others, whose names begin with an underscore, are the application's own.
const Accessor* attribute(const Place& place, const Json& attributes, const char* name,
                          const std::vector<Accessor>& accessors) {
  const Json* index = member(attributes, name);
  if (index == nullptr) return nullptr;
  const Accessor& accessor = accessors[index->get<std::size_t>()];
  const bool rotation = std::string_view(name) == "ROTATION";
  const bool legal =
      accessor.is(ComponentType::f32, rotation ? 4 : 3) ||
      (rotation && accessor.normalized && (accessor.is(ComponentType::i8, 4) || accessor.is(ComponentType::i16, 4)));
  if (!legal)
    place.fail(fmt::format("{} in {} is not {}", name, accessor.label,
                           rotation ? "VEC4 of floats or of normalized bytes or shorts" : "VEC3 of floats"));
  return &accessor;
}

glm::dvec4 element(const Place& place, const char* name, const Accessor* accessor, std::uint64_t i,
                   const glm::dvec4& otherwise) {
  if (accessor == nullptr) return otherwise;
  const glm::vec4 value = accessor->vector_at(i);
  for (int k = 0; k < 4; ++k)
    if (!std::isfinite(value[k]))
      place.fail(fmt::format("{} in {}, element {}, is not finite", name, accessor->label, i));
  return glm::dvec4(value);
}

const Json* extension_of(const Place& node) {
  const Json* extensions = member(node.value, "extensions");
  return extensions == nullptr ? nullptr : member(*extensions, kExtension);
}

}  // namespace

void check_instancing(const Place& node, std::size_t accessor_count) {
  const Json* extensions = member(node.value, "extensions");
  if (extensions == nullptr) return;
  const Json* instancing = as_object({.value = *extensions, .kind = "extensions", .parent = &node}, kExtension);
  if (instancing == nullptr) return;
  const Place place{.value = *instancing, .kind = kExtension, .parent = &node};
  const Json* attributes = as_object(place, "attributes");
  if (attributes == nullptr || attributes->empty()) place.fail("'attributes' is missing or empty");
  for (const auto& entry : attributes->items()) {
    const Json& index = entry.value();
    if (!index.is_number_unsigned() || index.get<std::uint64_t>() >= accessor_count)
      place.fail(fmt::format("{} is not one of the {} accessors", in_quotes(entry.key()), accessor_count));
  }
}

std::optional<std::vector<glm::dmat4>> read_instances(const Place& node, const std::vector<Accessor>& accessors) {
  const Json* instancing = extension_of(node);
  if (instancing == nullptr) return std::nullopt;
  const Place place{.value = *instancing, .kind = kExtension, .parent = &node};
  const Json& attributes = instancing->at("attributes");
  const Accessor* first = nullptr;
  for (const auto& entry : attributes.items()) {
    const Accessor& accessor = accessors[entry.value().get<std::size_t>()];
    if (first == nullptr) first = &accessor;
    if (accessor.count != first->count)
      place.fail(fmt::format("{} has {} elements, {} has {}; each instance needs one of every attribute", first->label,
                             first->count, accessor.label, accessor.count));
    if (accessor.data == nullptr && accessor.count > kMaxZeroCount)
      place.refuse(fmt::format("{} is {} elements of zeros without a bufferView, at most {} are read; give it one",
                               accessor.label, accessor.count, kMaxZeroCount));
  }
  const Accessor* translation = attribute(place, attributes, "TRANSLATION", accessors);
  const Accessor* rotation = attribute(place, attributes, "ROTATION", accessors);
  const Accessor* scale = attribute(place, attributes, "SCALE", accessors);

  std::vector<glm::dmat4> result;
  result.reserve(first->count);
  for (std::uint64_t i = 0; i < first->count; ++i) {
    const glm::dvec4 turn = element(place, "ROTATION", rotation, i, {0, 0, 0, 1});
    if (turn == glm::dvec4(0.0))
      place.fail(fmt::format("ROTATION in {}, element {}, is (0, 0, 0, 0), which is no rotation", rotation->label, i));
    result.push_back(transform_matrix(glm::dvec3(element(place, "TRANSLATION", translation, i, glm::dvec4(0.0))), turn,
                                      glm::dvec3(element(place, "SCALE", scale, i, glm::dvec4(1.0)))));
  }
  return result;
}

}  // namespace eikon
