// SPDX-License-Identifier: Apache-2.0
// Vectors of megabytes whose elements are written before they are read.
#pragma once
#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace eikon {

/// Leaves new elements of trivial types unset, and asks for huge pages for large arrays: zeroing a tree's arrays and
/// faulting in their small pages was a fifth of the time to build it.
template <class T>
struct BigAllocator {
  using value_type = T;
  BigAllocator() = default;
  template <class U>
  BigAllocator(const BigAllocator<U>&) {}

  T* allocate(std::size_t n) {
    void* memory = ::operator new(n * sizeof(T), alignment(n));
#ifdef MADV_HUGEPAGE
    if (large(n)) madvise(memory, n * sizeof(T), MADV_HUGEPAGE);  // advice: failure changes nothing
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t n) { ::operator delete(memory, alignment(n)); }

  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    if constexpr (sizeof...(Args) == 0 && std::is_trivially_default_constructible_v<U>) {
      ::new (static_cast<void*>(at)) U;
    } else {
      ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
    }
  }
  friend bool operator==(const BigAllocator&, const BigAllocator&) { return true; }

 private:
  static constexpr std::size_t kHugePage = std::size_t{2} << 20;
  static bool large(std::size_t n) { return n >= 2 * kHugePage / sizeof(T); }
  static std::align_val_t alignment(std::size_t n) {
    return std::align_val_t{large(n) ? kHugePage : std::max(alignof(T), std::size_t{16})};
  }
};

template <class T>
using BigVector = std::vector<T, BigAllocator<T>>;

}  // namespace eikon
