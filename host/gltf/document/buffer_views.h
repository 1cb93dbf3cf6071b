// SPDX-License-Identifier: Apache-2.0
// The bytes of a document: its buffers, and the parts of them that accessors and images name.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "gltf/document/wrong_parts.h"
#include "io/json_text.h"
#include "io/source_file.h"

namespace eikon {

struct MeshoptView;

/// Sizes and offsets of a file stay below this, so that sums of them fit in 64 bits.
inline constexpr std::uint64_t kMaxFileOffset = std::uint64_t{1} << 48U;

/// The buffers of a document: the binary chunk, files beside the scene, or base64 inside it. One
/// without any of these is empty; it may stand in for compressed data (EXT_meshopt_compression).
class Buffers {
 public:
  /// `container` outlives the buffers; base64 text is taken out of `document`.
  /// throws InputError: a URI that may not be followed, a file that cannot be read or is shorter
  ///        than byteLength
  Buffers(Json& document, const Container& container, const std::filesystem::path& folder);

  [[nodiscard]] std::span<const std::byte> operator[](std::size_t buffer) const { return views_[buffer]; }
  [[nodiscard]] std::size_t size() const { return views_.size(); }
  /// False for a buffer that has a length but no bytes.
  [[nodiscard]] bool has_bytes(std::size_t buffer) const { return views_[buffer].data() != nullptr; }
  /// The bytes of files beside the scene, in the order of the buffers. The scene's hash covers
  /// them.
  [[nodiscard]] const std::vector<Bytes>& files() const { return files_; }

 private:
  std::vector<Bytes> files_, decoded_;
  std::vector<std::span<const std::byte>> views_;  // byteLength bytes each, or none
};

/// The bufferViews of a checked document. Those that accessors use are decompressed
/// (EXT_meshopt_compression, KHR_meshopt_compression).
class BufferViews {
 public:
  /// The arguments outlive the views. A view of a buffer without bytes is added to `wrong`.
  /// throws InputError with the bufferView: outside its buffer, an illegal stride, compressed data
  ///        that do not decode
  BufferViews(const Json& document, const Buffers& buffers, WrongParts& wrong, Notes& notes);

  /// throws InputError if its buffer has no bytes
  [[nodiscard]] std::span<const std::byte> operator[](std::size_t view) const {
    wrong_.check("bufferView", view);
    return views_[view].bytes;
  }
  [[nodiscard]] std::uint32_t stride_bytes(std::size_t view) const { return views_[view].stride_bytes; }  // 0: packed
  [[nodiscard]] std::size_t size() const { return views_.size(); }
  /// Bytes of all buffers together.
  [[nodiscard]] std::uint64_t file_bytes() const { return file_bytes_; }
  /// Bytes of the views that were decompressed, before and after.
  [[nodiscard]] std::uint64_t compressed_bytes() const { return compressed_bytes_; }
  [[nodiscard]] std::uint64_t decompressed_bytes() const { return decompressed_bytes_; }

 private:
  struct View {
    std::span<const std::byte> bytes;
    std::uint32_t stride_bytes = 0;
  };
  std::span<const std::byte> decompress(const JsonView& compression, const MeshoptView& source);

  std::vector<View> views_;
  std::vector<Bytes> decompressed_;
  std::uint64_t file_bytes_ = 0, compressed_bytes_ = 0, decompressed_bytes_ = 0;
  const WrongParts& wrong_;
};

}  // namespace eikon
