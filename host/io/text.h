// SPDX-License-Identifier: Apache-2.0
// Text for messages. Names that come from a file may hold any bytes, so they are escaped and cut.
#pragma once
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace eikon {

/// `text` with each byte as "\x1b" that could move or rewrite what a terminal shows: control
/// characters, marks that change the direction of writing, and what is not UTF-8.
[[nodiscard]] std::string printable(std::string_view text);

/// `text` in single quotes, fit for one line: printable, quotes escaped, and at most about 100
/// bytes, of which the middle is left out, because a path's end names the file.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// "node 'lamp'", or "node 3" if it has no name.
[[nodiscard]] std::string label(std::string_view kind, std::uint64_t index, std::string_view name);

/// The pieces of "a,b,c", which may be empty; an empty text is one empty piece.
[[nodiscard]] std::vector<std::string> split(std::string_view text, char separator);

/// The name that is most like a mistyped word: the shortest that begins with it or, if none does,
/// the one with the fewest letters to insert, leave out or replace [Levenshtein 1966], at most a
/// third of the word's. Nothing if no name is like it.
[[nodiscard]] std::optional<std::string> most_like(std::string_view word, const std::vector<std::string>& names);

/// Takes the first line off the text; returns it without the end of line, which the last one may
/// lack.
[[nodiscard]] inline std::string_view take_line(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(text.size(), line.size() + 1));
  return line;
}

/// The number that the whole text says, or nothing. how: base or format, as std::from_chars takes
/// it
template <class Number, class... How>
[[nodiscard]] std::optional<Number> number_in(std::string_view text, How... how) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, how...);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

/// `text` with its control characters replaced by blanks, for messages of libraries.
[[nodiscard]] std::string one_line(std::string_view text);

/// A name of a file, or a word, as UTF-8 that other programs read without loss: itself, but for
/// each byte that is not UTF-8, or is NUL. Such a byte becomes NUL and its two hex digits, since no
/// name of a file has a NUL of its own.
[[nodiscard]] std::string name_to_utf8(std::string_view name);
/// The name that name_to_utf8() was given.
[[nodiscard]] std::string name_from_utf8(std::string_view text);

/// Bytes as base64 with padding [RFC 4648, section 4].
[[nodiscard]] std::string base64(std::string_view bytes);

}  // namespace eikon
