// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "cli/help/command_help.h"

namespace eikon {

/// The manual page of a command of section 1, in the macros `man`, which groff and mandoc read.
/// parent  the command above, for SEE ALSO; null: there is none
[[nodiscard]] std::string man_page(const CommandHelp& command, const CommandHelp* parent);

/// "eikon-bench-rays", by which `man` finds the page.
[[nodiscard]] std::string man_name(const CommandHelp& command);

}  // namespace eikon
