// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/instances.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "gltf/extensions.h"
#include "io/text.h"
#include "scene/transform.h"

namespace eikon {
namespace {

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

/// An attribute that places instances; others, whose names begin with an underscore, are the
/// application's own.
const Accessor* attribute(const JsonView& view, const Json& attributes, const char* name,
                          const AccessorTable& accessors) {
  const Json* index = member(attributes, name);
  if (index == nullptr) return nullptr;
  const Accessor& accessor = accessors[to_index(*index)];
  const bool rotation = std::string_view(name) == "ROTATION";
  const bool legal =
      accessor.is(ComponentType::f32, rotation ? 4 : 3) ||
      (rotation && accessor.normalized && (accessor.is(ComponentType::i8, 4) || accessor.is(ComponentType::i16, 4)));
  if (!legal)
    view.fail(fmt::format("{} in {} is not {}", name, accessor.label,
                          rotation ? "VEC4 of floats or of normalized bytes or shorts" : "VEC3 of floats"));
  return &accessor;
}

glm::dvec4 value_at(const JsonView& view, const char* name, const Accessor* accessor, std::uint64_t i,
                   const glm::dvec4& otherwise) {
  if (accessor == nullptr) return otherwise;
  const glm::vec4 value = accessor->vector_at(i);
  for (int k = 0; k < 4; ++k)
    if (!std::isfinite(value[k]))
      view.fail(fmt::format("{} in {}, element {}, is not finite", name, accessor->label, i));
  return glm::dvec4(value);
}

}  // namespace

void check_instancing(const JsonView& node, std::size_t accessor_count) {
  const Json* extensions = member(node.value, "extensions");
  if (extensions == nullptr) return;
  const Json* instancing = as_object({.value = *extensions, .kind = "extensions", .parent = &node}, kInstancing);
  if (instancing == nullptr) return;
  const JsonView view{.value = *instancing, .kind = kInstancing, .parent = &node};
  const Json* attributes = as_object(view, "attributes");
  if (members(attributes).empty()) view.fail("'attributes' is missing or empty");
  for (const JsonMember& attribute : members(attributes))
    if (!is_index(attribute.value, accessor_count))
      view.fail(fmt::format("{} is not one of the {} accessors", in_quotes(attribute.key), accessor_count));
}

bool has_instances(const JsonView& node) { return extension_of(node.value, kInstancing) != nullptr; }

std::optional<std::vector<glm::dmat4>> read_instances(const JsonView& node, const AccessorTable& accessors) {
  const Json* instancing = extension_of(node.value, kInstancing);
  if (instancing == nullptr) return std::nullopt;
  const JsonView view{.value = *instancing, .kind = kInstancing, .parent = &node};
  const Json& attributes = *member(instancing, "attributes");
  const Accessor* first = nullptr;
  for (const JsonMember& entry : members(&attributes)) {
    const Accessor& accessor = accessors[to_index(entry.value)];
    if (first == nullptr) first = &accessor;
    if (accessor.count != first->count)
      view.fail(fmt::format("{} has {} elements, {} has {}; each instance needs one of every attribute", first->label,
                            first->count, accessor.label, accessor.count));
    if (accessor.data == nullptr && accessor.count > kMaxZeroCount)
      view.refuse(fmt::format("{} is {} elements of zeros without a bufferView, at most {} are read; give it one",
                              accessor.label, accessor.count, kMaxZeroCount));
  }
  const Accessor* translation = attribute(view, attributes, "TRANSLATION", accessors);
  const Accessor* rotation = attribute(view, attributes, "ROTATION", accessors);
  const Accessor* scale = attribute(view, attributes, "SCALE", accessors);

  std::vector<glm::dmat4> result;
  result.reserve(first->count);
  for (std::uint64_t i = 0; i < first->count; ++i) {
    const glm::dvec4 turn = value_at(view, "ROTATION", rotation, i, {0, 0, 0, 1});
    if (turn == glm::dvec4(0.0))
      view.fail(fmt::format("ROTATION in {}, element {}, is (0, 0, 0, 0), which is no rotation", rotation->label, i));
    result.push_back(transform_matrix(glm::dvec3(value_at(view, "TRANSLATION", translation, i, glm::dvec4(0.0))), turn,
                                      glm::dvec3(value_at(view, "SCALE", scale, i, glm::dvec4(1.0)))));
  }
  return result;
}

}  // namespace eikon
