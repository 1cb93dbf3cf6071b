// SPDX-License-Identifier: Apache-2.0
// Numbers the cells that a pilot visits, in the order in which they are added, and stores values by
// these numbers.
#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "guide/guide_table.h"

namespace eikon {

/// A hash table with open addressing: a search reads one or two neighbouring slots, where one of
/// std::unordered_map follows pointers. A pilot makes millions of searches.
class CellIndex {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  /// Returns the number of a cell, or kNone.
  [[nodiscard]] std::uint32_t find(CellId id) const { return slots_[slot_of(id)].number; }
  /// Returns the number of a cell, which becomes the next one if it had none.
  std::uint32_t add(CellId id) {
    std::size_t at = slot_of(id);
    if (slots_[at].number != kNone) return slots_[at].number;
    if (2 * (ids_.size() + 1) > slots_.size()) {
      grow();
      at = slot_of(id);
    }
    slots_[at] = {id, std::uint32_t(ids_.size())};
    ids_.push_back(id);
    return slots_[at].number;
  }
  /// The cells in the order of their numbers.
  [[nodiscard]] std::span<const CellId> ids() const { return ids_; }
  /// Forgets all cells and keeps the memory.
  void clear() {
    ids_.clear();
    slots_.assign(slots_.size(), Slot());
  }

 private:
  struct Slot {
    CellId id = 0;
    std::uint32_t number = kNone;  // kNone: the slot is free
  };
  static constexpr std::size_t kFirstSlots = 64;

  /// The slot that has the cell, or the free one that is to have it.
  [[nodiscard]] std::size_t slot_of(CellId id) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = std::size_t((id * 0x9e3779b97f4a7c15ULL) >> 32) & mask;
    while (slots_[at].number != kNone && slots_[at].id != id) at = (at + 1) & mask;
    return at;
  }
  void grow() {
    slots_.assign(2 * slots_.size(), Slot());
    for (std::uint32_t number = 0; number < ids_.size(); ++number)
      slots_[slot_of(ids_[number])] = {ids_[number], number};
  }

  std::vector<Slot> slots_ = std::vector<Slot>(kFirstSlots);  // a power of two, at least half of them free
  std::vector<CellId> ids_;
};

/// Values of cells by their numbers. They stay where they are when others are added, because to
/// move them takes longer than to fill them.
template <class T>
class CellValues {
 public:
  [[nodiscard]] std::size_t size() const { return size_; }
  T& operator[](std::size_t number) { return blocks_[number / kBlock][number % kBlock]; }
  const T& operator[](std::size_t number) const { return blocks_[number / kBlock][number % kBlock]; }
  /// Adds the value of the next number, and returns it to be filled: it is what was there before.
  T& add() {
    if (size_ == kBlock * blocks_.size()) blocks_.push_back(std::make_unique_for_overwrite<T[]>(kBlock));
    return (*this)[size_++];
  }
  /// Forgets all values and keeps the memory.
  void clear() { size_ = 0; }

 private:
  static constexpr std::size_t kBlock = 32;
  std::vector<std::unique_ptr<T[]>> blocks_;
  std::size_t size_ = 0;
};

}  // namespace eikon
