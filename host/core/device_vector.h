// SPDX-License-Identifier: Apache-2.0
// Arrays with the alignment that devices want, so that a CPU device can read them in place
// (Device::share).
#pragma once
#include <cstddef>
#include <new>
#include <vector>

namespace eikon {

/// Allocates memory for a device's buffer, aligned for the widest CPU vectors. Large blocks lie in
/// huge pages, because trees of millions of triangles would miss the TLB at every node. Returns
/// nullptr when there is no memory.
[[nodiscard]] void* allocate_device_memory(std::size_t bytes) noexcept;
void free_device_memory(void* memory) noexcept;

/// Asks for huge pages in memory that has not been touched yet, if a whole one fits.
void prefer_huge_pages(void* memory, std::size_t bytes) noexcept;

inline constexpr std::size_t kDeviceAlignment = 64;

template <class T>
struct DeviceAllocator {
  using value_type = T;
  DeviceAllocator() = default;
  template <class Other>
  DeviceAllocator(const DeviceAllocator<Other>&) noexcept {}
  T* allocate(std::size_t count) {
    if (count > static_cast<std::size_t>(-1) / 2 / sizeof(T)) throw std::bad_array_new_length();
    void* const memory = allocate_device_memory(count * sizeof(T));
    if (memory == nullptr) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t) noexcept { free_device_memory(memory); }
  friend bool operator==(const DeviceAllocator&, const DeviceAllocator&) { return true; }
};

template <class T>
using DeviceVector = std::vector<T, DeviceAllocator<T>>;

}  // namespace eikon
