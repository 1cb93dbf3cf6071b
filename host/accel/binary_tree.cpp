// SPDX-License-Identifier: Apache-2.0
#include "accel/binary_tree.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "core/error.h"

namespace eikon {
namespace {

constexpr std::size_t kBins = 32;
constexpr std::size_t kSweepLimit = 12;           // nodes up to this size are swept in sorted order instead of binned
constexpr std::size_t kTaskLimit = 4096;          // below, a subtree is one task
constexpr std::size_t kParallelLimit = 1U << 16;  // above, binning and partition of one node run in parallel
constexpr std::size_t kChunk = 1U << 14;          // of a parallel partition; fixed, so that threads do not show
constexpr std::uint32_t kMedianDepth = 64;        // from here on nodes are halved, which bounds the depth

/// A triangle's box, its index in the fourth lane of `lo`. The index travels as the bits of a normal float, so that vector
/// arithmetic on whole registers meets neither denormals nor NaN there.
struct Reference {
  Box box;
  static constexpr std::uint32_t kNormal = 0x40000000;
  static constexpr std::uint32_t kLimit = 1U << 28;
  void set_triangle(std::uint32_t i) { box.lo[3] = std::bit_cast<float>(i | kNormal); }
  [[nodiscard]] std::uint32_t triangle() const { return std::bit_cast<std::uint32_t>(float{box.lo[3]}) & ~kNormal; }
};

Float4 centroid2(const Reference& r) { return r.box.lo + r.box.hi; }

struct Range {
  Box box, centroids;  // of twice the centroids
  void add(const Reference& r) {
    box.add(r.box);
    centroids.add(centroid2(r));
  }
  void add(const Range& other) {
    box.add(other.box);
    centroids.add(other.centroids);
  }
};

/// What n triangles below a child are expected to cost, for choosing a split: leaves hold 8 that are tested at once, the
/// second term favours small numbers among equals.
float count_cost(std::size_t n) { return 8.0F * static_cast<float>((n + 7) / 8) + 0.5F * static_cast<float>(n); }

/// Maps twice a centroid to a bin per axis; an axis without extent has one bin.
struct BinMap {
  std::size_t bins;  // fewer for few triangles
  Float4 base, scale, last;
  BinMap(const Box& centroids, std::size_t count)
      : bins(std::min(kBins, 4 + count / 4)),
        base(centroids.lo),
        scale(splat4(0)),
        last(splat4(static_cast<float>(bins - 1))) {
    for (int axis = 0; axis < 3; ++axis) {
      const float s = static_cast<float>(bins) * 0.99999F / (centroids.hi[axis] - centroids.lo[axis]);
      scale[axis] = std::isfinite(s) ? s : 0.0F;
    }
  }
  [[nodiscard]] Int4 operator()(Float4 c) const {
    const Float4 x = min4(max4((c - base) * scale, splat4(0)), last);  // NaN becomes 0
    return __builtin_convertvector(x, Int4);
  }
};

struct Bins {
  std::array<std::array<Box, kBins>, 3> box;
  std::array<std::array<std::uint32_t, kBins>, 3> count{};
  void add(const Reference& r, const BinMap& map) {
    const Int4 bin = map(centroid2(r));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto b = static_cast<std::size_t>(bin[axis]);
      box[axis][b].add(r.box);
      ++count[axis][b];
    }
  }
  void add(const Bins& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t b = 0; b < kBins; ++b) {
        box[axis][b].add(other.box[axis][b]);
        count[axis][b] += other.count[axis][b];
      }
    }
  }
};

struct BinSplit {
  float cost = std::numeric_limits<float>::infinity();
  std::size_t axis = 0;
  std::int32_t last_left = -1;  // last bin of the left side; negative: no split separates the centroids
};

BinSplit best_split(const Bins& bins, const BinMap& map) {
  BinSplit best;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (map.scale[axis] == 0.0F) continue;
    std::array<float, kBins> right_cost{};
    Box box;
    std::size_t count = 0;
    for (std::size_t b = map.bins - 1; b > 0; --b) {
      box.add(bins.box[axis][b]);
      count += bins.count[axis][b];
      right_cost[b] = count != 0 ? box.half_area() * count_cost(count) : -1.0F;
    }
    box = Box{};
    count = 0;
    for (std::size_t b = 0; b + 1 < map.bins; ++b) {
      box.add(bins.box[axis][b]);
      count += bins.count[axis][b];
      if (count == 0 || right_cost[b + 1] < 0) continue;  // an empty side is no split
      const float cost = box.half_area() * count_cost(count) + right_cost[b + 1];
      if (cost < best.cost) best = {cost, axis, static_cast<std::int32_t>(b)};
    }
  }
  return best;
}

