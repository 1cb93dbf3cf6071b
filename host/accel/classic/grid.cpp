// SPDX-License-Identifier: Apache-2.0
#include "accel/classic/builders.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "accel/classic/cells.h"

namespace eikon {
namespace {

constexpr double kCellsPerTriangle = 27, kMaxCells = 0x1p27, kMaxOnAxis = 4096;
constexpr std::size_t kChunk = 1024;

/// The planes between cells: floats, of which no two are equal.
std::vector<float> planes_between(float lo, float hi, double cells) {
  const auto count = static_cast<std::size_t>(std::clamp(std::round(cells), 1.0, kMaxOnAxis));
  std::vector<float> planes{lo};
  for (std::size_t i = 1; i < count; ++i) {
    const double w = static_cast<double>(i) / static_cast<double>(count);
    const auto plane = static_cast<float>((1 - w) * double{lo} + w * double{hi});
    if (plane > planes.back() && plane < hi) planes.push_back(plane);
  }
  planes.push_back(hi);
  return planes;
}

class Grid {
 public:
  Grid(const CellScene& scene, double cells) : scene_(scene) {
    std::array<double, 3> size{};
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      size[k] = double{scene.box().hi[k]} - double{scene.box().lo[k]};
      longest = std::max(longest, size[k]);
    }
    // Flat scenes count as a little thick, so that their cells are squares and not too small.
    double volume = 1;
    for (const double s : size) volume *= std::max(s, longest / std::cbrt(cells));
    const double width = std::cbrt(volume / cells);
    for (std::size_t k = 0; k < 3; ++k)
      planes_[k] = planes_between(scene.box().lo[k], scene.box().hi[k], width > 0 ? size[k] / width : 1);
  }

  [[nodiscard]] std::size_t count(std::size_t axis) const { return planes_[axis].size() - 1; }
  [[nodiscard]] std::size_t cells() const { return count(0) * count(1) * count(2); }
  [[nodiscard]] const std::vector<float>& planes(std::size_t axis) const { return planes_[axis]; }

  /// Calls visit(cell) for each cell where the triangle may be hit.
  template <class Visit>
  void for_each_cell(const CellReference& triangle, const Visit& visit) const {
    const auto [from, to] = cells_of(triangle);
    const bool one = from == to;
    CellReference part = triangle;
    for (std::size_t z = from[2]; z <= to[2]; ++z) {
      clip(part, triangle, 2, z);
      for (std::size_t y = from[1]; y <= to[1]; ++y) {
        clip(part, triangle, 1, y);
        for (std::size_t x = from[0]; x <= to[0]; ++x) {
          clip(part, triangle, 0, x);
          if (one || scene_.may_be_hit(part)) visit((z * count(1) + y) * count(0) + x);
        }
      }
    }
  }

  /// The number of entries of all lists; nothing if there are more than `most`.
  [[nodiscard]] std::optional<std::vector<std::uint32_t>> list_sizes(const CellReferences& references,
                                                                     std::size_t most) const {
    std::vector<std::uint32_t> sizes(cells() + 1, 0);
    std::atomic<std::size_t> all{0}, visited{0};
    const std::size_t most_visited = 64 * most;  // cells of boxes take time even if no triangle is in them
    tbb::parallel_for(std::size_t{0}, (references.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
      for (std::size_t i = chunk * kChunk; i < std::min(references.size(), (chunk + 1) * kChunk); ++i) {
        if (all > most || visited > most_visited) return;
        const Range range = cells_of(references[i]);
        std::size_t boxed = 1;
        for (std::size_t k = 0; k < 3; ++k) boxed *= range.to[k] + 1 - range.from[k];
        if ((visited += boxed) > most_visited) return;
        std::size_t listed = 0;
        for_each_cell(references[i], [&](std::size_t cell) {
          ++std::atomic_ref(sizes[cell]);
          ++listed;
        });
        all += listed;
      }
    });
    if (all > most || visited > most_visited) return std::nullopt;
    return sizes;
  }

