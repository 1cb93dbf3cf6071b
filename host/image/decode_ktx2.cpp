// SPDX-License-Identifier: Apache-2.0
// KTX2 [KTX File Format Specification 2.0]. Plain RGB and RGBA of 8 bits are read here; Basis
// Universal and Zstandard by libktx of KTX-Software, which is loaded where it is installed. eikon
// neither needs nor ships it.
#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <optional>
#include <string>

#include "core/error.h"
#include "image/decode_picture.h"

namespace eikon {
namespace {

constexpr std::array<const char*, 2> kUsualNames{"libktx.so.4", "libktx.so"};

// Values of VkFormat and of the header's supercompressionScheme.
constexpr std::uint32_t kUndefined = 0, kRgb8 = 23, kRgb8Srgb = 29, kRgba8 = 37, kRgba8Srgb = 43;
constexpr std::uint32_t kNoScheme = 0, kBasisLz = 1, kZstandard = 2;

constexpr std::size_t kKtxHeaderBytes = 104;  // with the place of the first level

template <typename T>
T little_endian(std::span<const std::byte> bytes, std::size_t at) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= static_cast<T>(std::to_integer<T>(bytes[at + i]) << (8 * i));
  return value;
}

/// Bytes of a texel of a format that is read without transcoding, or 0.
std::uint32_t texel_bytes(std::uint32_t format) {
  if (format == kRgb8 || format == kRgb8Srgb) return 3;
  return format == kRgba8 || format == kRgba8Srgb ? 4 : 0;
}

std::uint32_t format_of(std::span<const std::byte> bytes) { return little_endian<std::uint32_t>(bytes, 12); }

// The part of libktx's C interface that is needed. Its header calls methods through a table of
// functions at the beginning of a texture, so these two structs are part of the interface.
struct KtxTexture;
struct KtxMethods {
  void (*destroy)(KtxTexture*);
  int (*image_offset)(KtxTexture*, std::uint32_t level, std::uint32_t layer, std::uint32_t face, std::size_t* offset);
};
struct KtxTexture {
  int version;
  const KtxMethods* methods;
};
constexpr int kKtxSuccess = 0, kKtxRgba32 = 13;
constexpr std::uint32_t kKtxLoadImageData = 1;

struct KtxLibrary {
  int (*create)(const std::uint8_t* bytes, std::size_t size, std::uint32_t flags, KtxTexture** texture) = nullptr;
  bool (*needs_transcoding)(KtxTexture*) = nullptr;
  int (*transcode)(KtxTexture*, int format, std::uint32_t flags) = nullptr;
  std::uint8_t* (*data)(KtxTexture*) = nullptr;
  std::size_t (*data_size)(KtxTexture*) = nullptr;
  const char* (*error_string)(int code) = nullptr;
};

/// Loads the library: the file $EIKON_KTX, else the one that the system's loader finds. It stays
/// loaded, because more pictures follow.
/// problem  gets the reason where it returns nothing
std::optional<KtxLibrary> load_library(std::string& problem) {
  const char* const named = std::getenv("EIKON_KTX");
  void* handle = nullptr;
  if (named != nullptr && *named != '\0') {
    handle = dlopen(named, RTLD_NOW | RTLD_LOCAL);
  } else {
    for (const char* name : kUsualNames)
      if (handle == nullptr) handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
  }
  if (handle == nullptr) {
    const char* const why = dlerror();
    problem = why != nullptr ? why : "it cannot be loaded";
    return std::nullopt;
  }
  KtxLibrary library;
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::decay_t<decltype(function)>>(dlsym(handle, name));
    if (function == nullptr && problem.empty())
      problem = fmt::format("{} is not libktx: it has no {}", named != nullptr ? named : kUsualNames[0], name);
  };
  find(library.create, "ktxTexture2_CreateFromMemory");
  find(library.needs_transcoding, "ktxTexture2_NeedsTranscoding");
  find(library.transcode, "ktxTexture2_TranscodeBasis");
  find(library.data, "ktxTexture_GetData");
  find(library.data_size, "ktxTexture_GetDataSize");
  find(library.error_string, "ktxErrorString");
  if (problem.empty()) return library;
  dlclose(handle);
  return std::nullopt;
}

