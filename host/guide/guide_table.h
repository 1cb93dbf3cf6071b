// SPDX-License-Identifier: Apache-2.0
// The table that a pilot has learned, as kernels look it up to guide paths (kernels/guide/guide.h).
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "shared/guide.h"
#include "shared/hash.h"

namespace eikon {

/// A cell of kernels/guide/cell.h: both words of its CellKey, the level included.
using CellId = std::uint64_t;

[[nodiscard]] inline CellId cell_id(std::uint32_t xy, std::uint32_t zn) { return CellId{xy} | CellId{zn} << 32; }
[[nodiscard]] inline std::uint32_t level_of(CellId id) { return std::uint32_t(id >> 56); }
/// The cell of the next coarser level that contains this one.
[[nodiscard]] CellId coarser(CellId id);

EK_DEFINE_HASHES(inline, std::uint32_t)

/// The light that a pilot found at a cell. Radiances are luminances.
struct GuideCellData {
  CellId id = 0;
  std::array<double, EK_GUIDE_BINS> target{};  // weights of the bins, not normalised; all 0: no preference
  double indirect = 0;                         // mean radiance that arrives along the rays which paths go on with
  double direct = 0;                           // what light sampling finds there, over the albedo; its mean
};

struct GuideTable {
  std::vector<std::uint32_t> slots = {0, 0};  // pairs of a tag and the index of a cell; their number is a power of two
  std::vector<std::uint32_t> cells;           // EK_GUIDE_CELL_WORDS each
  float scale = 1;                            // 1 / side of a cell of level 0, 1 / metres
  /// First vertex where the table decides about Russian roulette, 1 or more; 0: nothing is guided.
  std::uint32_t roulette_depth = 0;

  [[nodiscard]] std::uint32_t slot_mask() const { return std::uint32_t(slots.size() / 2 - 1); }
  [[nodiscard]] std::size_t cell_count() const { return cells.size() / EK_GUIDE_CELL_WORDS; }
  /// The memory that a device needs for it.
  [[nodiscard]] std::uint64_t bytes() const { return sizeof(std::uint32_t) * (slots.size() + cells.size()); }
  /// True if kernels may look things up in it: indices lie within it, searches end, and weights are
  /// those of densities.
  [[nodiscard]] bool is_sound() const;
  /// Identifies everything in it.
  [[nodiscard]] std::uint64_t digest() const;
};

/// The weights of a cell's bins, in units of 1 / EK_GUIDE_TOTAL: each at least EK_GUIDE_LEAST of
/// the mean, the rest in proportion to the target.
[[nodiscard]] std::array<std::uint32_t, EK_GUIDE_BINS> guide_weights(const std::array<double, EK_GUIDE_BINS>& target);

using GuideCellWords = std::array<std::uint32_t, EK_GUIDE_CELL_WORDS>;
[[nodiscard]] GuideCellWords words_of(const GuideCellData& cell);
/// True if the weights of a cell are those of a density, and its radiances are finite. words: of
/// one cell
[[nodiscard]] bool is_sound_cell(std::span<const std::uint32_t> words);

/// cells: their ids and words, sorted by id, so that equal cells make equal tables
[[nodiscard]] GuideTable assemble_guide_table(std::span<const std::pair<CellId, const GuideCellWords*>> cells,
                                              float scale);
/// The same from cells without words.
[[nodiscard]] GuideTable make_guide_table(const std::vector<GuideCellData>& cells, float scale);

}  // namespace eikon
