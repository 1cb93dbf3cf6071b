// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/triangles.h"

#include <fmt/format.h>

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

std::vector<std::uint32_t> read_indices(const Accessor& indices, std::uint64_t vertex_count, const std::string& user) {
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
  std::vector<std::uint32_t> result(indices.count);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const std::uint32_t index = indices.index_at(i);
    if (index == restart_value(type)) {
      throw InputError(fmt::format("{}: {}, element {} is {}, the primitive restart value, which glTF forbids", user,
                                   indices.label, i, index));
    }
    if (index >= vertex_count) {
      throw InputError(fmt::format("{}: {}, element {} is {}, but there are only {} positions", user, indices.label, i,
                                   index, vertex_count));
    }
    result[i] = index;
  }
  return result;
}

std::vector<std::uint32_t> list_triangles(std::vector<std::uint32_t> corners, TriangleMode mode) {
  if (mode == TriangleMode::list) {
    corners.resize(corners.size() / 3 * 3);
    return corners;
  }
  std::vector<std::uint32_t> result;
  if (corners.size() < 3) return result;
  result.reserve(3 * (corners.size() - 2));
  for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
    const bool strip = mode == TriangleMode::strip;
    const std::uint32_t a = strip ? corners[i] : corners[i + 1];
    const std::uint32_t b = strip ? corners[i + 1 + i % 2] : corners[i + 2];
    const std::uint32_t c = strip ? corners[i + 2 - i % 2] : corners[0];
    if (a != b && b != c && c != a) result.insert(result.end(), {a, b, c});
  }
  return result;
}

}  // namespace eikon
