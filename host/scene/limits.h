// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

namespace eikon {

/// The largest coordinate that a scene may have, in metres; squares and cubes of it stay far from
/// overflow.
inline constexpr double kMaxCoordinate = 1099511627776.0;  // 2^40
/// The most operations and numbers that the formulas of a scene have together; a kernel holds code
/// for all of them.
inline constexpr std::size_t kMaxFormulaNodes = std::size_t{1} << 16U;
/// Width over height of pictures that a camera may ask for.
inline constexpr double kMinAspect = 1e-6, kMaxAspect = 1e6;

}  // namespace eikon
