// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>
#include <string_view>

namespace eikon {

/// The text without the parts that its #if directives leave out, given macros that are defined as 0
/// or 1. Drivers keep compiled programs by their text, so programs without a feature stay valid
/// where only code under its #if has changed. Conditions may join names by & && | || ! and
/// parentheses. One that says more, or that depends on other macros, is left to the compiler, with
/// all that is under it.
/// defines  name -> value, as they are passed to the compiler
std::string without_excluded(std::string_view text, const std::map<std::string, std::string>& defines);

}  // namespace eikon
