// SPDX-License-Identifier: Apache-2.0
#include "io/source_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "core/error.h"
#include "core/host_limits.h"
#include "io/text.h"

namespace eikon {
namespace {

class FileDescriptor {
 public:
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  ~FileDescriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  [[nodiscard]] int get() const { return descriptor_; }

 private:
  int descriptor_;
};

std::string reason(int error) { return std::generic_category().message(error); }

std::string percent_decoded(std::string_view uri) {
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      out += uri[i];
      continue;
    }
    const auto byte = i + 2 < uri.size() ? number_in<std::uint32_t>(uri.substr(i + 1, 2), 16) : std::nullopt;
    if (!byte) throw InputError("URI " + in_quotes(uri) + " has a broken %-escape");
    out += static_cast<char>(*byte);
    i += 2;
  }
  return out;
}

// A scheme, as in "http:" or "c:", is letters, digits, + - . up to a colon [RFC 3986 section 3.1].
bool has_scheme(std::string_view uri) {
  const std::size_t colon = uri.find(':');
  if (colon == std::string_view::npos || colon == 0) return false;
  return std::all_of(uri.begin(), uri.begin() + static_cast<std::ptrdiff_t>(colon), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '+' || c == '-' ||
           c == '.';
  });
}

bool equals_ignoring_case(std::string_view text, std::string_view lower_case) {
  return std::equal(text.begin(), text.end(), lower_case.begin(), lower_case.end(),
                    [](char c, char lower) { return (c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c) == lower; });
}

// A clone without Git LFS has such a text of about 130 bytes where the file belongs.
void refuse_lfs_pointer(const Bytes& bytes) {
  constexpr std::string_view kFirstLine = "version https://git-lfs.github.com/spec/v1";
  const std::string_view text(reinterpret_cast<const char*>(bytes.data.get()), bytes.size);
  if (text.starts_with(kFirstLine))
    throw InputError("is a pointer of Git LFS instead of the file itself; fetch it with `git lfs pull`");
}

Bytes decode_base64(std::string_view text) {
  if (text.size() % 4 != 0) {
    throw InputError(fmt::format("base64 data of {} characters, not a multiple of 4: truncated?", text.size()));
  }
  for (int padding = 0; padding < 2 && text.ends_with('='); ++padding) text.remove_suffix(1);

  std::array<std::int8_t, 256> value_of{};
  value_of.fill(-1);
  constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kAlphabet.size(); ++i) {
    value_of[static_cast<unsigned char>(kAlphabet[i])] = static_cast<std::int8_t>(i);
  }
  Bytes bytes{.data = std::make_unique_for_overwrite<std::byte[]>(text.size() / 4 * 3 + 3),
              .size = text.size() * 3 / 4};
  std::size_t out = 0;
  std::uint32_t bits = 0, bit_count = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int value = value_of[static_cast<unsigned char>(text[i])];
    if (value < 0) throw InputError(fmt::format("base64 data has an illegal character at position {}", i));
    bits = (bits << 6U) | static_cast<std::uint32_t>(value);
    bit_count += 6;
    if (bit_count >= 8) {
      bit_count -= 8;
      bytes.data[out++] = static_cast<std::byte>((bits >> bit_count) & 0xFFU);
    }
  }
  return bytes;
}

// Returns the bytes of text in which all but printable ASCII is escaped.
Bytes decode_percent_text(std::string_view text) {
  const auto is_plain = [](char c) { return c > 0x20 && c < 0x7F; };
  if (const auto odd = std::find_if_not(text.begin(), text.end(), is_plain); odd != text.end()) {
    throw InputError(
        fmt::format("data URI without base64 has a character at position {} that must be escaped", odd - text.begin()));
  }
  const std::string decoded = percent_decoded(text);
  Bytes bytes{.data = std::make_unique_for_overwrite<std::byte[]>(decoded.size()), .size = decoded.size()};
  std::memcpy(bytes.data.get(), decoded.data(), decoded.size());
  return bytes;
}

std::uint32_t little_endian_u32(std::span<const std::byte> bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(bytes[offset + i]) << (8 * i);
  return value;
}

}  // namespace

Bytes read_regular_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
  // O_NONBLOCK keeps the opening of a FIFO from waiting for a writer. The type is asked of the open
  // file, so it cannot change.
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (file.get() < 0) {
    const int error = errno;
    throw InputError(error == ENOENT ? "no such file; check the name" : "cannot be opened: " + reason(error));
  }
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) throw InputError("cannot be examined: " + reason(errno));
  if (S_ISDIR(status.st_mode)) throw InputError("is a directory; name a file in it");
  if (!S_ISREG(status.st_mode)) throw InputError("is not a regular file (a pipe or device); save it to a file first");
  const auto size = static_cast<std::uint64_t>(std::max<off_t>(status.st_size, 0));
  if (size == 0) throw InputError("is empty (0 bytes); write or copy it again");
  if (const std::uint64_t memory = usable_memory_bytes(); memory != 0) max_bytes = std::min(max_bytes, memory);
  if (size > max_bytes) {
    throw InputError(fmt::format("has {} bytes, more than the {} that eikon reads on this machine", size, max_bytes));
  }
  Bytes bytes{.data = std::make_unique_for_overwrite<std::byte[]>(size), .size = size};
  std::size_t done = 0;
  while (done < bytes.size) {
    const ssize_t got =
        ::read(file.get(), bytes.data.get() + done, std::min<std::size_t>(bytes.size - done, 1U << 30U));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError("cannot be read: " + reason(errno));
    if (got == 0) throw InputError("became shorter while it was read; try again when nothing writes to it");
    done += static_cast<std::size_t>(got);
  }
  refuse_lfs_pointer(bytes);
  return bytes;
}

