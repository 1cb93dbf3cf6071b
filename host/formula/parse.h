// SPDX-License-Identifier: Apache-2.0
// A formula as its author writes it, read by a strict grammar:
//   sum      = product {("+" | "-") product}
//   product  = signed {("*" | "/") signed}
//   signed   = {"+" | "-"} power
//   power    = primary ["^" signed]               -x^2 is -(x^2), a^b^c is a^(b^c)
//   primary  = number | name | name "(" sum {"," sum} ")" | "(" sum ")"
// Names: x y z pi e; sqrt abs sin cos tan exp log atan sinh cosh tanh of one value, min max of two
// or more. Numbers are decimal. All is computed in single precision. A power whose exponent is no
// whole number from -64 to 64 or 1/2 needs a base above 0.
#pragma once
#include <array>
#include <string_view>

#include "formula/expressions.h"

namespace eikon::formula {

inline constexpr std::size_t kMaxCharacters = 4096;
inline constexpr int kMaxNesting = 64;

/// f, its gradient, and its derivative along the direction (dx, dy, dz).
struct Formula {
  Expressions expressions;
  Id value = 0;
  std::array<Id, 3> gradient{};
  Id slope = 0;
};

/// throws InputError: "column 7: unknown name 'foo'; known: ...", or what else is wrong, without
/// the formula's own name
[[nodiscard]] Formula parse_formula(std::string_view text);

}  // namespace eikon::formula
