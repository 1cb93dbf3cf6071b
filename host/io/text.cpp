// SPDX-License-Identifier: Apache-2.0
#include "io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace eikon {

namespace {

constexpr std::size_t kMaxBytes = 100;

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

/// The code point of the UTF-8 sequence at the beginning of `text`, and its length; a byte that
/// begins none has the length 0.
struct CodePoint {
  std::uint32_t value = 0;
  std::size_t length = 0;
};
CodePoint first_code_point(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text[0]);
  if (lead < 0x80) return {lead, 1};
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return {};
  std::uint32_t value = lead & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if (!is_continuation(text[i])) return {};
    value = value << 6U | (static_cast<unsigned char>(text[i]) & 0x3FU);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = value >= 0xD800 && value <= 0xDFFF;
  return value < kLeast[length] || value > 0x10FFFF || is_surrogate ? CodePoint{} : CodePoint{value, length};
}

bool is_harmless(std::uint32_t c) {
  const bool is_control = c < 0x20 || (c >= 0x7F && c < 0xA0) || c == 0x2028 || c == 0x2029;
  const bool turns_writing = c == 0x200E || c == 0x200F || c == 0x061C || (c >= 0x202A && c <= 0x202E) ||
                             (c >= 0x2066 && c <= 0x2069);
  return !is_control && !turns_writing;
}

/// The number of letters of a word that have to be inserted, left out or replaced to make it the
/// other.
std::size_t edits_between(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1);  // edits that make what was read of `from` each beginning of `to`
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < to.size(); ++j) {
      const std::size_t replaced = diagonal + (from[i] == to[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const CodePoint c = first_code_point(text);
    const std::size_t length = std::max<std::size_t>(c.length, 1);
    if (c.length > 0 && is_harmless(c.value))
      out += text.substr(0, length);
    else
      for (const char byte : text.substr(0, length)) out += fmt::format("\\x{:02x}", static_cast<unsigned char>(byte));
    text.remove_prefix(length);
  }
  return out;
}

std::string in_quotes(std::string_view text) {
  std::string out;
  for (const char c : printable(text)) c == '\'' ? out += "\\x27" : out += c;
  if (out.size() > kMaxBytes) {
    // Neither part begins or ends inside a UTF-8 sequence.
    std::size_t head = kMaxBytes / 2, tail = out.size() - kMaxBytes / 2;
    while (is_continuation(out[head])) --head;
    while (is_continuation(out[tail])) ++tail;
    out = out.substr(0, head) + "..." + out.substr(tail);
  }
  return "'" + out + "'";
}

std::string label(std::string_view kind, std::uint64_t index, std::string_view name) {
  return name.empty() ? fmt::format("{} {}", kind, index) : fmt::format("{} {}", kind, in_quotes(name));
}

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> pieces;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    pieces.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return pieces;
}

std::optional<std::string> most_like(std::string_view word, const std::vector<std::string>& names) {
  std::optional<std::string> best;
  for (const std::string& name : names)
    if (name.starts_with(word) && (!best || name.size() < best->size())) best = name;
  if (best) return best;
  std::size_t fewest = word.size() / 3 + 1;
  for (const std::string& name : names)
    if (const std::size_t edits = edits_between(word, name); edits < fewest) fewest = edits, best = name;
  return best;
}

std::string one_line(std::string_view text) {
  std::string out(text);
  std::replace_if(
      out.begin(), out.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }, ' ');
  while (!out.empty() && out.back() == ' ') out.pop_back();
  return out;
}

std::string name_to_utf8(std::string_view name) {
  std::string text;
  while (!name.empty()) {
    const std::size_t length = name[0] == '\0' ? 0 : first_code_point(name).length;
    if (length > 0)
      text += name.substr(0, length);
    else
      text += fmt::format("{}{:02x}", '\0', static_cast<unsigned char>(name[0]));
    name.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return text;
}

std::string name_from_utf8(std::string_view text) {
  constexpr std::size_t kDigits = 2;
  std::string name;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view digits = text.substr(i + 1, kDigits);
    const bool is_byte = text[i] == '\0' && digits.size() == kDigits;
    const auto byte = is_byte ? number_in<std::uint8_t>(digits, 16) : std::nullopt;
    name += byte ? static_cast<char>(*byte) : text[i];
    i += byte ? kDigits : 0;
  }
  return name;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = i; k < i + 3; ++k)
      bits = bits << 8U | (k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

}  // namespace eikon
