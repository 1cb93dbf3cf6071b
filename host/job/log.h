// SPDX-License-Identifier: Apache-2.0
// Notes for the user while a job runs.
#pragma once
#include <fmt/format.h>

#include <cstdio>
#include <functional>
#include <string>
#include <utility>

#include "io/text.h"

namespace eikon {

/// Takes one line for the user, without the end of line.
using Log = std::function<void(const std::string&)>;

/// Writes to stderr and ignores failure. fmt::print would throw, but a full disk behind a log must
/// not end a render.
template <class... Arguments>
void print_to_stderr(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  (void)std::fputs(fmt::format(text, std::forward<Arguments>(arguments)...).c_str(), stderr);
}

/// Writes each line to stderr as "eikon: LINE", unless quiet. Names of files in it may hold
/// anything.
inline Log log_unless(bool quiet) {
  if (quiet) return [](const std::string&) {};
  return [](const std::string& line) { print_to_stderr("eikon: {}\n", printable(line)); };
}

}  // namespace eikon
