// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace eikon {

/// The text of a JSON tree. Bytes of strings that are not UTF-8, as names of files and devices may
/// have, are replaced by U+FFFD, since the library would throw.
/// indent  blanks of each level; -1: all on one line
[[nodiscard]] std::string dump_json(const nlohmann::json& tree, int indent = -1);

}  // namespace eikon
