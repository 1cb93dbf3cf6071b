// SPDX-License-Identifier: Apache-2.0
// KTX2 [KTX File Format Specification 2.0]: RGB and RGBA of 8 bits, and Basis Universal; all but
// ETC1S may be packed by Zstandard.
#include <fmt/format.h>
#include <zstd.h>

#include <string>
#include <vector>

#include "core/error.h"
#include "image/decode_picture.h"
#include "image/ktx2/basis_universal.h"

namespace eikon {
namespace {

// Values of VkFormat, of the header's supercompressionScheme, and of the colour models that
// describe a format.
constexpr std::uint32_t kUndefined = 0, kRgb8 = 23, kRgb8Srgb = 29, kRgba8 = 37, kRgba8Srgb = 43;
constexpr std::uint32_t kNoScheme = 0, kBasisLz = 1, kZstandard = 2;
constexpr std::uint32_t kEtc1sModel = 163, kUastcModel = 166;

constexpr std::size_t kKtxHeaderBytes = 104;  // with the place of the first level
constexpr std::size_t kModelOffset = 12;      // of the colour model in the format's description

using Bytes = std::span<const std::byte>;

template <typename T>
T little_endian(Bytes bytes, std::size_t at) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= static_cast<T>(std::to_integer<T>(bytes[at + i]) << (8 * i));
  return value;
}

/// The part of a file that its header has the place of.
Bytes part(Bytes bytes, std::uint64_t offset, std::uint64_t length) {
  if (offset > bytes.size() || length > bytes.size() - offset)
    throw InputError(fmt::format("is a KTX2 with a part beyond its {} bytes: truncated or damaged", bytes.size()));
  return bytes.subspan(offset, length);
}

enum class Codec { plain, etc1s, uastc };

struct Ktx2 {
  std::uint32_t width, height, levels;
  Codec codec;
  std::uint32_t texel_bytes;  // of plain pixels
  bool packed;                // by Zstandard
  Bytes level;                // the largest
  std::uint64_t level_bytes;  // of it, unpacked
  Bytes global;               // what all levels of BasisLZ share
};

std::uint32_t texel_bytes_of(std::uint32_t format) {
  if (format == kRgb8 || format == kRgb8Srgb) return 3;
  return format == kRgba8 || format == kRgba8Srgb ? 4 : 0;
}

/// throws InputError: a codec that is not read
Codec codec_of(Bytes bytes, std::uint32_t format, std::uint32_t scheme) {
  if (texel_bytes_of(format) > 0 && (scheme == kNoScheme || scheme == kZstandard)) return Codec::plain;
  std::string found = fmt::format("VkFormat {}", format);
  if (format == kUndefined) {
    const Bytes description =
        part(bytes, little_endian<std::uint32_t>(bytes, 48), little_endian<std::uint32_t>(bytes, 52));
    const std::uint32_t model =
        description.size() > kModelOffset ? std::to_integer<std::uint32_t>(description[kModelOffset]) : 0;
    if (model == kEtc1sModel && scheme == kBasisLz) return Codec::etc1s;
    if (model == kUastcModel && (scheme == kNoScheme || scheme == kZstandard)) return Codec::uastc;
    found = fmt::format("colour model {}", model);
  }
  throw InputError(fmt::format(
      "is a KTX2 of {} and supercompression {}, not ETC1S, UASTC or 8-bit RGB; convert it to PNG", found, scheme));
}

std::uint64_t unpacked_bytes(const Ktx2& ktx) {
  if (ktx.codec == Codec::plain) return std::uint64_t{ktx.width} * ktx.height * ktx.texel_bytes;
  return ((std::uint64_t{ktx.width} + 3) / 4) * ((std::uint64_t{ktx.height} + 3) / 4) * kUastcBlockBytes;
}

Ktx2 read_ktx2(Bytes bytes) {
  if (bytes.size() < kKtxHeaderBytes) throw InputError("is a KTX2 without a whole header: truncated? Copy it again");
  const auto word = [&](std::size_t at) { return little_endian<std::uint32_t>(bytes, at); };
  const auto place = [&](std::size_t at) {
    return part(bytes, little_endian<std::uint64_t>(bytes, at), little_endian<std::uint64_t>(bytes, at + 8));
  };
  Ktx2 ktx{};
  ktx.width = word(20);
  ktx.height = word(24);
  ktx.levels = word(40) == 0 ? 1 : word(40);  // 0: whoever reads the file shall make smaller ones
  if (ktx.width == 0 || ktx.height == 0) throw InputError("is a KTX2 of less than two dimensions: not a picture");
  if (word(28) > 1 || word(32) > 1 || word(36) > 1)
    throw InputError("is a KTX2 with several layers, faces or depths; save one picture of it (`ktx extract`)");
  ktx.codec = codec_of(bytes, word(12), word(44));
  ktx.texel_bytes = texel_bytes_of(word(12));
  ktx.packed = word(44) == kZstandard;
  ktx.level = place(80);
  if (ktx.codec == Codec::etc1s) {
    ktx.global = place(64);
    return ktx;
  }
  ktx.level_bytes = unpacked_bytes(ktx);
  const std::uint64_t held = ktx.packed ? little_endian<std::uint64_t>(bytes, 96) : ktx.level.size();
  if (held < ktx.level_bytes)
    throw InputError(
        fmt::format("its header claims {} x {} pixels, which its {} bytes do not hold: truncated or damaged", ktx.width,
                    ktx.height, bytes.size()));
  return ktx;
}

std::vector<std::byte> unpack(const Ktx2& ktx) {
  std::vector<std::byte> out(ktx.level_bytes);
  const std::size_t found = ZSTD_decompress(out.data(), out.size(), ktx.level.data(), ktx.level.size());
  if (ZSTD_isError(found) != 0)
    throw InputError(
        fmt::format("is a damaged KTX2 (Zstandard: {}); copy or export it again", ZSTD_getErrorName(found)));
  if (found < out.size()) throw InputError("is a KTX2 whose pixels end early: damaged; copy or export it again");
  return out;
}

void expand(Bytes texels, std::uint32_t bytes_per_texel, const BlockPicture& picture) {
  const auto* from = reinterpret_cast<const std::uint8_t*>(texels.data());
  const std::size_t count = std::size_t{picture.width} * picture.height;
  for (std::size_t i = 0; i < count; ++i, from += bytes_per_texel)
    picture.rgba8[i] = from[0] | static_cast<std::uint32_t>(from[1]) << 8U |
                       static_cast<std::uint32_t>(from[2]) << 16U |
                       (bytes_per_texel == 4 ? static_cast<std::uint32_t>(from[3]) : 255U) << 24U;
}

}  // namespace

