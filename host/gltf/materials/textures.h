// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "image/decode_picture.h"
#include "gltf/document/buffer_views.h"
#include "io/json_text.h"
#include "io/xxhash64.h"
#include "scene/scene.h"
#include "io/source_file.h"
#include "scene/notes.h"

namespace eikon {

/// The sources of textures, which outlive the reader. The document has been checked.
struct TextureSource {
  const Json& document;
  const BufferViews& views;
  std::filesystem::path folder;  // of the scene: images outside it are refused
  std::uint64_t budget_bytes;    // for all decoded images together
};

/// Half of this machine's memory.
[[nodiscard]] std::uint64_t texture_budget_bytes();

/// Finds the images that materials use, and decodes each of them once. What the images claim is
/// checked against the budget while they are found, before the first is decoded.
class TextureReader {
 public:
  /// Images go to `scene.images`, their files to `digest`.
  TextureReader(const TextureSource& source, Scene& scene, Digest& digest, Notes& notes);

  /// The texture in slot `key` of `owner`, a material or a part of one; nothing if the slot is
  /// empty. Nothing either for a texture without an image, in a format that is not read (KTX2,
  /// WebP, ...) or with a third set of coordinates, each of which is named in the notes.
  /// throws InputError: a URI that may not be followed, a file that cannot be read, a damaged or
  ///        lying header, the budget
  std::optional<Texture> find(const JsonView& owner, const char* key, bool srgb);

  /// Fills the pixels of `scene.images`, on all processors.
  /// throws InputError with the image, in the order of their first use
  void decode();

 private:
  struct Encoded {
    std::string label;  // "image 3 'wood.png'"
    Bytes owned;        // nothing for a bufferView
    std::span<const std::byte> bytes;
    PictureHeader header;
  };
  std::optional<std::size_t> image_of(const JsonView& texture);
  std::optional<std::uint32_t> use_image(std::size_t index);
  std::optional<std::uint32_t> add_image(const JsonView& image, std::string name, Encoded encoded);

  TextureSource source_;
  Scene& scene_;
  Digest& digest_;
  Notes& notes_;
  std::vector<Encoded> encoded_;                                       // as scene_.images, until decoded
  std::vector<std::optional<std::optional<std::uint32_t>>> of_image_;  // outer: not asked yet; inner: cannot be read
  std::map<std::string, std::optional<std::uint32_t>> of_file_;        // several images may name one file or view
  std::uint64_t decoded_bytes_ = 0;
  std::size_t fallback_count_ = 0, deep_count_ = 0;
  std::string first_fallback_, first_deep_;
};

}  // namespace eikon
