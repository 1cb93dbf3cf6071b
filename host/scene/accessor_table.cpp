// SPDX-License-Identifier: Apache-2.0
#include "scene/accessor_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"
#include "scene/document_check.h"
#include "scene/text.h"

namespace eikon {
namespace {

// Sizes of files stay below 2^48, and counts times strides below 2^32 * 2^8: sums and products fit in 64 bits.
constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 48U;
constexpr std::uint64_t kMaxCount = 0xFFFFFFFFU;
// Elements of an accessor with nothing behind it cost the file nothing, so their number needs a bound of its own.
constexpr std::uint64_t kMaxZeroCount = std::uint64_t{1} << 24U;

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

ComponentType component_type(const Place& place) {
  const std::uint64_t value = required_integer(place, "componentType", kMaxCount);
  switch (static_cast<ComponentType>(value)) {
    case ComponentType::i8:
    case ComponentType::u8:
    case ComponentType::i16:
    case ComponentType::u16:
    case ComponentType::u32:
    case ComponentType::f32:
      return static_cast<ComponentType>(value);
  }
  place.fail(fmt::format("'componentType' {} is none of 5120, 5121, 5122, 5123, 5125, 5126", value));
}

struct View {
  std::span<const std::byte> bytes;
  std::uint32_t stride_bytes = 0;  // 0: packed
};

View check_view(const Place& place, const Buffers& buffers) {
  const auto buffer = required_integer(place, "buffer", buffers.size() - 1);
  const std::uint64_t offset = as_integer(place, "byteOffset", kMaxBytes).value_or(0),
                      length = required_integer(place, "byteLength", kMaxBytes),
                      stride = as_integer(place, "byteStride", 252).value_or(0);
  const std::span<const std::byte> bytes = buffers[buffer];
  if (offset > bytes.size() || length > bytes.size() - offset) {
    place.fail(
        fmt::format("bytes {} to {} are outside buffer {} of {} bytes", offset, offset + length, buffer, bytes.size()));
  }
  if (stride != 0 && (stride < 4 || stride % 4 != 0)) {
    place.fail(fmt::format("'byteStride' {} is not a multiple of 4 from 4 to 252", stride));
  }
  return {.bytes = bytes.subspan(offset, length), .stride_bytes = static_cast<std::uint32_t>(stride)};
}

// First of `count` elements in a bufferView. `element_bytes` <= 64, so nothing wraps.
const std::byte* check_range(const Place& place, const View& view, std::uint64_t count, std::uint64_t stride,
                             std::uint64_t element_bytes) {
  const std::uint64_t offset = as_integer(place, "byteOffset", kMaxBytes).value_or(0);
  const std::uint64_t needed = count == 0 ? 0 : (count - 1) * stride + element_bytes;
  if (offset > view.bytes.size() || needed > view.bytes.size() - offset) {
    place.fail(fmt::format("{} elements need bytes {} to {} of a bufferView of {} bytes", count, offset,
                           offset + needed, view.bytes.size()));
  }
  return view.bytes.data() + offset;
}

std::uint32_t load_index(const std::byte* p, ComponentType type) {
  std::uint32_t value = 0;  // little-endian, unaligned
  for (std::uint32_t i = 0; i < bytes_of(type); ++i) value |= std::to_integer<std::uint32_t>(p[i]) << (8 * i);
  return value;
}

bool is_index_type(ComponentType type) {
  return type == ComponentType::u8 || type == ComponentType::u16 || type == ComponentType::u32;
}

const View& required_view(const Place& place, const std::vector<View>& views) {
  const auto index = as_index(place, "bufferView", views.size(), "bufferView");
  if (!index) place.fail("'bufferView' is missing");
  return views[*index];
}

void check_sparse(const Place& place, const std::vector<View>& views, std::uint64_t element_bytes, Accessor& accessor) {
  const Json* sparse_json = as_object(place, "sparse");
  if (sparse_json == nullptr) return;
  const Place sparse{.value = *sparse_json, .kind = "sparse", .parent = &place};
  const std::uint64_t count = required_integer(sparse, "count", accessor.count);
  const Json *indices_json = as_object(sparse, "indices"), *values_json = as_object(sparse, "values");
  if (indices_json == nullptr || values_json == nullptr) sparse.fail("'indices' or 'values' is missing");

  const Place indices{.value = *indices_json, .kind = "indices", .parent = &sparse};
  const ComponentType type = component_type(indices);
  if (!is_index_type(type)) indices.fail("indices are not unsigned integers");
  const std::byte* p = check_range(indices, required_view(indices, views), count, bytes_of(type), bytes_of(type));
  accessor.sparse_indices.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint32_t index = load_index(p + i * bytes_of(type), type);
    if (index >= accessor.count || (i > 0 && index <= accessor.sparse_indices.back())) {
      indices.fail(fmt::format("element {} is {}: not ascending or not below {}", i, index, accessor.count));
    }
    accessor.sparse_indices.push_back(index);
  }
  const Place values{.value = *values_json, .kind = "values", .parent = &sparse};
  accessor.sparse_values = check_range(values, required_view(values, views), count, element_bytes, element_bytes);
}

Accessor check_accessor(const Place& place, const std::vector<View>& views) {
  Accessor accessor;
  accessor.label = fmt::format("accessor {}", place.index);
  if (const Json* name = member(place.value, "name")) {
    accessor.label += fmt::format(" {}", in_quotes(name->get_ref<const std::string&>()));
  }
  accessor.component = component_type(place);
  accessor.count = required_integer(place, "count", kMaxCount);
  if (const Json* normalized = member(place.value, "normalized")) {
    if (!normalized->is_boolean()) place.fail("'normalized' is neither true nor false");
    accessor.normalized = normalized->get<bool>();
  }
  const Json* type_name = member(place.value, "type");
  const auto type = std::find_if(kElementTypes.begin(), kElementTypes.end(),
                                 [&](const ElementType& t) { return type_name != nullptr && *type_name == t.name; });
  if (type == kElementTypes.end()) place.fail("'type' is none of SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3, MAT4");
  accessor.component_count = type->columns * type->rows;
  accessor.is_matrix = type->columns > 1;

  // Columns of matrices begin at multiples of 4 bytes [glTF 2.0, section 3.6.2.4].
  std::uint32_t column_bytes = type->rows * bytes_of(accessor.component);
  if (accessor.is_matrix) column_bytes = (column_bytes + 3) / 4 * 4;
  const std::uint32_t element_bytes = type->columns * column_bytes;
  accessor.stride_bytes = element_bytes;
  if (const auto view_index = as_index(place, "bufferView", views.size(), "bufferView")) {
    const View& view = views[*view_index];
    if (view.stride_bytes != 0) accessor.stride_bytes = view.stride_bytes;
    if (accessor.stride_bytes < element_bytes) {
      place.fail(fmt::format("elements of {} bytes overlap: 'byteStride' of its bufferView is {}", element_bytes,
                             accessor.stride_bytes));
    }
    accessor.data = check_range(place, view, accessor.count, accessor.stride_bytes, element_bytes);
  } else if (accessor.count > kMaxZeroCount) {
    place.refuse(fmt::format("{} elements of zeros without a bufferView, at most {} are read; give it one",
                             accessor.count, kMaxZeroCount));
  }
  check_sparse(place, views, element_bytes, accessor);
  return accessor;
}

}  // namespace

