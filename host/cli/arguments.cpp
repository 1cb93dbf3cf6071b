// SPDX-License-Identifier: Apache-2.0
#include "cli/arguments.h"

#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "core/error.h"

namespace eikon {

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> pieces;
  if (text.empty()) return pieces;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    pieces.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return pieces;
}

std::vector<double> parse_numbers(const std::string& flag, const std::string& text, std::size_t count) {
  std::vector<double> numbers;
  for (const std::string& piece : split(text, ',')) {
    double value = 0;
    const auto [end, code] = std::from_chars(piece.data(), piece.data() + piece.size(), value);
    if (code != std::errc() || end != piece.data() + piece.size() || !std::isfinite(value))
      throw UsageError(fmt::format("{} {}: '{}' is not a number", flag, text, piece));
    numbers.push_back(value);
  }
  if (numbers.size() != count)
    throw UsageError(
        fmt::format("{} {}: takes {} numbers separated by commas, not {}", flag, text, count, numbers.size()));
  return numbers;
}

CLI::Validator between(double least, double most) {
  const std::string range = fmt::format("{} to {}", least, most);
  const auto check = [=](const std::string& text) {
    double value = 0;
    const bool within = CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
    return within ? "" : fmt::format("'{}' is not a number from {}", text, range);
  };
  return {check, range};
}

std::uint64_t parse_unsigned(const std::string& flag, const std::string& text, std::uint64_t most) {
  std::uint64_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || end != text.data() + text.size() || value > most)
    throw UsageError(fmt::format("{}: '{}' is not a whole number from 0 to {}", flag, text, most));
  return value;
}

}  // namespace eikon
