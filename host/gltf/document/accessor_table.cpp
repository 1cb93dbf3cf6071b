// SPDX-License-Identifier: Apache-2.0
#include "gltf/document/accessor_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "io/text.h"

namespace eikon {
namespace {

// Counts times strides stay below 2^32 * 2^8, so sums and products with offsets fit in 64 bits.
constexpr std::uint64_t kMaxCount = 0xFFFFFFFFU;

struct ElementType {
  std::string_view name;
  std::uint32_t columns, rows;
};
constexpr std::array<ElementType, 7> kElementTypes{
    {{"SCALAR", 1, 1}, {"VEC2", 1, 2}, {"VEC3", 1, 3}, {"VEC4", 1, 4}, {"MAT2", 2, 2}, {"MAT3", 3, 3}, {"MAT4", 4, 4}}};

std::uint32_t bytes_of(ComponentType type) {
  switch (type) {
    case ComponentType::i8:
    case ComponentType::u8:
      return 1;
    case ComponentType::i16:
    case ComponentType::u16:
      return 2;
    case ComponentType::u32:
    case ComponentType::f32:
      return 4;
  }
  throw InternalError("component type outside its enumeration");
}

ComponentType component_type(const JsonView& view) {
  const std::uint64_t value = required_integer(view, "componentType", kMaxCount);
  switch (static_cast<ComponentType>(value)) {
    case ComponentType::i8:
    case ComponentType::u8:
    case ComponentType::i16:
    case ComponentType::u16:
    case ComponentType::u32:
    case ComponentType::f32:
      return static_cast<ComponentType>(value);
  }
  view.fail(fmt::format("'componentType' {} is none of 5120, 5121, 5122, 5123, 5125, 5126", value));
}

// The first of `count` elements in a bufferView. `element_bytes` is at most 64, so nothing wraps.
// It is what the last element takes: without the gap after the last column of a matrix.
const std::byte* check_range(const JsonView& view, std::span<const std::byte> bytes, std::uint64_t count,
                             std::uint64_t stride, std::uint64_t element_bytes) {
  const std::uint64_t offset = as_integer(view, "byteOffset", kMaxFileOffset).value_or(0);
  const std::uint64_t needed = count == 0 ? 0 : (count - 1) * stride + element_bytes;
  if (offset > bytes.size() || needed > bytes.size() - offset) {
    view.fail(fmt::format("{} elements need bytes {} to {} of a bufferView of {} bytes", count, offset, offset + needed,
                          bytes.size()));
  }
  return bytes.data() + offset;
}

std::uint32_t load_index(const std::byte* p, ComponentType type) {
  const auto byte = [&](unsigned i) { return std::to_integer<std::uint32_t>(p[i]) << (8 * i); };
  switch (bytes_of(type)) {  // little-endian, unaligned
    case 1:
      return byte(0);
    case 2:
      return byte(0) | byte(1);
    default:
      return byte(0) | byte(1) | byte(2) | byte(3);
  }
}

template <typename T>
T load_as(const std::byte* p) {
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
}

float component_at(const std::byte* p, ComponentType type, bool normalized) {
  switch (type) {
    case ComponentType::i8: {
      const auto value = static_cast<float>(load_as<std::int8_t>(p));
      return normalized ? std::max(value / 127.0F, -1.0F) : value;
    }
    case ComponentType::u8: {
      const auto value = static_cast<float>(load_as<std::uint8_t>(p));
      return normalized ? value / 255.0F : value;
    }
    case ComponentType::i16: {
      const auto value = static_cast<float>(load_as<std::int16_t>(p));
      return normalized ? std::max(value / 32767.0F, -1.0F) : value;
    }
    case ComponentType::u16: {
      const auto value = static_cast<float>(load_as<std::uint16_t>(p));
      return normalized ? value / 65535.0F : value;
    }
    case ComponentType::u32:
      return static_cast<float>(load_as<std::uint32_t>(p));
    case ComponentType::f32:
      return load_as<float>(p);
  }
  throw InternalError("component type outside its enumeration");
}

bool is_index_type(ComponentType type) {
  return type == ComponentType::u8 || type == ComponentType::u16 || type == ComponentType::u32;
}

std::span<const std::byte> required_view(const JsonView& view, const BufferViews& views) {
  const auto index = as_index(view, "bufferView", views.size(), "bufferView");
  if (!index) view.fail("'bufferView' is missing");
  return views[*index];
}

// An element of a type: all of it, and without the gap after its last column.
struct ElementSize {
  std::uint32_t padded_bytes, bytes;
};

// Columns of matrices begin at multiples of 4 bytes [glTF 2.0, section 3.6.2.4].
ElementSize element_size(const ElementType& type, ComponentType component) {
  const std::uint32_t column_bytes = type.rows * bytes_of(component);
  if (type.columns == 1) return {column_bytes, column_bytes};
  const std::uint32_t padded = (column_bytes + 3) / 4 * 4;
  return {type.columns * padded, (type.columns - 1) * padded + column_bytes};
}

void check_sparse(const JsonView& view, const BufferViews& views, const ElementSize& size, Accessor& accessor) {
  const Json* sparse_json = as_object(view, "sparse");
  if (sparse_json == nullptr) return;
  const JsonView sparse{.value = *sparse_json, .kind = "sparse", .parent = &view};
  const std::uint64_t count = required_integer(sparse, "count", accessor.count);
  const Json *indices_json = as_object(sparse, "indices"), *values_json = as_object(sparse, "values");
  if (indices_json == nullptr || values_json == nullptr) sparse.fail("'indices' or 'values' is missing");

  const JsonView indices{.value = *indices_json, .kind = "indices", .parent = &sparse};
  const ComponentType type = component_type(indices);
  if (!is_index_type(type)) indices.fail("indices are not unsigned integers");
  const std::byte* p = check_range(indices, required_view(indices, views), count, bytes_of(type), bytes_of(type));
  std::uint32_t last = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint32_t index = load_index(p + i * bytes_of(type), type);
    if (index >= accessor.count || (i > 0 && index <= last)) {
      indices.fail(fmt::format("element {} is {}: not ascending or not below {}", i, index, accessor.count));
    }
    last = index;
  }
  accessor.sparse_count = count;
  accessor.sparse_indices = p;
  accessor.sparse_index_type = type;
  const JsonView values{.value = *values_json, .kind = "values", .parent = &sparse};
  accessor.sparse_values = check_range(values, required_view(values, views), count, size.padded_bytes, size.bytes);
}

Accessor check_accessor(const JsonView& view, const BufferViews& views) {
  Accessor accessor;
  accessor.label = fmt::format("accessor {}", view.index);
  if (const Json* name = member(view.value, "name")) {
    accessor.label += fmt::format(" {}", in_quotes(to_string(*name)));
  }
  accessor.component = component_type(view);
  accessor.count = required_integer(view, "count", kMaxCount);
  if (const Json* normalized = member(view.value, "normalized")) {
    if (!is_boolean(*normalized)) view.fail("'normalized' is neither true nor false");
    accessor.normalized = to_boolean(*normalized);
  }
  const Json* type_name = member(view.value, "type");
  const auto type = std::find_if(kElementTypes.begin(), kElementTypes.end(),
                                 [&](const ElementType& t) { return equals(type_name, t.name); });
  if (type == kElementTypes.end()) view.fail("'type' is none of SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3, MAT4");
  accessor.component_count = type->columns * type->rows;
  accessor.is_matrix = type->columns > 1;

  const ElementSize size = element_size(*type, accessor.component);
  accessor.stride_bytes = size.padded_bytes;
  if (const auto view_index = as_index(view, "bufferView", views.size(), "bufferView")) {
    if (const std::uint32_t stride = views.stride_bytes(*view_index); stride != 0) accessor.stride_bytes = stride;
    if (accessor.stride_bytes < size.bytes) {
      view.fail(fmt::format("elements of {} bytes overlap: 'byteStride' of its bufferView is {}", size.bytes,
                            accessor.stride_bytes));
    }
    accessor.data = check_range(view, views[*view_index], accessor.count, accessor.stride_bytes, size.bytes);
  }
  check_sparse(view, views, size, accessor);
  return accessor;
}

}  // namespace

