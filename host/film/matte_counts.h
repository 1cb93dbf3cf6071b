// SPDX-License-Identifier: Apache-2.0
// How often the samples of each pixel met what: exact, so that parts of a render add up in any order.
#pragma once
#include <cstdint>
#include <vector>

namespace eikon {

/// So many samples met what has this id; id 0 is nothing at all.
struct MatteCount {
  std::uint32_t id = 0;
  std::uint64_t samples = 0;
  bool operator==(const MatteCount&) const = default;
};

/// Counts for each pixel and id. Memory grows with the ids that a pixel shows, not with its samples: 16 bytes for a pixel, and for
/// each further id of it. Rows lie apart: different ones may be added to at the same time.
class MatteCounts {
 public:
  MatteCounts(std::uint32_t width, std::uint32_t height);

  /// x, y from the first pixel on. throws InputError when a pixel has more than 2^64 samples of an id
  void add(std::uint32_t x, std::uint32_t y, const MatteCount& count);
  /// What a pixel has, by increasing id, none of them with 0 samples: the same list whatever the order in which it was added.
  [[nodiscard]] std::vector<MatteCount> of(std::uint32_t x, std::uint32_t y) const;

  /// Of a pixel with one id.
  static constexpr std::uint64_t kBytesPerPixel = 16;

 private:
  struct Entry {
    std::uint64_t samples = 0;  // 0: empty, only as the first of a pixel
    std::uint32_t id = 0;
    std::uint32_t next = 0;  // of the same pixel, in the row; 0: none
  };
  static_assert(sizeof(Entry) == kBytesPerPixel);
  std::vector<std::vector<Entry>> rows_;  // the first entries of a row's pixels, then further ones
};

}  // namespace eikon
