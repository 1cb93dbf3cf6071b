// SPDX-License-Identifier: Apache-2.0
// ETC1S under BasisLZ [KTX 2.0, "BasisLZ Bitstream Specification"]. A block is a pair of indices:
// of an endpoint (a colour and how far its four shades lie apart) and of a selector (which shade
// each pixel has). Endpoints are predicted from neighbours, selectors from those used before.
#include <algorithm>
#include <array>
#include <vector>

#include "image/ktx2/basis_universal.h"
#include "image/ktx2/bit_reader.h"

namespace eikon {
namespace {

struct Endpoint {
  std::array<std::uint8_t, 3> color5;  // of 5 bits each
  std::uint8_t intensity;              // 0 to 7
};
using Selector = std::array<std::uint8_t, 4>;  // a row per byte, two bits per pixel from the left

struct Codebooks {
  std::vector<Endpoint> endpoints;
  std::vector<Selector> selectors;
  HuffmanCode prediction, endpoint_delta, selector, run;
  std::uint32_t history_size = 0;
};

constexpr std::size_t kGlobalHeaderBytes = 20, kImageBytes = 20;

std::uint32_t number_at(std::span<const std::byte> bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value |= std::to_integer<std::uint32_t>(bytes[at + i]) << (8 * i);
  return value;
}

/// Bytes that must lie in what is read.
std::span<const std::byte> stretch(std::span<const std::byte> bytes, std::size_t offset, std::size_t size) {
  if (offset > bytes.size() || size > bytes.size() - offset) throw damaged_basis("a part beyond its end");
  return bytes.subspan(offset, size);
}

void read_endpoints(std::span<const std::byte> bytes, std::vector<Endpoint>& endpoints) {
  BitReader reader(bytes);
  std::array<HuffmanCode, 3> color_codes;
  for (HuffmanCode& code : color_codes) code = reader.code();
  const HuffmanCode intensity_code = reader.code();
  const bool grey = reader.bits(1) != 0;
  Endpoint endpoint{{16, 16, 16}, 0};
  for (Endpoint& out : endpoints) {
    endpoint.intensity = static_cast<std::uint8_t>((endpoint.intensity + reader.symbol(intensity_code)) & 7U);
    for (std::size_t c = 0; c < (grey ? 1U : 3U); ++c) {
      std::uint8_t& value = endpoint.color5[c];
      const HuffmanCode& code = color_codes[value <= 9 ? 0 : value <= 21 ? 1 : 2];
      value = static_cast<std::uint8_t>((value + reader.symbol(code)) & 31U);
    }
    if (grey) endpoint.color5[1] = endpoint.color5[2] = endpoint.color5[0];
    out = endpoint;
  }
}

void read_selectors(std::span<const std::byte> bytes, std::vector<Selector>& selectors) {
  BitReader reader(bytes);
  if (reader.bits(2) != 0) throw damaged_basis("selectors of a global codebook, which the format no longer has");
  const bool plain = reader.bits(1) != 0;
  const HuffmanCode code = plain ? HuffmanCode() : reader.code();
  Selector selector{};
  for (std::size_t i = 0; i < selectors.size(); ++i) {
    for (std::uint8_t& row : selector)
      row = static_cast<std::uint8_t>(plain || i == 0 ? reader.bits(8) : row ^ reader.symbol(code));
    selectors[i] = selector;
  }
}

Codebooks read_codebooks(const Etc1sStreams& streams) {
  const std::span<const std::byte> bytes = streams.global;
  const std::span<const std::byte> header = stretch(bytes, 0, kGlobalHeaderBytes);
  Codebooks books;
  books.endpoints.resize(number_at(header, 0, 2));
  books.selectors.resize(number_at(header, 2, 2));
  if (books.endpoints.empty() || books.selectors.empty()) throw damaged_basis("an empty codebook");
  std::size_t at = kGlobalHeaderBytes + std::size_t{streams.level_count} * kImageBytes;
  const auto following = [&](std::size_t field) {
    const std::size_t size = number_at(header, field, 4);
    const std::span<const std::byte> found = stretch(bytes, at, size);
    at += size;
    return found;
  };
  read_endpoints(following(4), books.endpoints);
  read_selectors(following(8), books.selectors);
  BitReader reader(following(12));
  for (HuffmanCode* code : {&books.prediction, &books.endpoint_delta, &books.selector, &books.run})
    *code = reader.code();
  books.history_size = reader.bits(13);
  if (books.history_size == 0) throw damaged_basis("no history of selectors");
  return books;
}

/// Indices of endpoints, each told by a prediction of two bits; four blocks share a symbol.
class EndpointIndices {
 public:
  EndpointIndices(const Codebooks& books, std::uint32_t columns)
      : books_(books), above_(columns), row_(columns), later_bits_((columns + 1) / 2) {}

  void begin_row() { std::swap(above_, row_); }

  std::uint32_t next(BitReader& reader, std::uint32_t column, std::uint32_t row) {
    if (column % 2 == 0) bits_ = row % 2 == 0 ? upper_half(reader, column) : later_bits_[column / 2];
    const std::uint32_t prediction = bits_ & 3U;
    bits_ >>= 2U;
    if (((prediction == kLeft || prediction == kUpperLeft) && column == 0) ||
        ((prediction == kUpper || prediction == kUpperLeft) && row == 0))
      throw damaged_basis("a block predicted from outside");
    if (prediction == kUpper) previous_ = above_[column];
    if (prediction == kUpperLeft) previous_ = above_[column - 1];
    if (prediction == kDelta) {
      previous_ += reader.symbol(books_.endpoint_delta);
      if (previous_ >= books_.endpoints.size()) previous_ -= static_cast<std::uint32_t>(books_.endpoints.size());
      if (previous_ >= books_.endpoints.size()) throw damaged_basis("an endpoint that its codebook lacks");
    }
    return row_[column] = previous_;
  }

