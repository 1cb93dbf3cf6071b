// SPDX-License-Identifier: Apache-2.0
// The epsilon of relative errors, which keeps those of dark pixels finite.
#pragma once

namespace eikon {

/// relMSE is the mean of (x - r)^2 / (r^2 + kErrorEpsilon), and MAPE that of |x - r| / (|r| +
/// kErrorEpsilon); x is the tested value, r the reference.
inline constexpr double kErrorEpsilon = 1e-2;

}  // namespace eikon