class Builder {
 public:
  Builder(std::vector<Reference>& references, std::vector<BinaryNode>& nodes)
      : references_(references), scratch_(references.size() >= kParallelLimit ? references.size() : 0), nodes_(nodes) {}

  void build(std::uint32_t node, std::size_t begin, std::size_t end, const Range& range, std::uint32_t depth) {
    const std::size_t count = end - begin;
    const Box& box = range.box;
    nodes_[node] = {
        {box.lo[0], box.lo[1], box.lo[2]}, static_cast<std::uint32_t>(count), {box.hi[0], box.hi[1], box.hi[2]}, 0};
    if (count == 1) return;
    std::array<Range, 2> children;
    const std::size_t middle = split(begin, end, range, depth, children);
    const auto right = static_cast<std::uint32_t>(node + 2 * (middle - begin));
    if (count > kTaskLimit) {
      tbb::parallel_invoke([&] { build(node + 1, begin, middle, children[0], depth + 1); },
                           [&] { build(right, middle, end, children[1], depth + 1); });
    } else {
      build(node + 1, begin, middle, children[0], depth + 1);
      build(right, middle, end, children[1], depth + 1);
    }
  }

 private:
  /// Reorders [begin, end) and returns where its right part begins, never begin nor end.
  std::size_t split(std::size_t begin, std::size_t end, const Range& range, std::uint32_t depth,
                    std::array<Range, 2>& children) {
    const std::size_t count = end - begin;
    if (depth < kMedianDepth) {
      if (count <= kSweepLimit) return sweep(begin, end, children);
      const BinMap map(range.centroids, count);
      const BinSplit best = best_split(bin(begin, end, map), map);
      if (best.last_left >= 0) {
        const auto is_left = [&](const Reference& r) { return map(centroid2(r))[best.axis] <= best.last_left; };
        return count > kParallelLimit ? partition_parallel(begin, end, is_left, children)
                                      : partition_serial(begin, end, is_left, children);
      }
    }
    const std::size_t middle = begin + count / 2;
    for (std::size_t i = begin; i < end; ++i) children[i < middle ? 0 : 1].add(references_[i]);
    return middle;
  }

  Bins bin(std::size_t begin, std::size_t end, const BinMap& map) const {
    if (end - begin <= kParallelLimit) {
      Bins bins;
      for (std::size_t i = begin; i < end; ++i) bins.add(references_[i], map);
      return bins;
    }
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(begin, end, kChunk), Bins{},
        [&](const tbb::blocked_range<std::size_t>& part, Bins bins) {
          for (std::size_t i = part.begin(); i < part.end(); ++i) bins.add(references_[i], map);
          return bins;
        },
        [](Bins a, const Bins& b) {
          a.add(b);
          return a;
        });
  }

  template <class IsLeft>
  std::size_t partition_serial(std::size_t begin, std::size_t end, const IsLeft& is_left,
                               std::array<Range, 2>& children) {
    std::size_t i = begin, j = end;
    for (;;) {
      while (i < j && is_left(references_[i])) children[0].add(references_[i++]);
      while (i < j && !is_left(references_[j - 1])) children[1].add(references_[--j]);
      if (i >= j) return i;
      std::swap(references_[i], references_[j - 1]);
    }
  }

  template <class IsLeft>
  std::size_t partition_parallel(std::size_t begin, std::size_t end, const IsLeft& is_left,
                                 std::array<Range, 2>& children) {
    const std::size_t chunks = (end - begin + kChunk - 1) / kChunk;
    const auto chunk_end = [&](std::size_t chunk) { return std::min(end, begin + (chunk + 1) * kChunk); };
    std::vector<std::size_t> left_begin(chunks + 1, 0);
    std::vector<std::array<Range, 2>> ranges(chunks);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      for (std::size_t i = begin + chunk * kChunk; i < chunk_end(chunk); ++i) {
        const bool left = is_left(references_[i]);
        left_begin[chunk + 1] += left ? 1 : 0;
        ranges[chunk][left ? 0 : 1].add(references_[i]);
      }
    });
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
      left_begin[chunk + 1] += left_begin[chunk];
      for (std::size_t side = 0; side < 2; ++side) children[side].add(ranges[chunk][side]);
    }
    const std::size_t middle = begin + left_begin[chunks];
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      std::size_t to_left = begin + left_begin[chunk];
      std::size_t to_right = middle + chunk * kChunk - left_begin[chunk];
      for (std::size_t i = begin + chunk * kChunk; i < chunk_end(chunk); ++i) {
        scratch_[is_left(references_[i]) ? to_left++ : to_right++] = references_[i];
      }
    });
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      const auto from = static_cast<std::ptrdiff_t>(begin + chunk * kChunk);
      std::copy(scratch_.begin() + from, scratch_.begin() + static_cast<std::ptrdiff_t>(chunk_end(chunk)),
                references_.begin() + from);
    });
    return middle;
  }

  /// Every split of every axis, in sorted order: bins are too coarse for a handful of triangles.
  std::size_t sweep(std::size_t begin, std::size_t end, std::array<Range, 2>& children) {
    const std::size_t count = end - begin;
    std::array<std::array<std::uint8_t, kSweepLimit>, 3> order{};
    std::array<Float4, kSweepLimit> centroids;
    for (std::size_t i = 0; i < count; ++i) centroids[i] = centroid2(references_[begin + i]);
    float best_cost = std::numeric_limits<float>::infinity();
    std::size_t best_axis = 0, best_left = count / 2;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      auto& sorted = order[axis];
      for (std::size_t i = 0; i < count; ++i) {  // stable insertion
        std::size_t j = i;
        for (; j > 0 && centroids[sorted[j - 1]][axis] > centroids[i][axis]; --j) sorted[j] = sorted[j - 1];
        sorted[j] = static_cast<std::uint8_t>(i);
      }
      std::array<float, kSweepLimit> right_cost{};
      Box box;
      for (std::size_t i = count - 1; i > 0; --i) {
        box.add(references_[begin + sorted[i]].box);
        right_cost[i] = box.half_area() * count_cost(count - i);
      }
      box = Box{};
      for (std::size_t i = 1; i < count; ++i) {
        box.add(references_[begin + sorted[i - 1]].box);
        const float cost = box.half_area() * count_cost(i) + right_cost[i];
        if (cost < best_cost) {
          best_cost = cost;
          best_axis = axis;
          best_left = i;
        }
      }
    }
    std::array<Reference, kSweepLimit> sorted;
    for (std::size_t i = 0; i < count; ++i) sorted[i] = references_[begin + order[best_axis][i]];
    for (std::size_t i = 0; i < count; ++i) {
      references_[begin + i] = sorted[i];
      children[i < best_left ? 0 : 1].add(sorted[i]);
    }
    return begin + best_left;
  }

  std::vector<Reference>& references_;
  std::vector<Reference> scratch_;
  std::vector<BinaryNode>& nodes_;
};

}  // namespace