 private:
  struct Range {
    std::array<std::size_t, 3> from{}, to{};
  };
  [[nodiscard]] Range cells_of(const CellReference& triangle) const {
    Range range;
    for (std::size_t k = 0; k < 3; ++k) {
      range.from[k] = cell_of(k, triangle.lo[k]);
      range.to[k] = std::max(cell_before(k, triangle.hi[k]), range.from[k]);
    }
    return range;
  }
  /// The cell of x. On a plane it is the one above, except on the last plane.
  [[nodiscard]] std::size_t cell_of(std::size_t axis, float x) const {
    const std::vector<float>& p = planes_[axis];
    const auto above = static_cast<std::size_t>(std::upper_bound(p.begin(), p.end(), x) - p.begin());
    return std::clamp<std::size_t>(above, 1, count(axis)) - 1;
  }
  /// The cell of x. On a plane it is the one below.
  [[nodiscard]] std::size_t cell_before(std::size_t axis, float x) const {
    const std::vector<float>& p = planes_[axis];
    const auto above = static_cast<std::size_t>(std::lower_bound(p.begin(), p.end(), x) - p.begin());
    return std::clamp<std::size_t>(above, 1, count(axis)) - 1;
  }
  void clip(CellReference& part, const CellReference& whole, std::size_t axis, std::size_t cell) const {
    part.lo[axis] = std::max(whole.lo[axis], planes_[axis][cell]);
    part.hi[axis] = std::min(whole.hi[axis], planes_[axis][cell + 1]);
  }

  const CellScene& scene_;
  std::array<std::vector<float>, 3> planes_;
};

}  // namespace

/// There are about 27 cells per triangle, nearly cubes, at most 2^27 in all and 4096 along an axis.
/// Each cell lists the triangles that may be hit in it; if that would make more than 16 entries per
/// triangle and 4096 more, cells are larger. The grid does not depend on the number of threads.
/// throws InputError for more than 2^26 triangles
/// source [Fujimoto, Tanaka, Iwata 1986, "ARTS: accelerated ray-tracing system"]; the density is
/// that of [Pharr, Humphreys 2010, PBR, section 4.3]: three cells per triangle along each axis, if
/// triangles were spread evenly
Accel build_grid(TriangleSoup triangles) {
  const CellScene scene(triangles);
  Accel accel = scene.begin("grid", "grid");
  const CellReferences references = scene.references();
  const CellBudget budget = CellBudget::of(scene.size());
  double cells = std::clamp(kCellsPerTriangle * static_cast<double>(scene.size()), 1.0, kMaxCells);
  std::optional<Grid> grid;
  std::optional<std::vector<std::uint32_t>> begins;
  // One cell lists each triangle once, so this ends.
  for (; !begins; cells = std::max(1.0, 0.5 * cells)) {
    grid.emplace(scene, cells);
    begins = grid->list_sizes(references, budget.references);
  }
  std::uint32_t entries = 0;
  for (std::uint32_t& begin : *begins) entries += std::exchange(begin, entries);

  for (std::size_t k = 0; k < 3; ++k) {
    const double size = double{scene.box().hi[k]} - double{scene.box().lo[k]};
    const double per_metre = size > 0 ? static_cast<double>(grid->count(k)) / size : 0;
    accel.nodes[7 + k] = static_cast<std::uint32_t>(grid->count(k));
    accel.nodes[10 + k] =
        std::bit_cast<std::uint32_t>(static_cast<float>(std::min(per_metre, 1e30)));  // a guess is enough
  }
  for (std::size_t k = 0; k < 3; ++k)
    for (const float plane : grid->planes(k)) accel.nodes.push_back(std::bit_cast<std::uint32_t>(plane));
  accel.nodes.insert(accel.nodes.end(), begins->begin(), begins->end());
  accel.leaves.resize(entries, 0);
  // Lists are in the order of the triangles, whatever the threads do.
  std::vector<std::uint32_t>& next = *begins;
  for (const CellReference& each : references)
    grid->for_each_cell(each, [&](std::size_t cell) { accel.leaves[next[cell]++] = scene.id(each.triangle); });
  accel.node_count = grid->cells();
  scene.finish(accel);
  return accel;
}

}  // namespace eikon