std::filesystem::path resolve_uri(const std::filesystem::path& folder, std::string_view uri) {
  const auto refuse = [&](std::string_view why) -> InputError {
    return InputError(fmt::format("URI {} {}; only files in the scene's own folder are read", in_quotes(uri), why));
  };
  const std::string decoded = percent_decoded(uri);
  if (decoded.empty()) throw refuse("is empty");
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
  if (std::any_of(decoded.begin(), decoded.end(), is_control)) throw refuse("has a control character");
  if (decoded.find('\\') != std::string::npos) throw refuse("has a backslash");
  if (decoded.front() == '/') throw refuse("is an absolute path");
  if (has_scheme(decoded)) throw refuse("has a scheme");
  std::error_code error;
  const std::filesystem::path root = std::filesystem::canonical(folder.empty() ? "." : folder, error);
  if (error) throw InputError("the scene's folder cannot be examined: " + error.message());
  // The parts ".." of a URI go away before anything is looked up [RFC 3986, section 5.2.4].
  const auto is_inside = [&](const std::filesystem::path& path) {
    return std::mismatch(root.begin(), root.end(), path.begin(), path.end()).first == root.end();
  };
  const std::filesystem::path plain = (root / decoded).lexically_normal();
  if (!is_inside(plain)) throw refuse("leads upwards by '..'");
  std::filesystem::path file = std::filesystem::canonical(plain, error);
  if (error) {
    const bool missing = error == std::errc::no_such_file_or_directory;
    throw InputError(fmt::format("URI {}: {}", in_quotes(uri),
                                 missing ? "no such file beside the scene; copy it there" : error.message()));
  }
  if (!is_inside(file)) throw refuse("is a symbolic link that leads outside");
  return file;
}

bool is_data_uri(std::string_view uri) {
  constexpr std::string_view kScheme = "data:";
  return equals_ignoring_case(uri.substr(0, kScheme.size()), kScheme);
}

Bytes decode_data_uri(std::string_view uri) {
  constexpr std::string_view kBase64 = ";base64";
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos)
    throw InputError("data URI " + in_quotes(uri.substr(0, 40)) + " has no comma; store it as data:...;base64,...");
  const std::string_view head = uri.substr(0, comma), text = uri.substr(comma + 1);
  const bool is_base64 =
      head.size() > kBase64.size() && equals_ignoring_case(head.substr(head.size() - kBase64.size()), kBase64);
  if (!is_base64) return decode_percent_text(text);
  // A URI may escape the signs of base64: +, / and = are reserved characters [RFC 3986, section
  // 2.2].
  return text.find('%') != std::string_view::npos ? decode_base64(percent_decoded(text)) : decode_base64(text);
}

Container open_container(std::span<const std::byte> bytes, bool expect_glb) {
  constexpr std::uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A, kBinary = 0x004E4942;
  const bool is_glb = bytes.size() >= 4 && little_endian_u32(bytes, 0) == kMagic;
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!is_glb) {
    if (expect_glb) {
      throw InputError("is named .glb but does not begin with 'glTF' but with " + in_quotes(text.substr(0, 4)) +
                       "; rename it to .gltf if it is JSON text");
    }
    const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    if (first == std::string_view::npos || text[first] != '{') {
      throw InputError("is not glTF: it begins with " + in_quotes(text.substr(0, 4)) +
                       ", neither '{' (.gltf) nor 'glTF' (.glb)");
    }
    return {.json = text, .binary = {}, .has_binary = false};
  }

  if (bytes.size() < 20)
    throw InputError(fmt::format("is a truncated .glb: {} bytes, the headers alone take 20", bytes.size()));
  const std::uint32_t version = little_endian_u32(bytes, 4), length = little_endian_u32(bytes, 8);
  if (version != 2)
    throw InputError(fmt::format("is a .glb of version {}; only version 2 is read, convert it", version));
  if (length > bytes.size()) {
    throw InputError(
        fmt::format("is a truncated .glb: the header says {} bytes, the file has {}", length, bytes.size()));
  }
  if (length < 20) throw InputError(fmt::format("is a broken .glb: its header says {} bytes in all", length));
  Container container;
  std::size_t offset = 12;  // never above length <= bytes.size(), so nothing below can wrap
  for (int chunk = 0; chunk < 2 && length - offset >= 8; ++chunk) {
    const std::uint32_t chunk_bytes = little_endian_u32(bytes, offset), type = little_endian_u32(bytes, offset + 4);
    offset += 8;
    if (chunk_bytes > length - offset) {
      throw InputError(fmt::format("is a broken .glb: chunk {} of {} bytes at offset {} passes the end at {}", chunk,
                                   chunk_bytes, offset, length));
    }
    const auto content = bytes.subspan(offset, chunk_bytes);
    offset += chunk_bytes;
    if (chunk == 0) {
      if (type != kJson) throw InputError("is a broken .glb: its first chunk is not JSON");
      container.json = {reinterpret_cast<const char*>(content.data()), content.size()};
    } else if (type == kBinary) {
      container.binary = content;
      container.has_binary = true;
    }
  }
  if (container.json.empty()) throw InputError("is a broken .glb: its JSON chunk is missing or empty");
  return container;
}

}  // namespace eikon
