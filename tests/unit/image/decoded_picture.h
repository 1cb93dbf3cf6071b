// SPDX-License-Identifier: Apache-2.0
// Decodes pictures that are in memory, for the tests of the decoders.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "image/decode_picture.h"
#include "support/messages.h"

namespace picture_test {

inline std::span<const std::byte> bytes_of(const std::string& file) { return std::as_bytes(std::span(file)); }

inline std::vector<std::uint32_t> decoded(const std::string& file) {
  return eikon::decode_picture(bytes_of(file), eikon::read_picture_header(bytes_of(file)));
}

/// The message with which the decoder refuses `file`; the test fails if it accepts it.
inline std::string refusal(const std::string& file) {
  return eikon::test::message_of([&] { decoded(file); });
}

}  // namespace picture_test
