// SPDX-License-Identifier: Apache-2.0
// The set of samples of each pixel that a film holds. A render computes from it what is left to do,
// a checkpoint stores it, and a merge refuses samples that would count twice.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "film/units.h"

namespace eikon {

/// A set of (pixel, sample) pairs. Its representation does not depend on the order of additions, so
/// equal sets have equal parts().
class SampleSet {
 public:
  /// One box of samples of `unit` that are in the set already, or nothing when there are none.
  [[nodiscard]] std::optional<WorkUnit> overlap(const WorkUnit& unit) const;
  [[nodiscard]] std::optional<WorkUnit> overlap(const SampleSet& other) const;
  /// Adds samples. throws InternalError when one of them is in the set already
  void add(const WorkUnit& unit);
  void add(const SampleSet& other);

  /// The samples [begin, end) of a window that are not in the set, as disjoint boxes in the order
  /// of their first samples, then of rows.
  [[nodiscard]] std::vector<WorkUnit> missing(const Crop& crop, std::uint64_t begin, std::uint64_t end) const;
  /// The largest sample index up to `end` such that each pixel of a window has all samples from
  /// `begin` to it.
  [[nodiscard]] std::uint64_t complete_until(const Crop& crop, std::uint64_t begin, std::uint64_t end) const;
  /// The set as disjoint boxes in the order of rows: the fewest rows of boxes, each as wide as
  /// possible.
  [[nodiscard]] std::vector<WorkUnit> parts() const;
  [[nodiscard]] std::uint64_t sample_count() const;
  [[nodiscard]] bool empty() const { return slabs_.empty(); }
  bool operator==(const SampleSet&) const = default;

 private:
  struct Range {
    std::uint64_t begin = 0, end = 0;
    bool operator==(const Range&) const = default;
  };
  using Ranges = std::vector<Range>;  // increasing, with gaps between them
  /// Columns, or rows, from `begin` to `end` that hold the same. Touching neighbours differ, and
  /// none is empty.
  template <class Content>
  struct Interval {
    std::uint32_t begin = 0, end = 0;
    Content content{};
    bool operator==(const Interval&) const = default;
  };
  using Column = Interval<Ranges>;
  using Slab = Interval<std::vector<Column>>;
  std::vector<Slab> slabs_;

  static void insert(Ranges& ranges, Range range);
  static void insert(std::vector<Column>& columns, std::uint32_t x0, std::uint32_t x1, Range range);
};

}  // namespace eikon
