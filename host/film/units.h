// SPDX-License-Identifier: Apache-2.0
// Cuts an image into work units; plain numbers only.
#pragma once
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "film/film.h"

namespace eikon {

/// A block of pixels and a half-open range of sample indices, the same for each of them.
struct WorkUnit {
  Crop block;
  std::uint64_t sample_begin = 0, sample_end = 0;
  [[nodiscard]] std::uint64_t path_count() const { return block.pixel_count() * (sample_end - sample_begin); }
  bool operator==(const WorkUnit&) const = default;
};

/// The samples that no device has yet: disjoint boxes of (pixels x samples), from which units of
/// any size are cut. Units come in the order of their first samples, and all blocks come before the
/// next samples, so that an interrupted image is noisy and has no holes. Every (pixel, sample)
/// comes out exactly as often as it was added.
class UnitPool {
 public:
  /// block: largest side of a unit's block, in pixels
  explicit UnitPool(std::uint32_t block) : block_(block < 1 ? 1 : block) {}

  /// No unit crosses a multiple of so many samples: a power of two, 2^32 at first.
  void set_period(std::uint64_t period) { period_ = period; }

  /// Cuts the pixels of `box` into a grid of nearly equal blocks. A block is joined with an
  /// adjacent box of the pool where the two form one box.
  void add(const WorkUnit& box);

  /// Takes a unit of at most `most_paths` >= 1 paths with at most `most_samples` >= 1 of each
  /// pixel, as large as the next block allows: samples are reduced first, then pixels. Units end at
  /// samples that are multiples of about a quarter of a unit, so that blocks which were cut in
  /// pieces become whole again. Returns nothing when the pool is empty.
  /// most_pixels  a larger block is first cut into a grid of nearly square parts, of which the unit
  ///              has one
  [[nodiscard]] std::optional<WorkUnit> take(std::uint64_t most_paths, std::uint64_t most_samples,
                                             std::uint64_t most_pixels = ~std::uint64_t{0});

  [[nodiscard]] std::uint64_t path_count() const { return paths_; }
  [[nodiscard]] bool empty() const { return boxes_.empty(); }
  [[nodiscard]] std::size_t box_count() const { return boxes_.size(); }

 private:
  struct Earlier {
    bool operator()(const WorkUnit& a, const WorkUnit& b) const;
  };
  using Boxes = std::set<WorkUnit, Earlier>;
  std::uint32_t block_;
  std::uint64_t period_ = std::uint64_t{1} << 32;
  Boxes boxes_;
  std::uint64_t paths_ = 0;

  [[nodiscard]] std::optional<WorkUnit> joined(const WorkUnit& a, const WorkUnit& b) const;
  void put(WorkUnit box);
  [[nodiscard]] Boxes::iterator choose(std::uint64_t most_pixels) const;
};

/// Returns the pixels of a block as x | y << 16, in tiles of 4 x 4, so that neighbouring lanes
/// start with neighbouring rays.
[[nodiscard]] std::vector<std::uint32_t> unit_pixels(const Crop& block);

}  // namespace eikon
