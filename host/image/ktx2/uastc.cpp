// SPDX-License-Identifier: Apache-2.0
// UASTC, whose blocks of 128 bits are those of ASTC in 19 fixed modes [Basis Universal, "UASTC
// Texture Specification"; Khronos Data Format Specification, "ASTC Compressed Texture Image
// Formats"].
#include <algorithm>
#include <array>

#include "image/ktx2/basis_universal.h"

namespace eikon {
namespace {

struct Mode {
  std::uint32_t prefix, prefix_bits;  // that the block begins with, from the lowest bit
  std::uint32_t hint_bits;            // for transcoders to other formats
  std::uint32_t subsets, planes, components;
  std::uint32_t bits, base;  // of an endpoint: one of base * 2^bits values
  std::uint32_t weight_bits;
};
constexpr std::array<Mode, 19> kModes{{{0x1, 4, 15, 1, 1, 3, 6, 3, 4},
                                       {0x35, 6, 15, 1, 1, 3, 8, 1, 2},
                                       {0x1D, 5, 15, 2, 1, 3, 4, 1, 3},
                                       {0x3, 5, 15, 3, 1, 3, 2, 3, 2},
                                       {0x13, 5, 15, 2, 1, 3, 3, 5, 2},
                                       {0xB, 5, 15, 1, 1, 3, 8, 1, 3},
                                       {0x1B, 5, 15, 1, 2, 3, 5, 5, 2},
                                       {0x7, 5, 15, 2, 1, 3, 3, 5, 2},
                                       {0x17, 5, 0, 1, 1, 4, 8, 1, 0},
                                       {0xF, 5, 23, 2, 1, 4, 4, 1, 2},
                                       {0x2, 3, 17, 1, 1, 4, 4, 3, 4},
                                       {0x0, 2, 17, 1, 2, 4, 4, 3, 2},
                                       {0x6, 3, 17, 1, 1, 4, 6, 3, 3},
                                       {0x1F, 5, 23, 1, 2, 4, 8, 1, 1},
                                       {0xD, 5, 23, 1, 1, 4, 8, 1, 2},
                                       {0x5, 7, 23, 1, 1, 2, 8, 1, 4},
                                       {0x15, 6, 23, 2, 1, 2, 8, 1, 2},
                                       {0x25, 6, 23, 1, 2, 2, 8, 1, 2},
                                       {0x9, 4, 15, 1, 1, 3, 5, 1, 5}}};
constexpr std::size_t kSolid = 8;        // one colour for all pixels
constexpr std::size_t kOthersOfTwo = 7;  // has two subsets, of patterns of its own

// Seeds of the patterns of subsets that BC7 has, too.
constexpr std::array<std::uint32_t, 30> kSeedsOfTwo{28,  20,  16,  29,  91,  9,   107, 72,  149, 204,
                                                    50,  114, 496, 17,  78,  39,  252, 828, 43,  156,
                                                    116, 210, 476, 273, 684, 359, 246, 195, 694, 524};
constexpr std::array<std::uint32_t, 19> kOtherSeedsOfTwo{36,  48,  61,  137, 161, 183, 226, 281, 302, 307,
                                                         479, 495, 593, 594, 605, 799, 812, 988, 993};
constexpr std::array<std::uint32_t, 11> kSeedsOfThree{260, 74, 32, 156, 183, 15, 745, 0, 335, 902, 254};

class Block {
 public:
  explicit Block(std::span<const std::byte> bytes) {
    for (std::size_t i = 0; i < kUastcBlockBytes; ++i)
      halves_[i / 8] |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * (i % 8));
  }
  /// The next bits, at most 8.
  std::uint32_t take(std::uint32_t count) {
    const std::uint32_t value = peek() & ((1U << count) - 1U);
    position_ += count;
    return value;
  }
  [[nodiscard]] std::uint32_t peek() const {
    const std::size_t half = position_ / 64, shift = position_ % 64;
    std::uint64_t word = halves_[half] >> shift;
    if (shift > 0 && half == 0) word |= halves_[1] << (64 - shift);
    return static_cast<std::uint32_t>(word);
  }
  void skip(std::uint32_t count) { position_ += count; }