void expand(const std::uint8_t* texels, std::size_t count, std::uint32_t bytes_per_texel, std::uint32_t* rgba8) {
  for (std::size_t i = 0; i < count; ++i, texels += bytes_per_texel)
    rgba8[i] = texels[0] | static_cast<std::uint32_t>(texels[1]) << 8U | static_cast<std::uint32_t>(texels[2]) << 16U |
               (bytes_per_texel == 4 ? static_cast<std::uint32_t>(texels[3]) : 255U) << 24U;
}

void decode_by_library(std::span<const std::byte> bytes, std::size_t pixel_count, std::uint32_t* rgba8) {
  std::string problem;
  const std::optional<KtxLibrary> ktx = load_library(problem);
  if (!ktx) throw InputError("needs libktx: " + problem);
  const auto check = [&](int code) {
    if (code != kKtxSuccess)
      throw InputError(fmt::format("is a damaged KTX2 (libktx: {}); copy or export it again", ktx->error_string(code)));
  };
  // The first transcoding fills tables that all share, so threads take turns.
  static std::mutex turn;
  const std::scoped_lock lock(turn);
  struct Owner {
    KtxTexture* texture = nullptr;
    ~Owner() {
      if (texture != nullptr) texture->methods->destroy(texture);
    }
  } owner;
  check(ktx->create(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), kKtxLoadImageData,
                    &owner.texture));
  std::uint32_t bytes_per_texel = texel_bytes(format_of(bytes));
  if (ktx->needs_transcoding(owner.texture)) {
    check(ktx->transcode(owner.texture, kKtxRgba32, 0));
    bytes_per_texel = 4;
  }
  std::size_t offset = 0;
  check(owner.texture->methods->image_offset(owner.texture, 0, 0, 0, &offset));
  const std::size_t size = ktx->data_size(owner.texture), needed = pixel_count * bytes_per_texel;
  if (bytes_per_texel == 0 || offset > size || size - offset < needed)
    throw InputError("is a KTX2 with fewer pixels than its header says: damaged");
  expand(ktx->data(owner.texture) + offset, pixel_count, bytes_per_texel, rgba8);
}

}  // namespace

std::string ktx_library_problem() {
  std::string problem;
  load_library(problem);
  return problem;
}

PictureHeader ktx2_header(std::span<const std::byte> bytes) {
  if (bytes.size() < kKtxHeaderBytes) throw InputError("is a KTX2 without a whole header: truncated? Copy it again");
  const auto word = [&](std::size_t at) { return little_endian<std::uint32_t>(bytes, at); };
  PictureHeader header{.format = PictureFormat::ktx2, .width = word(20), .height = word(24)};
  const std::uint32_t format = word(12), scheme = word(44);
  if (header.width == 0 || header.height == 0) throw InputError("is a KTX2 of less than two dimensions: not a picture");
  if (word(28) > 1 || word(32) > 1 || word(36) > 1)
    throw InputError("is a KTX2 with several layers, faces or depths; save one picture of it (`ktx extract`)");
  if (scheme > kZstandard || (format != kUndefined && texel_bytes(format) == 0) ||
      (scheme == kBasisLz && format != kUndefined))
    throw InputError(fmt::format(
        "is a KTX2 of VkFormat {} and supercompression {}, not Basis Universal or 8-bit RGB; convert it to PNG", format,
        scheme));
  header.needs_library = format == kUndefined || scheme != kNoScheme;
  const std::uint64_t pixels = std::uint64_t{header.width} * header.height;
  if (header.needs_library) {
    // libktx keeps the blocks and all levels, which are a third more than the largest.
    header.scratch_bytes = pixels * 7;
    return header;
  }
  const auto offset = little_endian<std::uint64_t>(bytes, 80), length = little_endian<std::uint64_t>(bytes, 88);
  if (offset > bytes.size() || length > bytes.size() - offset || pixels * texel_bytes(format) > length)
    throw InputError(
        fmt::format("its header claims {} x {} pixels, which its {} bytes do not hold: truncated or damaged",
                    header.width, header.height, bytes.size()));
  return header;
}

void decode_ktx2(std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8) {
  const std::size_t pixel_count = std::size_t{header.width} * header.height;
  if (header.needs_library) {
    decode_by_library(bytes, pixel_count, rgba8);
  } else {
    const auto offset = little_endian<std::uint64_t>(bytes, 80);
    expand(reinterpret_cast<const std::uint8_t*>(bytes.data()) + offset, pixel_count, texel_bytes(format_of(bytes)),
           rgba8);
  }
}

}  // namespace eikon
