// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>

namespace eikon {

/// Refuses empty values, in `command` and the commands in it: `-o "$OUT"` with nothing in OUT must not write where nobody looks.
/// throws CLI::ValidationError with the name of the option
void require_values(const CLI::App& command);

}  // namespace eikon
