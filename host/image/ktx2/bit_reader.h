// SPDX-License-Identifier: Apache-2.0
// The bits of a BasisLZ stream, and its Huffman codes [KTX 2.0, "BasisLZ Bitstream Specification"].
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace eikon {

/// A prefix code. Streams have the bits of a code from its first to its last, and numbers from
/// their lowest bit.
class HuffmanCode {
 public:
  HuffmanCode() = default;  // of no symbols
  /// lengths: of each symbol's code, 0 to 16; 0: the symbol has none
  /// throws InputError: no prefix code has these lengths
  explicit HuffmanCode(const std::vector<std::uint8_t>& lengths);

  [[nodiscard]] bool empty() const { return entries_.empty(); }

 private:
  friend class BitReader;
  std::uint32_t longest_ = 0;           // bits
  std::vector<std::uint32_t> entries_;  // by the next `longest_` bits: symbol << 8 | bits of its code
};

/// Reads bytes that outlive it.
class BitReader {
 public:
  explicit BitReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  /// count: 0 to 16
  /// throws InputError, as all below: the bytes end before
  std::uint32_t bits(std::uint32_t count);
  std::uint32_t symbol(const HuffmanCode& code);
  /// A number in groups of `group` bits, each with a bit that says whether another follows.
  std::uint32_t number(std::uint32_t group);
  /// A code, by the lengths of its symbols' codes, which are in a code themselves.
  HuffmanCode code();

 private:
  [[nodiscard]] std::uint32_t next() const;  // at least 16 bits; zeros follow the last byte
  void skip(std::uint32_t count);

  std::span<const std::byte> bytes_;
  std::size_t position_ = 0;  // in bits
};

}  // namespace eikon