 private:
  std::array<std::uint64_t, 2> halves_{};
  std::uint32_t position_ = 0;  // below 128: all modes end there
};

/// The subset of each pixel.
using Pattern = std::array<std::uint8_t, 16>;

constexpr std::uint32_t hash52(std::uint32_t p) {
  p ^= p >> 15U;
  p -= p << 17U;
  p += p << 7U;
  p += p << 4U;
  p ^= p >> 5U;
  p += p << 16U;
  p ^= p >> 7U;
  p ^= p >> 3U;
  p ^= p << 6U;
  return p ^ p >> 17U;
}

/// [ASTC, "Partition Pattern Generation"], of a small block of two dimensions.
constexpr Pattern pattern_of(std::uint32_t seed, std::uint32_t subsets) {
  seed += (subsets - 1) * 1024;
  const std::uint32_t random = hash52(seed);
  const std::uint32_t other = (seed & 2U) != 0 ? 4 : 5, third = subsets == 3 ? 6 : 5;
  const std::array<std::uint32_t, 2> shifts = (seed & 1U) != 0 ? std::array{other, third} : std::array{third, other};
  std::array<std::uint32_t, 6> slopes{};
  for (std::size_t i = 0; i < 6; ++i) {
    const std::uint32_t part = random >> (4 * i) & 0xFU;
    slopes[i] = part * part >> shifts[i % 2];
  }
  Pattern out{};
  for (std::uint32_t i = 0; i < 16; ++i) {
    const std::uint32_t x = 2 * (i % 4), y = 2 * (i / 4);
    const auto value = [&](std::size_t slope, std::uint32_t shift) {
      return (slopes[slope] * x + slopes[slope + 1] * y + (random >> shift)) & 0x3FU;
    };
    const std::uint32_t a = value(0, 14), b = value(2, 10), c = subsets == 3 ? value(4, 6) : 0;
    out[i] = a >= b && a >= c ? 0 : b >= c ? 1 : 2;
  }
  return out;
}

template <std::size_t count>
constexpr std::array<Pattern, count> patterns_of(const std::array<std::uint32_t, count>& seeds, std::uint32_t subsets) {
  std::array<Pattern, count> out{};
  for (std::size_t i = 0; i < count; ++i) out[i] = pattern_of(seeds[i], subsets);
  return out;
}
constexpr auto kPatternsOfTwo = patterns_of(kSeedsOfTwo, 2);
constexpr auto kOtherPatternsOfTwo = patterns_of(kOtherSeedsOfTwo, 2);
constexpr auto kPatternsOfThree = patterns_of(kSeedsOfThree, 3);
constexpr Pattern kWhole{};

const Pattern& read_pattern(Block& block, std::size_t mode) {
  const auto one_of = [&](const auto& patterns, std::uint32_t bits) -> const Pattern& {
    const std::uint32_t index = block.take(bits);
    if (index >= patterns.size()) throw damaged_basis("a pattern that does not exist");
    return patterns[index];
  };
  if (kModes[mode].subsets == 1) return kWhole;
  if (kModes[mode].subsets == 3) return one_of(kPatternsOfThree, 4);
  return mode == kOthersOfTwo ? one_of(kOtherPatternsOfTwo, 5) : one_of(kPatternsOfTwo, 5);
}

/// An endpoint's value among base * 2^bits as one of 0 to 255 [ASTC, "Endpoint Unquantization"].
/// low: its bits
/// digit: of base 3 or 5
std::uint32_t unquantized(std::uint32_t low, std::uint32_t digit, const Mode& mode) {
  if (mode.base == 1) return mode.bits == 8 ? low : mode.bits == 5 ? low << 3U | low >> 2U : low * 17;
  const std::uint32_t x = low >> 1U;  // all bits but the lowest
  const auto scaled = [&](std::uint32_t factor, std::uint32_t spread) {
    const std::uint32_t flip = (low & 1U) != 0 ? 511 : 0;
    const std::uint32_t value = (digit * factor + spread) ^ flip;
    return (flip & 0x80U) | value >> 2U;
  };
  if (mode.base == 3) {
    if (mode.bits == 2) return scaled(93, x << 8U | x << 4U | x << 2U | x << 1U);
    if (mode.bits == 4) return scaled(22, x << 6U | x);
    return scaled(5, x << 4U | x >> 4U);
  }
  return mode.bits == 3 ? scaled(26, x << 7U | x << 1U | x >> 1U) : scaled(6, x << 5U | x >> 3U);
}

/// Low and high values of each component of each subset, in turns.
std::array<std::uint8_t, 18> read_endpoints(Block& block, const Mode& mode) {
  const std::uint32_t count = 2 * mode.components * mode.subsets;
  // Digits of base 3 come first, five in 8 bits, or those of base 5, three in 7; fewer take fewer
  // bits.
  constexpr std::uint32_t kBitsOfTrits[6]{0, 2, 4, 5, 7, 8}, kBitsOfQuints[4]{0, 3, 5, 7};
  const std::uint32_t group = mode.base == 3 ? 5 : 3;
  std::array<std::uint32_t, 18> digits{};
  for (std::uint32_t first = 0; mode.base > 1 && first < count; first += group) {
    const std::uint32_t size = std::min(group, count - first);
    std::uint32_t packed = block.take(mode.base == 3 ? kBitsOfTrits[size] : kBitsOfQuints[size]);
    for (std::uint32_t i = first; i < first + size; ++i, packed /= mode.base) digits[i] = packed % mode.base;
  }
  std::array<std::uint8_t, 18> out{};
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t low = block.take(mode.bits);
    out[i] = static_cast<std::uint8_t>(unquantized(low, digits[i], mode));
  }
  return out;
}

