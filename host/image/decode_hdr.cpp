// SPDX-License-Identifier: Apache-2.0
#include "image/decode_hdr.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "core/error.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxHdrSide = 65536;
// A run of the new coding makes 127 pixels of 8 bytes, so a file that claims far more lies about
// its size.
constexpr std::uint64_t kMaxHdrExpansion = 4096, kCredibleHdrBytes = std::uint64_t{64} << 20U;
constexpr std::size_t kMaxLine = 2048;  // limit of a header line in Radiance

using Rgbe = std::array<std::uint8_t, 4>;

std::string printable(std::string_view text) {
  std::string out(text.substr(0, 60));
  std::replace_if(
      out.begin(), out.end(), [](char c) { return c < 0x20 || c == 0x7F; }, '?');
  return out;
}

/// Reads the file from the front and checks every read.
class Input {
 public:
  explicit Input(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::uint8_t byte() {
    if (at_ == bytes_.size()) throw InputError("ends too early: truncated? Copy it again");
    return std::to_integer<std::uint8_t>(bytes_[at_++]);
  }

  Rgbe pixel() {
    Rgbe value{};
    for (std::uint8_t& part : value) part = byte();
    return value;
  }

  std::string_view line() {
    const std::size_t begin = at_;
    while (byte() != '\n') {
      if (at_ - begin > kMaxLine) throw InputError(fmt::format("a header line is longer than {} bytes", kMaxLine));
    }
    return {reinterpret_cast<const char*>(bytes_.data()) + begin, at_ - begin - 1};
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

double number(std::string_view line, std::string_view& rest) {
  while (rest.starts_with(' ') || rest.starts_with('\t')) rest.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  if (error != std::errc() || !(std::abs(value) < 1e30))
    throw InputError(fmt::format("header line '{}' holds no number where one belongs", printable(line)));
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return value;
}

double positive_number(std::string_view line, std::string_view& rest) {
  const double value = number(line, rest);
  if (!(value > 1e-30)) throw InputError(fmt::format("header line '{}' holds no positive number", printable(line)));
  return value;
}

constexpr double kLumensPerWatt = 179;  // Radiance's WHTEFFICACY, which XYZE has in its numbers

struct Header {
  std::uint32_t width = 0, height = 0;
  bool from_bottom = false, from_right = false;
  glm::dvec3 divisor{1.0};  // product of all EXPOSURE and COLORCORR lines
  std::optional<Chromaticities> primaries{};
};

// Parses "-Y 512 +X 1024": the slow axis comes first, and -Y means downwards.
void read_resolution(std::string_view line, Header& header) {
  const auto fail = [&] [[noreturn]] (const char* why) {
    throw InputError(fmt::format("its resolution line '{}' {}", printable(line), why));
  };
  std::string_view rest = line;
  const auto axis = [&](char& sign, char& name, std::uint64_t& count) {
    while (rest.starts_with(' ')) rest.remove_prefix(1);
    if (rest.size() < 3 || (rest[0] != '-' && rest[0] != '+') || (rest[1] != 'X' && rest[1] != 'Y') || rest[2] != ' ')
      fail("is not like '-Y 512 +X 1024'; damaged?");
    sign = rest[0], name = rest[1];
    rest.remove_prefix(2);
    while (rest.starts_with(' ')) rest.remove_prefix(1);
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), count);
    if (error != std::errc() || count < 1 || count > kMaxHdrSide) fail("has a side that is not 1 to 65536 pixels");
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  };
  char slow_sign = 0, slow = 0, fast_sign = 0, fast = 0;
  std::uint64_t rows = 0, columns = 0;
  axis(slow_sign, slow, rows);
  axis(fast_sign, fast, columns);
  if (slow != 'Y' || fast != 'X') fail("stores columns first; rotate it with `protate` or save it again");
  header.height = static_cast<std::uint32_t>(rows);
  header.width = static_cast<std::uint32_t>(columns);
  header.from_bottom = slow_sign == '+';
  header.from_right = fast_sign == '-';
}

Header read_header(Input& input) {
  const std::string_view first = input.line();
  if (!first.starts_with("#?")) throw InputError("is not a Radiance picture: it does not begin with '#?'");
  Header header;
  bool has_format = false, is_xyz = false;
  for (std::string_view line = input.line(); !line.empty() && line != "\r"; line = input.line()) {
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.starts_with("FORMAT=")) {
      std::string_view format = line.substr(7);
      while (format.starts_with(' ')) format.remove_prefix(1);
      is_xyz = format == "32-bit_rle_xyze";
      if (!is_xyz && format != "32-bit_rle_rgbe")
        throw InputError(fmt::format("has the unknown format '{}', not 32-bit_rle_rgbe", printable(format)));
      has_format = true;
    } else if (line.starts_with("PRIMARIES=")) {
      std::string_view rest = line.substr(10);
      Chromaticities stated{};
      for (glm::dvec2* xy : {&stated.red, &stated.green, &stated.blue, &stated.white})
        for (int c = 0; c < 2; ++c) (*xy)[c] = number(line, rest);
      header.primaries = stated;
    } else if (line.starts_with("EXPOSURE=")) {
      std::string_view rest = line.substr(9);
      header.divisor *= positive_number(line, rest);
    } else if (line.starts_with("COLORCORR=")) {
      std::string_view rest = line.substr(10);
      for (int c = 0; c < 3; ++c) header.divisor[c] *= positive_number(line, rest);
    }
  }
  if (!has_format) throw InputError("has no line FORMAT=32-bit_rle_rgbe in its header; damaged?");
  read_resolution(input.line(), header);
  if (is_xyz) {
    header.primaries = kXyz;
    header.divisor *= kLumensPerWatt;
  }
  return header;
}

