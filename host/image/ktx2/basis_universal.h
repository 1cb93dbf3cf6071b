// SPDX-License-Identifier: Apache-2.0
// The two codecs of Basis Universal for 8-bit pictures, in which KTX2 textures of glTF are
// [KHR_texture_basisu]. Both have blocks of 4 x 4 pixels, row by row; those at the right and the
// bottom may reach beyond the picture.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/error.h"

namespace eikon {

/// what: is wrong in the stream
[[nodiscard]] InputError damaged_basis(std::string_view what);

struct BlockPicture {
  std::uint32_t width = 0, height = 0;
  std::uint32_t* rgba8 = nullptr;  // width * height pixels from the top, R in the low byte

  [[nodiscard]] std::uint32_t columns() const { return (width + 3) / 4; }
  [[nodiscard]] std::uint32_t rows() const { return (height + 3) / 4; }
};

/// A picture of codec ETC1S under BasisLZ.
struct Etc1sStreams {
  std::span<const std::byte> global;  // codebooks and codes, for all levels
  std::uint32_t level_count = 1;      // images that `global` describes
  std::span<const std::byte> level;   // the largest
};
void decode_etc1s(const Etc1sStreams& streams, const BlockPicture& picture);

constexpr std::size_t kUastcBlockBytes = 16;
/// blocks: columns() * rows() * kUastcBlockBytes bytes
void decode_uastc(std::span<const std::byte> blocks, const BlockPicture& picture);

}  // namespace eikon
