// SPDX-License-Identifier: Apache-2.0
// The only file that knows which language reads it. Shared records use uint, int, float and float4
// alone: float3 has 16 bytes in OpenCL and 12 in GLM, and bool, size_t, enums and pointers differ
// between device and host.
#ifndef EK_SHARED_ABI_H
#define EK_SHARED_ABI_H

#if defined(__OPENCL_C_VERSION__) || defined(__OPENCL_VERSION__)  // offline clang -x cl does not define the second
#define EK_BEGIN
#define EK_END
#define EK_ASSERT_SIZE(T, n) typedef char ek_size_of_##T[(sizeof(T) == (n)) ? 1 : -1]
#else
#include <cstdint>
#define EK_BEGIN namespace eikon {
#define EK_END }
#define EK_ASSERT_SIZE(T, n) static_assert(sizeof(T) == (n), #T " differs from the device layout")
EK_BEGIN
using uint = std::uint32_t;
struct alignas(16) float4 {
  float x = 0, y = 0, z = 0, w = 0;
};
EK_END
#endif

#endif
