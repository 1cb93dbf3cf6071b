// SPDX-License-Identifier: Apache-2.0
#include "accel/binary_tree.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "accel/bins.h"
#include "core/error.h"

namespace eikon {
namespace {

constexpr std::size_t kTaskLimit = 4096;          // references of a subtree that is one task
constexpr std::size_t kParallelLimit = 1U << 16;  // beyond it, one node is binned and partitioned in parallel
constexpr std::size_t kChunk = 1U << 14;          // of that work; fixed, so that the tree is the same with any threads
constexpr std::uint32_t kMedianDepth = 64;        // deeper nodes are halved, which bounds the depth

using References = BigVector<Reference>;

/// Boxes of twice the centroids left and right of a plane.
struct Sides {
  std::array<Box, 2> centroids;
  void add(Float4 c, bool right) {
    // A lane of ones is NaN, which min4 and max4 ignore. This costs less than a mispredicted
    // branch.
    const Int4 mask = Int4{} - static_cast<std::int32_t>(right);
    const auto to_left = std::bit_cast<Float4>(std::bit_cast<Int4>(c) | mask);
    const auto to_right = std::bit_cast<Float4>(std::bit_cast<Int4>(c) | ~mask);
    centroids[0].lo = min4(to_left, centroids[0].lo);
    centroids[0].hi = max4(to_left, centroids[0].hi);
    centroids[1].lo = min4(to_right, centroids[1].lo);
    centroids[1].hi = max4(to_right, centroids[1].hi);
  }
};

/// Builds subtrees of a few triangles from every split of every axis in sorted order, because bins
/// are too coarse for them.
class SmallTree {
 public:
  static constexpr std::size_t kLimit = 32;

  /// Sorts references[0, count), count <= kLimit, along each axis. triangles: the tree's
  SmallTree(const Reference* references, std::size_t count, std::uint32_t* triangles);

  /// Writes the subtree of all references to nodes[0, 2 * count - 1). box: of all; first: index of
  /// its first triangle
  void build(BinaryNode* nodes, std::size_t first, const Box& box) {
    first_ = first;
    build(nodes, 0, count_, box);
  }

 private:
  using Order = std::array<std::uint8_t, kLimit>;
  void build(BinaryNode* nodes, std::size_t begin, std::size_t end, const Box& box);
  void divide(std::size_t begin, std::size_t end, std::size_t axis, std::size_t middle);

  const Reference* references_;
  std::size_t count_, first_ = 0;
  std::uint32_t* triangles_;
  std::array<Order, 3> order_{};
};

SmallTree::SmallTree(const Reference* references, std::size_t count, std::uint32_t* triangles)
    : references_(references), count_(count), triangles_(triangles) {
  // Counts the rank of each reference along the three axes at once. Equals keep their order.
  std::array<Float4, kLimit> centroids;
  std::array<Int4, kLimit> rank;
  for (std::size_t i = 0; i < count; ++i) {
    const Float4 c = centroid2(references[i]);
    Int4 below{};
    for (std::size_t j = 0; j < i; ++j) {
      const Int4 lower = c < centroids[j];  // -1 where true
      rank[j] -= lower;
      below += 1 + lower;
    }
    centroids[i] = c;
    rank[i] = below;
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      order_[axis][static_cast<std::size_t>(rank[i][axis])] = static_cast<std::uint8_t>(i);
    }
  }
}

void SmallTree::build(BinaryNode* nodes, std::size_t begin, std::size_t end, const Box& box) {
  const std::size_t count = end - begin;
  *nodes = BinaryNode(box, count, first_ + begin);
  if (count == 1) {
    triangles_[first_ + begin] = references_[order_[0][begin]].triangle();
    return;
  }
  std::size_t axis = 0, middle = begin + 1;
  if (count > 2) {
    const auto add = [&](Box3& boxes, std::size_t i) {
      for (std::size_t a = 0; a < 3; ++a) boxes[a].add(references_[order_[a][i]].box());
    };
    std::array<Float4, kLimit> right_cost;
    Box3 boxes;
    Int4 n{};
    for (std::size_t i = end - 1; i > begin; --i) {
      add(boxes, i);
      right_cost[i] = half_areas(boxes) * count_costs(n += 1);
    }
    boxes = Box3{};
    n = Int4{};
    Float4 best_cost = splat4(std::numeric_limits<float>::infinity());
    Int4 best_middle = Int4{} + static_cast<std::int32_t>(begin + count / 2);
    for (std::size_t i = begin + 1; i < end; ++i) {
      add(boxes, i - 1);
      const Float4 cost = half_areas(boxes) * count_costs(n += 1) + right_cost[i];
      const Int4 better = cost < best_cost;
      best_cost = better ? cost : best_cost;
      best_middle = better ? Int4{} + static_cast<std::int32_t>(i) : best_middle;
    }
    for (std::size_t a = 1; a < 3; ++a) axis = best_cost[a] < best_cost[axis] ? a : axis;
    middle = static_cast<std::size_t>(best_middle[axis]);
  }
  Box left, right;
  for (std::size_t i = begin; i < middle; ++i) left.add(references_[order_[axis][i]].box());
  for (std::size_t i = middle; i < end; ++i) right.add(references_[order_[axis][i]].box());
  divide(begin, end, axis, middle);
  build(nodes + 1, begin, middle, left);
  build(nodes + 2 * (middle - begin), middle, end, right);
}

/// References before `middle` in the order along `axis` come first in the other orders too, which
/// stay sorted on both sides.
void SmallTree::divide(std::size_t begin, std::size_t end, std::size_t axis, std::size_t middle) {
  std::uint32_t is_left = 0;
  for (std::size_t i = begin; i < middle; ++i) is_left |= 1U << order_[axis][i];
  for (std::size_t a = 0; a < 3; ++a) {
    if (a == axis) continue;
    Order right;
    std::size_t lefts = begin, rights = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint8_t each = order_[a][i];
      const std::uint32_t left = is_left >> each & 1U;
      order_[a][lefts] = right[rights] = each;
      lefts += left;
      rights += 1 - left;
    }
    for (std::size_t i = 0; i < rights; ++i) order_[a][lefts + i] = right[i];
  }
}