const std::byte* Accessor::element(std::uint64_t i, std::size_t bytes) const {
  if (sparse_count != 0) {
    const std::uint32_t index_bytes = bytes_of(sparse_index_type);
    const auto index_of = [&](std::uint64_t k) {
      return load_index(sparse_indices + k * index_bytes, sparse_index_type);
    };
    std::uint64_t first = 0, last = sparse_count;  // the first whose index is not below i
    while (first < last) {
      const std::uint64_t middle = (first + last) / 2;
      if (index_of(middle) < i) {
        first = middle + 1;
      } else {
        last = middle;
      }
    }
    if (first < sparse_count && index_of(first) == i) return sparse_values + first * bytes;
  }
  return data == nullptr ? nullptr : data + i * stride_bytes;
}

std::uint64_t Accessor::element_bytes() const { return component_count * bytes_of(component); }

glm::vec4 Accessor::any_vector_at(std::uint64_t i) const {
  const std::byte* p = element(i, element_bytes());
  return p == nullptr ? glm::vec4(0.0F) : load_vector(p);
}

glm::mat4 Accessor::matrix_at(std::uint64_t i) const {
  glm::mat4 value(0.0F);
  const std::byte* p = element(i, element_bytes());
  if (p != nullptr) std::memcpy(&value[0][0], p, sizeof value);
  return value;
}

std::pair<std::uint64_t, glm::vec4> Accessor::sparse_vector_at(std::uint64_t k) const {
  return {load_index(sparse_indices + k * bytes_of(sparse_index_type), sparse_index_type),
          load_vector(sparse_values + k * element_bytes())};
}

glm::vec4 Accessor::load_vector(const std::byte* p) const {
  glm::vec4 value{0.0F};
  for (std::uint32_t c = 0; c < std::min(component_count, 4U); ++c) {
    value[static_cast<int>(c)] = component_at(p + c * bytes_of(component), component, normalized);
  }
  return value;
}

std::uint32_t Accessor::index_at(std::uint64_t i) const {
  const std::byte* p = element(i, bytes_of(component));
  return p == nullptr ? 0 : load_index(p, component);
}

AccessorTable::AccessorTable(const Json& document, const BufferViews& views, WrongParts& wrong) : wrong_(wrong) {
  const Json& list = items(document, "accessors");
  accessors_.resize(size_of(list));
  for (std::size_t i = 0; i < accessors_.size(); ++i) {
    const JsonView view{.value = element(list, i), .kind = "accessor", .index = static_cast<std::int64_t>(i)};
    if (wrong.has("accessor", i)) continue;
    try {
      accessors_[i] = check_accessor(view, views);
    } catch (const InputError& e) {
      wrong.add(view, e.what());
    }
  }
}

}  // namespace eikon