 private:
  static constexpr std::uint32_t kLeft = 0, kUpper = 1, kUpperLeft = 2, kDelta = 3;
  static constexpr std::uint32_t kRepeat = 256;  // the symbol after those of four predictions

  /// Predictions of the upper two of four blocks; those of the lower two are kept.
  std::uint32_t upper_half(BitReader& reader, std::uint32_t column) {
    if (repeats_ > 0) {
      --repeats_;
    } else if (const std::uint32_t symbol = reader.symbol(books_.prediction); symbol == kRepeat) {
      repeats_ = reader.number(4) + 2;  // three at least, of which this is one
    } else {
      symbol_ = symbol;
    }
    later_bits_[column / 2] = symbol_ >> 4U;
    return symbol_;
  }

  const Codebooks& books_;
  std::vector<std::uint32_t> above_, row_, later_bits_;
  std::uint32_t bits_ = 0, symbol_ = 0, repeats_ = 0, previous_ = 0;  // of the block before, in any row
};

/// Indices of selectors: new ones, or places in a list of recent ones.
class SelectorIndices {
 public:
  explicit SelectorIndices(const Codebooks& books)
      : books_(books), history_(books.history_size, 0), place_(books.history_size / 2) {}

  std::uint32_t next(BitReader& reader) {
    const auto count = static_cast<std::uint32_t>(books_.selectors.size());
    std::uint32_t symbol = count;  // the first of the history
    if (run_ > 0) {
      --run_;
    } else {
      symbol = reader.symbol(books_.selector);
      if (symbol == count + books_.history_size) {
        const std::uint32_t length = reader.symbol(books_.run);
        run_ = (length == kLongRun ? reader.number(7) : length) + 2;  // three at least, of which this is one
        symbol = count;
      }
    }
    if (symbol < count) {
      history_[place_++] = symbol;
      if (place_ == history_.size()) place_ = books_.history_size / 2;
      return symbol;
    }
    const std::uint32_t recent = symbol - count;
    if (recent >= history_.size()) throw damaged_basis("a selector that its codebook lacks");
    const std::uint32_t found = history_[recent];
    std::swap(history_[recent / 2], history_[recent]);
    return found;
  }

 private:
  static constexpr std::uint32_t kLongRun = 63;

  const Codebooks& books_;
  std::vector<std::uint32_t> history_;
  std::uint32_t place_, run_ = 0;
};

/// The four shades of a colour, from dark to bright [ETC1, table of intensity modifiers].
std::array<std::array<std::uint8_t, 3>, 4> shades(const Endpoint& endpoint) {
  constexpr int kModifiers[8][2] = {{2, 8}, {5, 17}, {9, 29}, {13, 42}, {18, 60}, {24, 80}, {33, 106}, {47, 183}};
  const auto& [small, large] = kModifiers[endpoint.intensity];
  const std::array<int, 4> offsets{-large, -small, small, large};
  std::array<std::array<std::uint8_t, 3>, 4> out{};
  for (std::size_t shade = 0; shade < 4; ++shade)
    for (std::size_t c = 0; c < 3; ++c) {
      const int base = endpoint.color5[c] << 3 | endpoint.color5[c] >> 2;
      out[shade][c] = static_cast<std::uint8_t>(std::clamp(base + offsets[shade], 0, 255));
    }
  return out;
}

/// Decodes a slice: colours, or alpha in the green of its colours, into pixels that have the
/// colours.
void decode_slice(const Codebooks& books, std::span<const std::byte> bytes, bool alpha, const BlockPicture& picture) {
  BitReader reader(bytes);
  EndpointIndices endpoints(books, picture.columns());
  SelectorIndices selectors(books);
  for (std::uint32_t row = 0; row < picture.rows(); ++row) {
    endpoints.begin_row();
    for (std::uint32_t column = 0; column < picture.columns(); ++column) {
      const auto colors = shades(books.endpoints[endpoints.next(reader, column, row)]);
      const Selector& selector = books.selectors[selectors.next(reader)];
      const std::uint32_t right = std::min(picture.width - 4 * column, 4U);
      const std::uint32_t bottom = std::min(picture.height - 4 * row, 4U);
      for (std::uint32_t y = 0; y < bottom; ++y) {
        std::uint32_t* pixel = picture.rgba8 + std::size_t{4 * row + y} * picture.width + 4 * column;
        for (std::uint32_t x = 0; x < right; ++x, ++pixel) {
          const auto& [r, g, b] = colors[selector[y] >> (2 * x) & 3U];
          *pixel = alpha ? (*pixel & 0xFFFFFFU) | static_cast<std::uint32_t>(g) << 24U
                         : r | static_cast<std::uint32_t>(g) << 8U | static_cast<std::uint32_t>(b) << 16U | 0xFF000000U;
        }
      }
    }
  }
}

}  // namespace

void decode_etc1s(const Etc1sStreams& streams, const BlockPicture& picture) {
  const Codebooks books = read_codebooks(streams);
  // The largest level's image is described first.
  const std::span<const std::byte> image = stretch(streams.global, kGlobalHeaderBytes, kImageBytes);
  const auto slice = [&](std::size_t field) {
    return stretch(streams.level, number_at(image, field, 4), number_at(image, field + 4, 4));
  };
  decode_slice(books, slice(4), false, picture);
  if (const std::span<const std::byte> alpha = slice(12); !alpha.empty()) decode_slice(books, alpha, true, picture);
}

}  // namespace eikon
