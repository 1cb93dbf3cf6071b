// SPDX-License-Identifier: Apache-2.0
// The kernels' dialect in C++, one lane wide, as far as kernels/lanes/interval.h needs it. It
// stands in for kernels/lanes/lanes.h, so that the host compiles the kernels' own text.
#pragma once
#define EK_LANES_H
#include <bit>
#include <cmath>
#include <cstdint>

#include "shared/abi.h"

#define EK_WIDTH 1
#define EK_FN [[maybe_unused]] static inline
#define EK_FN_ONCE EK_FN
#define AS_F(x) std::bit_cast<float>(static_cast<std::uint32_t>(x))
#define AS_U(x) std::bit_cast<std::uint32_t>(x)
#define AS_I(x) std::bit_cast<std::int32_t>(x)
#define TO_F(x) static_cast<float>(x)
#define TO_I(x) static_cast<std::int32_t>(x)

namespace eikon::host_lanes {
using vf = float;
using vi = int;
using vu = std::uint32_t;
using std::sqrt;
struct v3 {
  vf x, y, z;
};
}  // namespace eikon::host_lanes
