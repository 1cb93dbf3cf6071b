// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <utility>

namespace eikon {

/// Text for the user on stderr, whatever becomes of it: where fmt::print would throw, a log on a full disk ends no work.
template <class... Arguments>
void tell(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  (void)std::fputs(fmt::format(text, std::forward<Arguments>(arguments)...).c_str(), stderr);
}

}  // namespace eikon