bool is_degenerate(const float corners[9]) {
  std::array<double, 3> a{}, b{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double p0 = corners[axis];
    a[axis] = static_cast<double>(corners[3 + axis]) - p0;
    b[axis] = static_cast<double>(corners[6 + axis]) - p0;
  }
  const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
  const double area2 = std::abs(x) + std::abs(y) + std::abs(z);
  return !(area2 > 0 && std::isfinite(area2));
}

Box triangle_box(const float corners[9]) {
  Box box;
  for (std::size_t i = 0; i < 9; i += 3) box.add(Float4{corners[i], corners[i + 1], corners[i + 2], 0} + splat4(0));
  return box;
}

BinaryTree build_binary_tree(TriangleSoup triangles) {
  const std::size_t all = triangles.size();
  if (all > Reference::kLimit) {
    throw InputError(
        fmt::format("cannot build a tree over {} triangles: the limit is {}; split the scene", all, Reference::kLimit));
  }
  const std::size_t chunks = (all + kChunk - 1) / kChunk;
  // Degenerate triangles drop out; the others keep their order: count per chunk, then fill.
  std::vector<std::size_t> first(chunks + 1, 0);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    for (std::size_t i = chunk * kChunk; i < std::min(all, (chunk + 1) * kChunk); ++i) {
      first[chunk + 1] += is_degenerate(triangles.corners(i)) ? 0 : 1;
    }
  });
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) first[chunk + 1] += first[chunk];
  const std::size_t count = first[chunks];
  BinaryTree tree;
  if (count == 0) return tree;

  std::vector<Reference> references(count);
  std::vector<Range> ranges(chunks);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    std::size_t to = first[chunk];
    for (std::size_t i = chunk * kChunk; i < std::min(all, (chunk + 1) * kChunk); ++i) {
      if (is_degenerate(triangles.corners(i))) continue;
      references[to].box = triangle_box(triangles.corners(i));
      references[to].set_triangle(static_cast<std::uint32_t>(i));
      ranges[chunk].add(references[to++]);
    }
  });
  Range range;
  for (const Range& r : ranges) range.add(r);

  tree.nodes.resize(2 * count - 1);
  Builder(references, tree.nodes).build(0, 0, count, range, 0);
  tree.triangles.resize(count);
  for (std::size_t i = 0; i < count; ++i) tree.triangles[i] = references[i].triangle();
  return tree;
}

}  // namespace eikon
