// SPDX-License-Identifier: Apache-2.0
// Writes formulas as straight-line kernel code for kernels/shapes/implicit_root.h; a shared
// subexpression is computed once.
#pragma once
#include <string>
#include <vector>

#include "formula/parse.h"

namespace eikon::formula {

/// The functions that kernels/shapes/implicit_root.h calls; `formula` is an index into `formulas`.
///   vf implicit_value(uint formula, v3 p)            f
///   v3 implicit_gradient(uint formula, v3 p)
///   ImplicitBounds implicit_bounds(uint formula, Interval x, Interval y, Interval z, v3 d)  f and
///                                                                                           its
///                                                                                           slope
///                                                                                           along
///                                                                                           d
/// Their bits are those of evaluate(); numbers from the formula appear as hexadecimal floats,
/// nothing else of its text does.
[[nodiscard]] std::string kernel_code(const std::vector<Formula>& formulas);

}  // namespace eikon::formula
