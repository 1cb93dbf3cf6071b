// SPDX-License-Identifier: Apache-2.0
#include "core/device_vector.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace eikon {
namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;

}  // namespace

void prefer_huge_pages(void* memory, std::size_t bytes) noexcept {
  if (bytes < 2 * kHugePage) return;
  const auto begin = (reinterpret_cast<std::uintptr_t>(memory) + kHugePage - 1) / kHugePage * kHugePage;
  const auto end = (reinterpret_cast<std::uintptr_t>(memory) + bytes) / kHugePage * kHugePage;
  madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
}

void* allocate_device_memory(std::size_t bytes) noexcept {
  const std::size_t unit = bytes >= 2 * kHugePage ? kHugePage : kDeviceAlignment;
  const std::size_t rounded = (std::max<std::size_t>(bytes, 1) + unit - 1) / unit * unit;
  void* const memory = std::aligned_alloc(unit, rounded);
  if (memory != nullptr) prefer_huge_pages(memory, rounded);
  return memory;
}

void free_device_memory(void* memory) noexcept { std::free(memory); }

}  // namespace eikon