// Decodes the four components of a row one after the other, each as runs and literals.
void read_new_row(Input& input, std::vector<Rgbe>& row) {
  for (std::size_t part = 0; part < 4; ++part) {
    for (std::size_t x = 0; x < row.size();) {
      const std::uint8_t code = input.byte();
      const bool run = code > 128;
      const std::size_t count = run ? code - 128U : code;
      if (count == 0 || count > row.size() - x) throw InputError("has a run beyond the end of its row: damaged");
      std::uint8_t value = run ? input.byte() : std::uint8_t{0};
      for (std::size_t i = 0; i < count; ++i, ++x) {
        if (!run) value = input.byte();
        row[x][part] = value;
      }
    }
  }
}

// Decodes whole pixels. (1, 1, 1, n) repeats the last pixel n times; consecutive ones repeat it n
// << 8, then n << 16 times.
void read_old_row(Input& input, const Rgbe& first, std::vector<Rgbe>& row) {
  row[0] = first;
  unsigned shift = 0;
  for (std::size_t x = 1; x < row.size();) {
    const Rgbe pixel = input.pixel();
    if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
      row[x++] = pixel;
      shift = 0;
      continue;
    }
    const std::uint64_t count = shift < 24 ? std::uint64_t{pixel[3]} << shift : 0;
    if (count > row.size() - x || shift >= 24) throw InputError("has a run beyond the end of its row: damaged");
    std::fill_n(row.begin() + static_cast<std::ptrdiff_t>(x), count, row[x - 1]);
    x += count;
    shift += 8;
  }
}

void read_row(Input& input, std::vector<Rgbe>& row) {
  const Rgbe start = input.pixel();
  const bool is_new = row.size() >= 8 && row.size() <= 32767 && start[0] == 2 && start[1] == 2 && start[2] < 128;
  if (!is_new) return read_old_row(input, start, row);
  const std::size_t width = std::size_t{start[2]} << 8U | start[3];
  if (width != row.size())
    throw InputError(fmt::format("has a row of {} pixels instead of {}: damaged", width, row.size()));
  read_new_row(input, row);
}

}  // namespace

HdrImage decode_hdr(std::span<const std::byte> bytes, std::uint64_t max_bytes) {
  Input input(bytes);
  const Header header = read_header(input);
  const std::uint64_t needed = std::uint64_t{header.width} * header.height * sizeof(glm::vec3);
  if (needed > std::max(kCredibleHdrBytes, bytes.size() * kMaxHdrExpansion))
    throw InputError(fmt::format("its header claims {} x {} pixels, which {} bytes cannot hold", header.width,
                                 header.height, bytes.size()));
  if (needed > max_bytes)
    throw InputError(fmt::format("has {} x {} pixels, which need {} MB; at most {} MB are for it, scale it down",
                                 header.width, header.height, needed >> 20U, max_bytes >> 20U));
  HdrImage image{.width = header.width, .height = header.height, .rgb = {}, .primaries = header.primaries};
  image.rgb.resize(std::size_t{header.width} * header.height);
  // A mantissa m stands for m / 256 as in most readers, so that black stays black; Radiance itself
  // uses (m + 0.5) / 256.
  std::vector<Rgbe> row(header.width);
  for (std::uint32_t i = 0; i < header.height; ++i) {
    read_row(input, row);
    const std::uint32_t y = header.from_bottom ? header.height - 1 - i : i;
    glm::vec3* out = &image.rgb[std::size_t{y} * header.width];
    for (std::uint32_t x = 0; x < header.width; ++x) {
      const Rgbe& pixel = row[header.from_right ? header.width - 1 - x : x];
      if (pixel[3] == 0) continue;  // black, whatever the mantissas are
      const double scale = std::ldexp(1.0, pixel[3] - 136);
      out[x] = glm::vec3(glm::dvec3(pixel[0], pixel[1], pixel[2]) * scale / header.divisor);
    }
  }
  return image;
}

}  // namespace eikon