/// A node to be built, of the references [begin, end).
struct Job {
  std::uint32_t node;
  std::size_t begin, end;
  Box box, centroids;  // of twice the centroids
  std::uint32_t depth;
  [[nodiscard]] std::size_t count() const { return end - begin; }
};

class Builder {
 public:
  explicit Builder(BinaryTree& tree) : tree_(tree) {}

  /// `from` holds the references. `to` is as large and unset; large nodes move references between
  /// the two.
  void build(const Job& job, Reference* from, Reference* to) {
    if (job.count() <= SmallTree::kLimit && job.depth < kMedianDepth) {
      SmallTree(from + job.begin, job.count(), tree_.triangles.data())
          .build(tree_.nodes.data() + job.node, job.begin, job.box);
      return;
    }
    tree_.nodes[job.node] = BinaryNode(job.box, job.count(), job.begin);
    if (job.count() == 1) {
      tree_.triangles[job.begin] = from[job.begin].triangle();
      return;
    }
    std::array<Job, 2> children = split(job, from, to);
    if (job.count() > kTaskLimit) {
      tbb::parallel_invoke([&] { build(children[0], from, to); }, [&] { build(children[1], from, to); });
    } else {
      for (const Job& child : children) build(child, from, to);
    }
  }

 private:
  /// Reorders the references, and swaps `from` and `to` if they have moved.
  std::array<Job, 2> split(const Job& job, Reference*& from, Reference*& to) {
    if (job.depth < kMedianDepth) {
      const BinMap map(job.centroids, job.count());
      if (job.count() > kParallelLimit) {
        std::array<Job, 2> children;
        if (split_parallel(job, map, from, to, children)) {
          std::swap(from, to);
          return children;
        }
      } else {
        Bins bins(map.bins);
        for (std::size_t i = job.begin; i < job.end; ++i) bins.add(from[i], map);
        const BinSplit split = bins.best_split(map.bins);
        if (std::isfinite(split.cost)) {
          Sides sides;
          const std::size_t middle = partition(from, job.begin, job.end, split.plane(map), sides);
          return jobs(job, middle, split.boxes, sides.centroids);
        }
      }
    }
    const std::size_t middle = job.begin + job.count() / 2;
    std::array<Box, 2> boxes;
    Sides sides;
    for (std::size_t i = job.begin; i < job.end; ++i) {
      boxes[i < middle ? 0 : 1].add(from[i].box());
      sides.add(centroid2(from[i]), i >= middle);
    }
    return jobs(job, middle, boxes, sides.centroids);
  }

  static std::array<Job, 2> jobs(const Job& job, std::size_t middle, const std::array<Box, 2>& boxes,
                                 const std::array<Box, 2>& centroids) {
    const auto right = static_cast<std::uint32_t>(job.node + 2 * (middle - job.begin));
    return {Job{job.node + 1, job.begin, middle, boxes[0], centroids[0], job.depth + 1},
            Job{right, middle, job.end, boxes[1], centroids[1], job.depth + 1}};
  }

