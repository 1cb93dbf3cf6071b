// SPDX-License-Identifier: Apache-2.0
// The bytes of a scene. It decides which files may be read, how much of them, and what a URI may
// name.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "core/host_limits.h"

namespace eikon {

/// Bytes that are written once and then only looked at.
struct Bytes {
  std::unique_ptr<std::byte[]> data;
  std::size_t size = 0;
  [[nodiscard]] std::span<const std::byte> span() const { return {data.get(), size}; }
};

/// Reads a whole regular file; FIFOs, devices and directories are refused without being read.
/// throws InputError (without the path): missing, unreadable, not a regular file, empty, above
///        `max_bytes`, or a pointer that Git LFS left in place of the file
Bytes read_regular_file(const std::filesystem::path& path, std::uint64_t max_bytes);

/// The file that a relative URI of a scene in `folder` names, symbolic links resolved.
/// throws InputError: absolute, with a scheme, a backslash, a control character or a bad escape, or
///        outside `folder`, by its ".." or once links are followed
std::filesystem::path resolve_uri(const std::filesystem::path& folder, std::string_view uri);

/// True for "data:", whose letters may be capitals [RFC 3986, section 3.1].
[[nodiscard]] bool is_data_uri(std::string_view uri);

/// Decodes "data:...;base64,...", or "data:...,..." with percent-escapes [RFC 2397].
/// throws InputError: not base64 [RFC 4648 section 4], a bad escape, or a character that has to be
///        escaped
Bytes decode_data_uri(std::string_view uri);

/// JSON text and binary chunk of a scene file; views into its bytes.
struct Container {
  std::string_view json;
  std::span<const std::byte> binary;
  bool has_binary = false;
};

/// Splits a .glb [glTF 2.0, section 4]; a text file is all JSON. `expect_glb`: the name says so.
/// throws InputError: wrong magic, version, lengths or chunk order
Container open_container(std::span<const std::byte> bytes, bool expect_glb);

}  // namespace eikon
