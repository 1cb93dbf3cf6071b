// SPDX-License-Identifier: Apache-2.0
// Accessors of a file. Every byte that they give access to is checked to lie inside its buffer.
#pragma once
#include <array>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "io/json_text.h"
#include "gltf/document/buffer_views.h"
#include "gltf/document/wrong_parts.h"

namespace eikon {

enum class ComponentType : std::uint32_t { i8 = 5120, u8 = 5121, i16 = 5122, u16 = 5123, u32 = 5125, f32 = 5126 };

/// A checked accessor: element i of `count` can be read, whatever the file says.
struct Accessor {
  const std::byte* data = nullptr;  // null: zeros, as glTF has it where there is no bufferView
  std::uint64_t count = 0;          // elements
  std::uint32_t stride_bytes = 0;
  ComponentType component = ComponentType::f32;
  std::uint32_t component_count = 0;  // 1: SCALAR, 3: VEC3, ...
  bool is_matrix = false;
  bool normalized = false;

  // Elements that replace those of `data`: where, ascending strictly and below `count`, and with
  // what, tightly packed.
  std::uint64_t sparse_count = 0;
  const std::byte* sparse_indices = nullptr;
  ComponentType sparse_index_type = ComponentType::u8;
  const std::byte* sparse_values = nullptr;

  std::string label;  // "accessor 3 'positions'"

  /// Equal for accessors with the same elements, whatever their labels.
  [[nodiscard]] auto contents() const {
    return std::tuple(data, count, stride_bytes, component, component_count, is_matrix, normalized, sparse_count,
                      sparse_indices, sparse_index_type, sparse_values);
  }
  [[nodiscard]] std::uint64_t element_bytes() const;  // of one element, without the gap to the next
  [[nodiscard]] bool is(ComponentType type, std::uint32_t components) const {
    return component == type && component_count == components && !is_matrix;
  }
  /// Element i of a SCALAR or VEC: integers as they are, or divided where `normalized` [glTF 2.0,
  /// section 3.11]; 0 in the components that it does not have.
  [[nodiscard]] glm::vec4 vector_at(std::uint64_t i) const {
    if (!is(ComponentType::f32, 3) || sparse_count != 0 || data == nullptr) return any_vector_at(i);
    std::array<float, 3> value{};  // nearly all are of this kind
    std::memcpy(value.data(), data + i * stride_bytes, sizeof value);
    return {value[0], value[1], value[2], 0.0F};
  }
  /// Element i of a MAT4 of f32.
  [[nodiscard]] glm::mat4 matrix_at(std::uint64_t i) const;
  /// Sparse element k, below `sparse_count`: which element of the accessor it replaces, by what.
  [[nodiscard]] std::pair<std::uint64_t, glm::vec4> sparse_vector_at(std::uint64_t k) const;
  /// Element i of a SCALAR of u8, u16 or u32.
  [[nodiscard]] std::uint32_t index_at(std::uint64_t i) const;

 private:
  [[nodiscard]] glm::vec4 any_vector_at(std::uint64_t i) const;
  [[nodiscard]] const std::byte* element(std::uint64_t i, std::size_t bytes) const;
  [[nodiscard]] glm::vec4 load_vector(const std::byte* p) const;
};

/// Elements of an accessor with nothing behind it cost the file nothing, so their number needs a
/// bound of its own.
inline constexpr std::uint64_t kMaxZeroCount = std::uint64_t{1} << 20U;

/// The accessors of a checked document, checked against its bufferViews. One with numbers that do
/// not fit is added to `wrong`.
class AccessorTable {
 public:
  /// The arguments outlive the table.
  AccessorTable(const Json& document, const BufferViews& views, WrongParts& wrong);

  /// throws InputError with what is wrong with it, if anything is
  [[nodiscard]] const Accessor& operator[](std::size_t accessor) const {
    wrong_.check("accessor", accessor);
    return accessors_[accessor];
  }
  [[nodiscard]] std::size_t size() const { return accessors_.size(); }

 private:
  std::vector<Accessor> accessors_;
  const WrongParts& wrong_;
};

}  // namespace eikon
