// SPDX-License-Identifier: Apache-2.0
#include "io/json_dump.h"

#include <nlohmann/json.hpp>

namespace eikon {

std::string dump_json(const nlohmann::json& tree, int indent) {
  return tree.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace eikon
