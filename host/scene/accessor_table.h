// SPDX-License-Identifier: Apache-2.0
// What the file's accessors give access to, every byte of it checked to lie inside its buffer.
#pragma once
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "scene/json_text.h"
#include "scene/source_file.h"

namespace eikon {

enum class ComponentType : std::uint32_t { i8 = 5120, u8 = 5121, i16 = 5122, u16 = 5123, u32 = 5125, f32 = 5126 };

/// The buffers of a document: the binary chunk, files beside the scene, or base64 inside it.
class Buffers {
 public:
  /// `container` outlives the buffers; base64 text is taken out of `document`.
  /// throws InputError: a URI that may not be followed, a file that cannot be read or is shorter than byteLength
  Buffers(Json& document, const Container& container, const std::filesystem::path& folder);

  [[nodiscard]] std::span<const std::byte> operator[](std::size_t buffer) const { return views_[buffer]; }
  [[nodiscard]] std::size_t size() const { return views_.size(); }
  /// Bytes read from files beside the scene, in the order of the buffers; what the scene's hash has to cover.
  [[nodiscard]] const std::vector<Bytes>& files() const { return files_; }

 private:
  std::vector<Bytes> files_, decoded_;
  std::vector<std::span<const std::byte>> views_;  // exactly byteLength bytes each
};

/// A checked accessor: element i of `count` can be read, whatever the file says.
struct Accessor {
  const std::byte* data = nullptr;  // null: zeros, as glTF has it where there is no bufferView
  std::uint64_t count = 0;          // elements
  std::uint32_t stride_bytes = 0;
  ComponentType component = ComponentType::f32;
  std::uint32_t component_count = 0;  // 1: SCALAR, 3: VEC3, ...
  bool is_matrix = false;
  bool normalized = false;

  // Elements that replace those of `data`; `sparse_indices` ascends strictly and is below `count`.
  std::vector<std::uint32_t> sparse_indices;
  const std::byte* sparse_values = nullptr;  // tightly packed

  std::string label;  // "accessor 3 'positions'"

  [[nodiscard]] bool is(ComponentType type, std::uint32_t components) const {
    return component == type && component_count == components && !is_matrix;
  }
  /// Element i of a VEC3 of f32.
  [[nodiscard]] glm::vec3 vec3_at(std::uint64_t i) const;
  /// Element i of a SCALAR of u8, u16 or u32.
  [[nodiscard]] std::uint32_t index_at(std::uint64_t i) const;

 private:
  [[nodiscard]] const std::byte* element(std::uint64_t i, std::size_t bytes) const;
};

/// Checks all bufferViews and accessors of a checked document against the buffers.
/// throws InputError with the accessor or bufferView and the numbers that do not fit
std::vector<Accessor> check_accessors(const Json& document, const Buffers& buffers);

}  // namespace eikon
