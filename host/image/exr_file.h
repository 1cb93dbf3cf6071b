// SPDX-License-Identifier: Apache-2.0
// An EXR file that is open for reading, for the readers of pictures (here) and of films (film/exr).
#pragma once
#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "core/error.h"

namespace eikon::exr {

inline constexpr const char* kPrefix = "eikon.";  // of our header attributes
inline constexpr int kMaxSide = 65536;
inline constexpr std::uint64_t kMaxBytes = std::uint64_t{16} << 30;

/// throws InputError "cannot read ...", with the reason
[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& why);
[[nodiscard]] std::string one_line(std::string text);

/// An open EXR file; check() limits the size of its parts.
class Reader {
 public:
  /// throws InputError and the exceptions of OpenEXR; see reading()
  explicit Reader(const std::filesystem::path& path);

  [[nodiscard]] Imf::MultiPartInputFile& file() { return *file_; }
  [[nodiscard]] const Imf::Header& header(int part) const { return file_->header(part); }
  /// Checks the claimed size of a part before anything is allocated for it. throws InputError
  void check(int part, std::uint64_t max_bytes = kMaxBytes) const;
  /// The size of the data window. throws InputError
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> size(int part) const;

 private:
  std::filesystem::path path_;
  std::uint64_t size_bytes_ = 0;
  std::unique_ptr<Imf::MultiPartInputFile> file_;
};

/// Calls `body` and turns exceptions of OpenEXR and the allocator into an InputError of one line.
template <std::invocable Body>
auto reading(const std::filesystem::path& path, Body body) {
  try {
    return body();
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    refuse(path, "not enough memory for it");
  } catch (const std::exception& error) {
    refuse(path, one_line(error.what()) + " It may be cut off or damaged: copy or render it again");
  }
}

}  // namespace eikon::exr