Buffers::Buffers(Json& document, const Container& container, const std::filesystem::path& folder) {
  if (items(document, "buffers").empty()) return;
  const std::uint64_t memory = physical_memory_bytes();
  std::uint64_t total = 0;
  Json& list = document["buffers"];
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Place place{.value = list[i], .kind = "buffer", .index = static_cast<std::int64_t>(i)};
    const std::uint64_t length = required_integer(place, "byteLength", kMaxBytes);
    std::span<const std::byte> bytes;
    try {
      if (auto uri = list[i].find("uri"); uri == list[i].end()) {
        if (i != 0 || !container.has_binary)
          throw InputError("has neither a URI nor the binary chunk of a .glb; export the file again");
        bytes = container.binary;
      } else if (auto& text = uri->get_ref<std::string&>(); text.starts_with("data:")) {
        decoded_.push_back(decode_data_uri(text));
        text = std::string();
        bytes = decoded_.back().span();
      } else {
        const std::filesystem::path file = resolve_uri(folder, text);
        try {
          files_.push_back(read_regular_file(file, kMaxBytes));
        } catch (const InputError& e) {
          throw InputError(fmt::format("file {} {}", in_quotes(text), e.what()));
        }
        bytes = files_.back().span();
        total += bytes.size();
        if (memory != 0 && total > memory)
          throw InputError(fmt::format("the files add up to more than the memory, {} bytes", memory));
      }
    } catch (const InputError& e) {
      place.refuse(e.what());
    }
    if (length > bytes.size()) {
      place.refuse(fmt::format("'byteLength' is {}, but there are only {} bytes; truncated? Copy the file again",
                               length, bytes.size()));
    }
    views_.push_back(bytes.first(length));
  }
}

const std::byte* Accessor::element(std::uint64_t i, std::size_t bytes) const {
  if (!sparse_indices.empty()) {
    const auto found = std::lower_bound(sparse_indices.begin(), sparse_indices.end(), i);
    if (found != sparse_indices.end() && *found == i) {
      return sparse_values + static_cast<std::size_t>(found - sparse_indices.begin()) * bytes;
    }
  }
  return data == nullptr ? nullptr : data + i * stride_bytes;
}

glm::vec3 Accessor::vec3_at(std::uint64_t i) const {
  std::array<float, 3> value{};
  if (const std::byte* p = element(i, sizeof value)) std::memcpy(value.data(), p, sizeof value);
  return {value[0], value[1], value[2]};
}

std::uint32_t Accessor::index_at(std::uint64_t i) const {
  const std::byte* p = element(i, bytes_of(component));
  return p == nullptr ? 0 : load_index(p, component);
}

std::vector<Accessor> check_accessors(const Json& document, const Buffers& buffers) {
  std::vector<View> views;
  const Json& view_list = items(document, "bufferViews");
  views.reserve(view_list.size());
  for (std::size_t i = 0; i < view_list.size(); ++i) {
    views.push_back(
        check_view({.value = view_list[i], .kind = "bufferView", .index = static_cast<std::int64_t>(i)}, buffers));
  }
  std::vector<Accessor> accessors;
  const Json& accessor_list = items(document, "accessors");
  accessors.reserve(accessor_list.size());
  for (std::size_t i = 0; i < accessor_list.size(); ++i) {
    accessors.push_back(
        check_accessor({.value = accessor_list[i], .kind = "accessor", .index = static_cast<std::int64_t>(i)}, views));
  }
  return accessors;
}

}  // namespace eikon
