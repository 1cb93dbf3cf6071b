// SPDX-License-Identifier: Apache-2.0
// Text for messages. Names that come from a file may hold any bytes, so they are escaped and cut.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace eikon {

/// `text` in single quotes, fit for one line: control characters and quotes are escaped, and the
/// rest after 80 bytes is cut.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// "node 'lamp'", or "node 3" if it has no name.
[[nodiscard]] std::string label(std::string_view kind, std::uint64_t index, std::string_view name);

/// `text` with its control characters replaced by blanks, for messages of libraries.
[[nodiscard]] std::string one_line(std::string_view text);

}  // namespace eikon
