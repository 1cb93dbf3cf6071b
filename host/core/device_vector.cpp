// SPDX-License-Identifier: Apache-2.0
#include "core/device_vector.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>

namespace eikon {

void* allocate_device_memory(std::size_t bytes) noexcept {
  constexpr std::size_t huge_page = std::size_t{2} << 20;
  const bool huge = bytes >= 2 * huge_page;
  const std::size_t unit = huge ? huge_page : kDeviceAlignment;
  const std::size_t rounded = (std::max<std::size_t>(bytes, 1) + unit - 1) / unit * unit;
  void* const memory = std::aligned_alloc(unit, rounded);
  if (huge && memory != nullptr) madvise(memory, rounded, MADV_HUGEPAGE);
  return memory;
}

void free_device_memory(void* memory) noexcept { std::free(memory); }

}  // namespace eikon
