// SPDX-License-Identifier: Apache-2.0
#include "device/store/pocl_binary.h"

#include <cstdint>
#include <cstring>
#include <vector>

namespace eikon {
namespace {

using namespace std::string_view_literals;

constexpr std::uint32_t kFormat = 9;
constexpr std::string_view kProgramFile = "/program.bc";
// The shortest bitcode [llvm.org/docs/BitCodeFormat.html]: its magic number, and a block of a
// module (8) without records.
constexpr std::string_view kEmptyProgram = "BC\xC0\xDE\x21\x08\0\0\x01\0\0\0\0\0\0\0"sv;
// PoCL names a program's folder by 40 letters from A to P, a slash among them. No name of its own
// ends with this.
constexpr std::size_t kNameLength = 40;
constexpr char kEndOfName = 'Z';

struct OtherFormat {};

/// The numbers and texts of a binary, one after the other.
class Reader {
 public:
  explicit Reader(std::string_view all) : all_(all) {}
  [[nodiscard]] std::size_t position() const { return position_; }
  std::string_view bytes(std::size_t count) {
    if (count > all_.size() - position_) throw OtherFormat();
    position_ += count;
    return all_.substr(position_ - count, count);
  }
  template <class Number>
  Number number() {
    Number result = 0;
    std::memcpy(&result, bytes(sizeof result).data(), sizeof result);
    return result;
  }
  std::string_view text() { return bytes(number<std::uint32_t>()); }

 private:
  std::string_view all_;
  std::size_t position_ = 0;
};

struct UnpackedFile {
  std::string_view path;
  std::size_t size;
};

struct Parts {
  std::size_t name_at;  // of the program's folder
  std::string_view name;
  std::size_t program_at;  // bytes of the record that follows, in 8 bytes; path and content of the bitcode's file
  std::size_t kernels_at;
  std::vector<UnpackedFile> libraries;
};

void require(bool as_expected) {
  if (!as_expected) throw OtherFormat();
}

/// Appends the libraries of the next kernel.
void read_kernel(Reader& reader, std::vector<UnpackedFile>& libraries) {
  const std::size_t begin = reader.position();
  const auto size = reader.number<std::uint64_t>(), size_of_files = reader.number<std::uint64_t>();
  const std::size_t before = reader.position() - begin;
  require(size >= before && size_of_files <= size - before && size_of_files > 0);
  reader.bytes(size - before - size_of_files);
  while (reader.position() < begin + size) {
    const std::string_view path = reader.text();
    libraries.push_back({path, reader.text().size()});
  }
  require(reader.position() == begin + size && libraries.back().path.ends_with(".so"));
}

/// throws OtherFormat
Parts parts_of(std::string_view binary) {
  Reader reader(binary);
  require(reader.bytes(8) == "poclbin\0"sv);
  reader.bytes(8);  // the device
  require(reader.number<std::uint32_t>() == kFormat);
  const auto kernels = reader.number<std::uint32_t>();
  reader.bytes(12);  // flags
  Parts parts{.name_at = reader.position(),
              .name = reader.bytes(kNameLength),
              .program_at = 0,
              .kernels_at = 0,
              .libraries = {}};
  require(parts.name[2] == '/' && reader.number<char>() == '\0');
  parts.program_at = reader.position();
  const auto size = reader.number<std::uint64_t>();
  const std::size_t begin = reader.position();
  require(reader.text() == kProgramFile && reader.text().starts_with(kEmptyProgram.substr(0, 4)));
  parts.kernels_at = reader.position();
  require(parts.kernels_at - begin == size);
  for (std::uint32_t kernel = 0; kernel < kernels; ++kernel) read_kernel(reader, parts.libraries);
  require(reader.position() == binary.size());
  return parts;
}

template <class Number>
void append(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

}  // namespace

std::optional<std::string> without_bitcode(std::string_view binary) try {
  const Parts parts = parts_of(binary);
  std::string result(binary.substr(0, parts.program_at));
  result[parts.name_at + kNameLength - 1] = kEndOfName;
  append(result, std::uint64_t{2 * sizeof(std::uint32_t) + kProgramFile.size() + kEmptyProgram.size()});
  for (const std::string_view text : {kProgramFile, kEmptyProgram}) {
    append(result, std::uint32_t(text.size()));
    result += text;
  }
  return result.append(binary.substr(parts.kernels_at));
} catch (const OtherFormat&) {
  return {};
}

bool is_unpacked(std::string_view binary, const std::filesystem::path& cache) try {
  const Parts parts = parts_of(binary);
  const std::string folder = (cache / parts.name).string();
  for (const UnpackedFile& file : parts.libraries) {
    std::error_code missing;
    if (std::filesystem::file_size(folder + std::string(file.path), missing) != file.size || missing) return false;
  }
  return true;
} catch (const OtherFormat&) {
  return true;
}

}  // namespace eikon
