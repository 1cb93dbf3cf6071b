// SPDX-License-Identifier: Apache-2.0
#include "image/ktx2/bit_reader.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "image/ktx2/basis_universal.h"

namespace eikon {
namespace {

constexpr std::uint32_t kLongestCode = 16;

// Symbols of the code that lengths are written in: a length of 0 to 16, or a run.
constexpr std::uint32_t kFewZeros = 17, kManyZeros = 18, kRepeatSome = 19, kRepeatMany = 20, kLengthSymbols = 21;
constexpr std::array<std::uint8_t, kLengthSymbols> kOrderOfLengths{17, 18, 19, 20, 0,  8, 7,  9, 6,  10, 5,
                                                                   11, 4,  12, 3,  13, 2, 14, 1, 15, 16};

std::uint32_t reversed(std::uint32_t code, std::uint32_t length) {
  std::uint32_t out = 0;
  for (std::uint32_t i = 0; i < length; ++i) out = out << 1U | (code >> i & 1U);
  return out;
}

}  // namespace

HuffmanCode::HuffmanCode(const std::vector<std::uint8_t>& lengths) {
  std::array<std::uint32_t, kLongestCode + 1> count{}, next{};
  for (const std::uint8_t length : lengths) {
    if (length > kLongestCode) throw damaged_basis("a code of more than 16 bits");
    if (length == 0) continue;
    ++count[length];
    longest_ = std::max<std::uint32_t>(longest_, length);
  }
  std::uint32_t used = 0, code = 0;
  for (std::uint32_t length = 1; length <= longest_; ++length) {
    next[length] = code = (code + count[length - 1]) << 1U;
    used += count[length];
  }
  // The codes fill all values of the longest, but for one that stands alone.
  if (used == 0 || (used > 1 && code + count[longest_] != 1U << longest_))
    throw damaged_basis("lengths of which there is no prefix code");
  entries_.resize(std::size_t{1} << longest_);
  for (std::uint32_t symbol = 0; symbol < lengths.size(); ++symbol) {
    const std::uint32_t length = lengths[symbol];
    if (length == 0) continue;
    for (std::uint32_t bits = reversed(next[length]++, length); bits < entries_.size(); bits += 1U << length)
      entries_[bits] = symbol << 8U | length;
  }
}

std::uint32_t BitReader::next() const {
  std::uint32_t word = 0;
  const std::size_t at = position_ / 8;
  for (std::size_t i = 0; i < 3 && at + i < bytes_.size(); ++i)
    word |= std::to_integer<std::uint32_t>(bytes_[at + i]) << (8 * i);
  return word >> position_ % 8;
}

void BitReader::skip(std::uint32_t count) {
  position_ += count;
  if (position_ > 8 * bytes_.size()) throw damaged_basis("a stream that ends early");
}

std::uint32_t BitReader::bits(std::uint32_t count) {
  const std::uint32_t value = next() & ((1U << count) - 1U);
  skip(count);
  return value;
}

std::uint32_t BitReader::symbol(const HuffmanCode& code) {
  if (code.empty()) throw damaged_basis("a code without symbols");
  const std::uint32_t entry = code.entries_[next() & ((1U << code.longest_) - 1U)];
  if (entry == 0) throw damaged_basis("bits that no code has");
  skip(entry & 0xFFU);
  return entry >> 8U;
}

std::uint32_t BitReader::number(std::uint32_t group) {
  std::uint32_t value = 0;
  for (std::uint32_t shift = 0; shift < 32; shift += group) {
    const std::uint32_t part = bits(group + 1);
    value |= (part & ((1U << group) - 1U)) << shift;
    if (part >> group == 0) return value;
  }
  throw damaged_basis("a number of more than 32 bits");
}

HuffmanCode BitReader::code() {
  const std::uint32_t symbol_count = bits(14);
  if (symbol_count == 0) return {};
  std::vector<std::uint8_t> inner(kLengthSymbols, 0), lengths;
  const std::uint32_t inner_count = bits(5);
  if (inner_count > kLengthSymbols) throw damaged_basis("a code of more lengths than there are");
  for (std::uint32_t i = 0; i < inner_count; ++i) inner[kOrderOfLengths[i]] = static_cast<std::uint8_t>(bits(3));
  const HuffmanCode code_of_lengths(inner);
  while (lengths.size() < symbol_count) {
    const std::uint32_t length = symbol(code_of_lengths);
    if (length < kFewZeros) {
      lengths.push_back(static_cast<std::uint8_t>(length));
    } else if (length < kRepeatSome) {
      lengths.resize(lengths.size() + (length == kManyZeros ? bits(7) + 11 : bits(3) + 3), 0);
    } else {
      if (lengths.empty()) throw damaged_basis("a code that repeats nothing");
      lengths.resize(lengths.size() + (length == kRepeatMany ? bits(7) + 7 : bits(2) + 3), lengths.back());
    }
  }
  if (lengths.size() != symbol_count) throw damaged_basis("a code of more symbols than it says");
  return HuffmanCode(lengths);
}

}  // namespace eikon
