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
#include "gltf/document/wrong_parts.h"
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
  const WrongParts* wrong = nullptr;  // null: every part has passed its check
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
  /// empty. Nothing either for a texture without an image, in a format that is not read (AVIF,
  /// DDS, ...) or with a third set of coordinates, each of which is named in the notes. An image
  /// that an extension names comes first, and the texture's own if that one cannot be read.
  /// throws InputError: a URI that may not be followed, a file that cannot be read, a damaged or
  ///        lying header, the budget
  std::optional<Texture> find(const JsonView& owner, const char* key, bool srgb);

  /// A texture whose G is 1 - glossiness x A of `glossy`, which find() has returned: an image made
  /// from its image by decode(). throws InputError: the budget
  Texture roughness_of(const Texture& glossy, float glossiness);

  /// Fills the pixels of `scene.images`, on all processors. Where those of an image that an
  /// extension names are damaged, and the texture has an image of its own, they become that one's,
  /// which is noted. throws InputError with the image, in the order of their first use
  void decode();

 private:
  struct Encoded {
    std::string label;  // "image 3 'wood.png'"
    std::string source;  // the same for the same bytes of the file
    Bytes owned;        // nothing for a bufferView
    std::span<const std::byte> bytes;
    PictureHeader header;
  };
  /// An image of the document as an index into scene_.images, or the feature that it needs.
  struct Use {
    std::optional<std::uint32_t> image{};
    std::string missing{};
  };
  /// The image that takes the place of one that an extension names.
  struct Fallback {
    std::size_t image = 0;  // of the document
    std::string user;       // "texture 0: EXT_texture_webp"
  };
  struct Roughness {
    std::uint32_t image = 0, glossy = 0;  // indices into scene_.images
    float glossiness = 1.0F;
  };
  void check_part(const char* kind, std::size_t index) const;
  std::optional<std::uint32_t> image_of(const JsonView& texture);
  std::optional<std::uint32_t> image_of_extension(const JsonView& texture, const char* name);
  const Use& use_image(std::size_t index);
  Use add_image(std::string name, Encoded encoded);
  void take_memory(std::uint64_t pixels, std::uint64_t scratch_bytes);
  void give_back_memory(const TextureImage& image);
  void say_fallback(const std::string& user, const std::string& why);
  /// Decodes the images from index `first` on. Returns for each what is damaged of it, or nothing.
  std::vector<std::string> decode_images(std::size_t first);
  void replace_damaged(const std::vector<std::string>& damages);
  std::uint32_t add_fallback(std::uint32_t damaged, const std::string& damage);
  void make_roughness();

  TextureSource source_;
  Scene& scene_;
  Digest& digest_;
  Notes& notes_;
  std::vector<Encoded> encoded_;  // as scene_.images, until decoded; nothing for roughness
  std::vector<Roughness> roughness_;
  std::map<std::uint32_t, Fallback> fallbacks_;  // by index into scene_.images; that of the first texture
  std::vector<std::optional<Use>> of_image_;  // nothing: not asked yet
  std::map<std::string, Use> of_file_;        // several images may name one file or view
  std::uint64_t decoded_bytes_ = 0, largest_scratch_bytes_ = 0;  // together within the budget
  std::size_t fallback_count_ = 0, deep_count_ = 0;
  std::string first_fallback_, first_deep_;
};

}  // namespace eikon
