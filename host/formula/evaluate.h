// SPDX-License-Identifier: Apache-2.0
// The values of expressions on the host, with the bits that kernels compute: both compile
// kernels/lanes/formula_math.h and interval.h.
#pragma once
#include <array>

#include "formula/expressions.h"

namespace eikon::formula {

/// x, y, z, dx, dy, dz.
using Point = std::array<float, kVariables>;

struct Bounds1 {
  float lo = 0, hi = 0;
};
using Region = std::array<Bounds1, kVariables>;

struct RegionValue {
  Bounds1 bounds;
  bool undefined = false;  // the expression has a value nowhere in the region
};

/// The value of a node whose operands have the given values.
[[nodiscard]] float apply_op(const Node& node, const std::array<float, 4>& values);

[[nodiscard]] float evaluate(const Expressions& expressions, Id root, const Point& point);
/// Encloses the exact value, and that of `evaluate`, at every point of the region.
[[nodiscard]] RegionValue evaluate(const Expressions& expressions, Id root, const Region& region);
/// The value by the host's own functions, in double.
[[nodiscard]] double evaluate_double(const Expressions& expressions, Id root,
                                     const std::array<double, kVariables>& point);

}  // namespace eikon::formula