/// The part, of 64, that the second endpoint has.
std::uint32_t read_weight(Block& block, std::uint32_t weight_bits, bool first_of_subset) {
  // The highest bit of a subset's first weight is always 0.
  const std::uint32_t value = block.take(first_of_subset ? weight_bits - 1 : weight_bits);
  constexpr std::uint32_t kRepeated[6]{0, 63, 21, 9, 0, 0};
  const std::uint32_t of_63 = weight_bits == 4   ? value << 2U | value >> 2U
                              : weight_bits == 5 ? value << 1U | value >> 4U
                                                 : value * kRepeated[weight_bits];
  return of_63 + (of_63 > 32 ? 1 : 0);
}

std::uint32_t mixed(std::uint32_t low, std::uint32_t high, std::uint32_t weight) {
  return (257 * low * (64 - weight) + 257 * high * weight + 32) >> 14U;
}

using Pixels = std::array<std::uint32_t, 16>;

Pixels decode_block(Block block) {
  static const std::array<std::uint8_t, 128> mode_of = [] {
    std::array<std::uint8_t, 128> out{};
    out.fill(kModes.size());
    for (std::uint8_t mode = 0; mode < kModes.size(); ++mode)
      for (std::uint32_t i = kModes[mode].prefix; i < out.size(); i += 1U << kModes[mode].prefix_bits) out[i] = mode;
    return out;
  }();
  const std::size_t number = mode_of[block.peek() & 127U];
  if (number == kModes.size()) throw damaged_basis("a block of no mode");
  const Mode& mode = kModes[number];
  block.skip(mode.prefix_bits);
  Pixels pixels{};
  if (number == kSolid) {
    std::uint32_t color = 0;
    for (std::uint32_t c = 0; c < 4; ++c) color |= block.take(8) << (8 * c);
    pixels.fill(color);
    return pixels;
  }
  block.skip(mode.hint_bits);
  const Pattern& pattern = read_pattern(block, number);
  // The component that has weights of its own; alpha where there are only a grey and alpha.
  const std::uint32_t apart = mode.planes == 1 ? 4 : mode.components == 2 ? 3 : block.take(2);
  const std::array<std::uint8_t, 18> endpoints = read_endpoints(block, mode);
  std::uint32_t seen = 0;  // subsets, a bit each
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const bool first = (seen >> pattern[i] & 1U) == 0;
    seen |= 1U << pattern[i];
    const std::uint32_t weight = read_weight(block, mode.weight_bits, first);
    const std::uint32_t weight_apart = mode.planes == 1 ? weight : read_weight(block, mode.weight_bits, first);
    const std::uint8_t* const ends = endpoints.data() + 2 * mode.components * pattern[i];
    for (std::uint32_t c = 0; c < 4; ++c) {
      if (c == 3 && mode.components == 3) {
        pixels[i] |= 0xFF000000U;
        continue;
      }
      const std::uint32_t component = mode.components == 2 ? c / 3 : c;
      pixels[i] |= mixed(ends[2 * component], ends[2 * component + 1], c == apart ? weight_apart : weight) << (8 * c);
    }
  }
  return pixels;
}

}  // namespace

void decode_uastc(std::span<const std::byte> blocks, const BlockPicture& picture) {
  for (std::uint32_t row = 0; row < picture.rows(); ++row)
    for (std::uint32_t column = 0; column < picture.columns(); ++column, blocks = blocks.subspan(kUastcBlockBytes)) {
      const Pixels pixels = decode_block(Block(blocks));
      const std::uint32_t right = std::min(picture.width - 4 * column, 4U);
      const std::uint32_t bottom = std::min(picture.height - 4 * row, 4U);
      for (std::uint32_t y = 0; y < bottom; ++y)
        std::copy_n(pixels.begin() + 4 * y, right,
                    picture.rgba8 + std::size_t{4 * row + y} * picture.width + 4 * column);
    }
}

}  // namespace eikon
