// SPDX-License-Identifier: Apache-2.0
// Strict conversion of the command line's text to values. Every function throws UsageError, which
// names the flag and what it takes.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "core/error.h"
#include "io/text.h"

namespace eikon {

/// Reads `count` finite decimal numbers, separated by commas.
std::vector<double> parse_numbers(const std::string& flag, const std::string& text, std::size_t count);
/// Reads "x,y,z".
glm::dvec3 parse_vector(const std::string& flag, const std::string& text);
/// Reads a finite decimal number within a range.
double parse_real(const std::string& flag, const std::string& text, double least, double most);
/// Reads a whole number: decimal, or hexadecimal after 0x.
std::uint64_t parse_unsigned(const std::string& flag, const std::string& text, std::uint64_t most,
                             std::uint64_t least = 0);
/// Reads a number of bytes: "4000", "512M", "4G" or "4GiB". A kilobyte has 1024 bytes.
std::uint64_t parse_size_bytes(const std::string& flag, const std::string& text);

/// Reads the name of a picture to write, whose format is that of `extension`: ".exr" or ".png". One
/// that ends as pictures of another common format do is refused, because viewers go by the name.
std::string parse_picture(const std::string& flag, const std::string& text, const std::string& extension);

template <class Number>
Number parse_number(const std::string& flag, const std::string& text, double least, double most) {
  if constexpr (std::is_floating_point_v<Number>)
    return Number(parse_real(flag, text, least, most));
  else
    return Number(parse_unsigned(flag, text, std::uint64_t(most), std::uint64_t(least)));
}

[[noreturn]] void refuse_choice(const std::string& flag, const std::string& text, const std::vector<std::string>& words);

/// Looks up the value of a word.
template <class Value>
const Value& choose(const std::string& flag, const std::string& text, const std::map<std::string, Value>& values) {
  if (const auto found = values.find(text); found != values.end()) return found->second;
  std::vector<std::string> words;
  for (const auto& [word, value] : values) words.push_back(word);
  refuse_choice(flag, text, words);
}

}  // namespace eikon