InputError damaged_basis(std::string_view what) {
  return InputError(fmt::format("is a damaged KTX2 (Basis Universal: {}); copy or export it again", what));
}

PictureHeader ktx2_header(std::span<const std::byte> bytes) {
  const Ktx2 ktx = read_ktx2(bytes);
  return {.format = PictureFormat::ktx2,
          .width = ktx.width,
          .height = ktx.height,
          .scratch_bytes = ktx.packed ? ktx.level_bytes : 0};
}

void decode_ktx2(std::span<const std::byte> bytes, const PictureHeader& header, std::uint32_t* rgba8) {
  const Ktx2 ktx = read_ktx2(bytes);
  const BlockPicture picture{.width = header.width, .height = header.height, .rgba8 = rgba8};
  if (ktx.codec == Codec::etc1s) {
    decode_etc1s({.global = ktx.global, .level_count = ktx.levels, .level = ktx.level}, picture);
    return;
  }
  const std::vector<std::byte> unpacked = ktx.packed ? unpack(ktx) : std::vector<std::byte>();
  const Bytes level = ktx.packed ? Bytes(unpacked) : ktx.level;
  if (ktx.codec == Codec::uastc) {
    decode_uastc(level, picture);
  } else {
    expand(level, ktx.texel_bytes, picture);
  }
}

}  // namespace eikon
