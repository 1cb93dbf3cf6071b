// SPDX-License-Identifier: Apache-2.0
#include "cli/empty_values.h"

#include <algorithm>

namespace eikon {

void require_values(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    const std::vector<std::string>& values = option->results();
    if (std::ranges::none_of(values, &std::string::empty)) continue;
    throw CLI::ValidationError(option->get_name(), option->get_required()
                                                       ? "its value is empty; write one"
                                                       : "its value is empty; write one, or leave the flag out");
  }
  for (const CLI::App* below : command.get_subcommands()) require_values(*below);
}

}  // namespace eikon
