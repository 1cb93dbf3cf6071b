// SPDX-License-Identifier: Apache-2.0
// Values of the command line: text to numbers, strictly. All throw UsageError naming the flag and what it takes.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace eikon {

/// "a,b,c" -> pieces; an empty text has none.
std::vector<std::string> split(const std::string& text, char separator);
/// Finite decimal numbers, `count` of them, separated by commas.
std::vector<double> parse_numbers(const std::string& flag, const std::string& text, std::size_t count);
/// For CLI11's check(): a number in that range. CLI11's own lets NaN through, and writes large ends with six decimals.
CLI::Validator between(double least, double most);
std::uint64_t parse_unsigned(const std::string& flag, const std::string& text, std::uint64_t most);

}  // namespace eikon