  /// Swaps each reference with the first of the right side, whichever side it is on, which avoids a
  /// branch.
  static std::size_t partition(Reference* references, std::size_t begin, std::size_t end, const BinPlane& plane,
                               Sides& sides) {
    std::size_t middle = begin;
    for (std::size_t i = begin; i < end; ++i) {
      const Reference r = references[i];
      const bool right = plane.is_right(references[i]);
      sides.add(centroid2(r), right);
      references[i] = references[middle];
      references[middle] = r;
      middle += right ? 0 : 1;
    }
    return middle;
  }

  /// Returns false, and does nothing, if no plane separates the centroids.
  static bool split_parallel(const Job& job, const BinMap& map, const Reference* from, Reference* to,
                             std::array<Job, 2>& children) {
    const std::size_t chunks = (job.count() + kChunk - 1) / kChunk;
    const auto chunk_begin = [&](std::size_t chunk) { return job.begin + chunk * kChunk; };
    const auto chunk_end = [&](std::size_t chunk) { return std::min(job.end, chunk_begin(chunk + 1)); };
    std::vector<Bins> bins(chunks, Bins(map.bins));
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      for (std::size_t i = chunk_begin(chunk); i < chunk_end(chunk); ++i) bins[chunk].add(from[i], map);
    });
    Bins all(map.bins);
    for (const Bins& each : bins) all.add(each, map.bins);
    const BinSplit split = all.best_split(map.bins);
    if (!std::isfinite(split.cost)) return false;

    std::vector<std::size_t> left_begin(chunks + 1, job.begin);
    for (std::size_t i = 0; i < chunks; ++i) left_begin[i + 1] = left_begin[i] + bins[i].count_left(split);
    const std::size_t middle = left_begin[chunks];
    std::vector<Sides> sides(chunks);
    const BinPlane plane = split.plane(map);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      std::array<std::size_t, 2> next{left_begin[chunk], middle + chunk_begin(chunk) - left_begin[chunk]};
      Sides mine;
      for (std::size_t i = chunk_begin(chunk); i < chunk_end(chunk); ++i) {
        const bool right = plane.is_right(from[i]);
        to[next[right ? 1 : 0]++] = from[i];
        mine.add(centroid2(from[i]), right);
      }
      sides[chunk] = mine;
    });
    std::array<Box, 2> centroids;
    for (const Sides& each : sides) {
      for (std::size_t side = 0; side < 2; ++side) centroids[side].add(each.centroids[side]);
    }
    children = jobs(job, middle, split.boxes, centroids);
    return true;
  }

  BinaryTree& tree_;
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

Box triangle_box(const TriangleSoup& soup, std::size_t i) {
  const float* const p = soup.corners(i);
  if (!soup.is_box(i)) return triangle_box(p);
  return {Float4{p[0], p[1], p[2], 0} + splat4(0), Float4{p[3], p[4], p[5], 0} + splat4(0)};
}

BinaryTree build_binary_tree(TriangleSoup triangles) {
  const std::size_t all = triangles.size();
  if (all > Reference::kLimit) {
    throw InputError(
        fmt::format("cannot build a tree over {} triangles: the limit is {}; split the scene", all, Reference::kLimit));
  }
  const std::size_t chunks = (all + kChunk - 1) / kChunk;
  // Leaves out degenerate triangles and keeps the order of the others: counts per chunk first, then
  // fills.
  std::vector<std::size_t> first(chunks + 1, 0);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    for (std::size_t i = chunk * kChunk; i < std::min(all, (chunk + 1) * kChunk); ++i) {
      first[chunk + 1] += is_degenerate(triangles, i) ? 0 : 1;
    }
  });
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) first[chunk + 1] += first[chunk];
  const std::size_t count = first[chunks];
  BinaryTree tree;
  if (count == 0) return tree;

  References references(count), scratch(count > kParallelLimit ? count : 0);
  std::vector<std::array<Box, 2>> boxes(chunks);  // of the triangles, and of twice their centroids
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    std::size_t to = first[chunk];
    for (std::size_t i = chunk * kChunk; i < std::min(all, (chunk + 1) * kChunk); ++i) {
      if (is_degenerate(triangles, i)) continue;
      const Box box = triangle_box(triangles, i);
      references[to++].set(box, static_cast<std::uint32_t>(i));
      boxes[chunk][0].add(box);
      boxes[chunk][1].add(box.lo + box.hi);
    }
  });
  Job root{0, 0, count, {}, {}, 0};
  for (const auto& each : boxes) {
    root.box.add(each[0]);
    root.centroids.add(each[1]);
  }
  tree.nodes.resize(2 * count - 1);
  tree.triangles.resize(count);
  Builder(tree).build(root, references.data(), scratch.data());
  return tree;
}

}  // namespace eikon
