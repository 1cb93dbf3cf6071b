// SPDX-License-Identifier: Apache-2.0
// Exact counts of what the samples of each pixel hit, so that parts of a render add up in any
// order.
#pragma once
#include <cstdint>
#include <vector>

namespace eikon {

/// So many samples hit the object or material of this id; id 0 stands for a miss.
struct MatteCount {
  std::uint32_t id = 0;
  std::uint64_t samples = 0;
  bool operator==(const MatteCount&) const = default;
};

/// Counts for each pixel and id. A pixel takes 16 bytes, and 16 bytes for each further id, however
/// many samples it has. Threads may add to different rows at the same time.
class MatteCounts {
 public:
  MatteCounts(std::uint32_t width, std::uint32_t height);

  /// x, y: relative to the first pixel. throws InputError when a pixel has more than 2^64 samples
  /// of an id
  void add(std::uint32_t x, std::uint32_t y, const MatteCount& count);
  /// The counts of a pixel by increasing id, without zeros. The list does not depend on the order
  /// in which counts were added.
  [[nodiscard]] std::vector<MatteCount> of(std::uint32_t x, std::uint32_t y) const;

  /// Memory of a pixel with one id.
  static constexpr std::uint64_t kBytesPerPixel = 16;

 private:
  struct Entry {
    std::uint64_t samples = 0;  // 0: the entry is empty, which only the first of a pixel can be
    std::uint32_t id = 0;
    std::uint32_t next = 0;  // index in the row of the pixel's next entry, whose id is larger; 0: none
  };
  static_assert(sizeof(Entry) == kBytesPerPixel);
  struct Row {
    std::vector<Entry> entries;  // first the first entry of each pixel, then further ones
    // The pixel of the last call of add(), and an entry of it from which ids that are not smaller
    // are looked for: ids come in order from files, where a pixel of a damaged one may have
    // millions.
    std::uint32_t pixel = 0;
    std::size_t last = 0;
  };
  std::vector<Row> rows_;
};

}  // namespace eikon
