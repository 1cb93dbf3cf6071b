// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/triangles.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"

namespace eikon {
namespace {

std::uint32_t restart_value(ComponentType type) {
  switch (type) {
    case ComponentType::u8:
      return 0xFFU;
    case ComponentType::u16:
      return 0xFFFFU;
    default:
      return 0xFFFFFFFFU;
  }
}

}  // namespace

void check_indices(const Accessor& indices, std::uint64_t vertex_count, const std::string& user) {
  const ComponentType type = indices.component;
  const bool is_unsigned = type == ComponentType::u8 || type == ComponentType::u16 || type == ComponentType::u32;
  if (!is_unsigned || !indices.is(type, 1) || indices.normalized) {
    throw InputError(
        fmt::format("{}: indices in {} are not plain SCALAR of unsigned byte, short or int", user, indices.label));
  }
  if (indices.data == nullptr && indices.count > kMaxZeroCount) {
    throw InputError(
        fmt::format("{}: indices in {} are {} zeros without a bufferView, at most {} are read; give it one", user,
                    indices.label, indices.count, kMaxZeroCount));
  }
  for (std::uint64_t i = 0; i < indices.count; ++i) {
    const std::uint32_t index = indices.index_at(i);
    if (index == restart_value(type)) {
      throw InputError(fmt::format("{}: {}, element {} is {}, the primitive restart value, which glTF forbids", user,
                                   indices.label, i, index));
    }
    if (index >= vertex_count) {
      throw InputError(fmt::format("{}: {}, element {} is {}, but there are only {} positions", user, indices.label, i,
                                   index, vertex_count));
    }
  }
}

TriangleIndices read_triangles(const Accessor* indices, TriangleMode mode, std::uint64_t vertex_count) {
  TriangleIndices::Source source{.mode = mode, .count = vertex_count, .corner = [](std::size_t i) {
                                   return static_cast<std::uint32_t>(i);
                                 }};
  if (vertex_count > 0) source.largest = static_cast<std::uint32_t>(vertex_count - 1);
  if (indices != nullptr) {
    source.count = indices->count;
    source.largest = std::min(source.largest, restart_value(indices->component));
    source.corner = [indices](std::size_t i) { return indices->index_at(i); };
  }
  return TriangleIndices(source);
}

std::vector<std::uint32_t> VertexCompactor::renumber(TriangleIndices& indices, std::uint64_t vertex_count) {
  std::uint64_t count = 0;
  std::vector<bool> is_used(vertex_count);
  for (std::size_t t = 0; t < indices.triangle_count() && count < vertex_count; ++t)
    for (const std::uint32_t vertex : indices.triangle(t)) {
      count += is_used[vertex] ? 0 : 1;
      is_used[vertex] = true;
    }
  if (count == vertex_count) return {};  // there is nothing to leave out, so the file's own order stays
  if (slot_.size() < vertex_count) slot_.resize(vertex_count, kNoSlot);
  std::vector<std::uint32_t> used;
  used.reserve(count);
  for (std::size_t t = 0; t < indices.triangle_count(); ++t)
    for (const std::uint32_t vertex : indices.triangle(t)) {
      if (slot_[vertex] != kNoSlot) continue;
      slot_[vertex] = static_cast<std::uint32_t>(used.size());
      used.push_back(vertex);
    }
  indices.renumber(slot_);
  for (const std::uint32_t vertex : used) slot_[vertex] = kNoSlot;
  return used;
}

}  // namespace eikon
