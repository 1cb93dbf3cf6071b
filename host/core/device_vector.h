// SPDX-License-Identifier: Apache-2.0
// Arrays with the alignment that devices want, so that a CPU device can read them in place
// (Device::share).
#pragma once
#include <cstddef>
#include <new>
#include <type_traits>
#include <utility>
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

/// Leaves new elements of trivial types unset, and puts many of them in huge pages: zeroing the
/// arrays of a tree and faulting in small pages took a fifth of the time to build it.
template <class T>
struct BigAllocator : DeviceAllocator<T> {
  BigAllocator() = default;
  template <class Other>
  BigAllocator(const BigAllocator<Other>&) noexcept {}

  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    if constexpr (sizeof...(Args) == 0 && std::is_trivially_default_constructible_v<U>) {
      ::new (static_cast<void*>(at)) U;
    } else {
      ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
    }
  }
};

template <class T>
using BigVector = std::vector<T, BigAllocator<T>>;

}  // namespace eikon
