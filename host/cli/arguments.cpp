// SPDX-License-Identifier: Apache-2.0
#include "cli/arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string_view>

namespace eikon {
namespace {

constexpr std::string_view kPictureExtensions[] = {".avif", ".bmp", ".dpx",  ".exr", ".gif",  ".hdr",
                                                   ".heic", ".jp2", ".jpeg", ".jpg", ".jxl",  ".pfm",
                                                   ".png",  ".ppm", ".tga",  ".tif", ".tiff", ".webp"};

std::optional<double> real(const std::string& text) {
  const auto value = number_in<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

}  // namespace

std::vector<double> parse_numbers(const std::string& flag, const std::string& text, std::size_t count) {
  std::vector<double> numbers;
  for (const std::string& piece : text.empty() ? std::vector<std::string>() : split(text, ',')) {
    const auto value = real(piece);
    if (!value) throw UsageError(fmt::format("{} {}: '{}' is not a number", flag, text, piece));
    numbers.push_back(*value);
  }
  if (numbers.size() != count)
    throw UsageError(
        fmt::format("{} {}: takes {} numbers separated by commas, not {}", flag, text, count, numbers.size()));
  return numbers;
}

glm::dvec3 parse_vector(const std::string& flag, const std::string& text) {
  const std::vector<double> n = parse_numbers(flag, text, 3);
  return {n[0], n[1], n[2]};
}

double parse_real(const std::string& flag, const std::string& text, double least, double most) {
  const auto value = real(text);
  if (!value || *value < least || *value > most)
    throw UsageError(fmt::format("{}: '{}' is not a number from {} to {}", flag, text, least, most));
  return *value;
}

std::uint64_t parse_unsigned(const std::string& flag, const std::string& text, std::uint64_t most,
                             std::uint64_t least) {
  const bool hexadecimal = text.starts_with("0x");
  const auto value = number_in<std::uint64_t>(text.substr(hexadecimal ? 2 : 0), hexadecimal ? 16 : 10);
  if (!value || *value < least || *value > most)
    throw UsageError(fmt::format("{}: '{}' is not a number from {} to {}", flag, text, least, most));
  return *value;
}

std::uint64_t parse_size_bytes(const std::string& flag, const std::string& text) {
  const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
  const auto number = number_in<std::uint64_t>(text.substr(0, digits));
  std::string unit = text.substr(digits);
  for (char& c : unit) c = char(std::tolower(static_cast<unsigned char>(c)));
  if (unit.ends_with('b')) unit.pop_back();
  if (unit.size() == 2 && unit[1] == 'i') unit.pop_back();
  const std::size_t found = std::string_view("kmgtpe").find(unit);
  const std::size_t power = unit.empty() ? 0 : 1 + found;
  const bool is_unit = unit.size() <= 1 && found != std::string_view::npos;
  if (!number || *number == 0 || !is_unit || *number > std::numeric_limits<std::uint64_t>::max() >> (10 * power))
    throw UsageError(fmt::format("{}: takes a size above 0, such as 512M or 4G, not {}", flag, text));
  return *number << (10 * power);
}

std::string parse_picture(const std::string& flag, const std::string& text, const std::string& extension) {
  const std::filesystem::path file(text);
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
  const bool is_other = std::ranges::find(kPictureExtensions, ending) != std::end(kPictureExtensions);
  if (is_other && ending != extension)
    throw UsageError(
        fmt::format("{} {}: it writes a file of the format {}, so call it {}{}", flag, text, extension,
                    std::filesystem::path(file).replace_extension(extension).string(),
                    extension == ".exr" ? "; --png FILE writes an 8-bit picture" : ""));
  return text;
}

void refuse_choice(const std::string& flag, const std::string& text, const std::vector<std::string>& words) {
  throw UsageError(fmt::format("{}: there is no '{}'; it takes {}", flag, text, fmt::join(words, ", ")));
}

}  // namespace eikon
