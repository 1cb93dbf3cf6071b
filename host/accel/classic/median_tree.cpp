// SPDX-License-Identifier: Apache-2.0
#include "accel/classic/builders.h"

#include <fmt/format.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>

#include "accel/box.h"
#include "core/error.h"

namespace eikon {
namespace {

constexpr std::size_t kMedianParallelLimit = 4096;

/// Puts the lower half of references [begin, end) along the longest axis of their centres before
/// `middle`. Equals are ordered by index, so that the triangles alone decide.
void select(std::vector<Reference>& references, std::size_t begin, std::size_t middle, std::size_t end) {
  Box centres;
  for (std::size_t i = begin; i < end; ++i) centres.add(centroid2(references[i]));
  const Float4 size = centres.hi - centres.lo;
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k) axis = size[k] > size[axis] ? k : axis;
  const auto at = [&](std::size_t i) { return references.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](const Reference& a, const Reference& b) {
    const float x = centroid2(a)[axis], y = centroid2(b)[axis];
    return x < y || (x == y && a.triangle() < b.triangle());
  });
}

/// Writes the subtree of references [begin, end), whose nodes begin at `node`. returns its box
Box build(BinaryTree& tree, std::vector<Reference>& references, std::size_t begin, std::size_t end, std::size_t node) {
  const std::size_t count = end - begin;
  Box box;
  if (count == 1) {
    box = references[begin].box();
    tree.triangles[begin] = references[begin].triangle();
  } else {
    const std::size_t middle = begin + count / 2, right = node + 2 * (count / 2);
    select(references, begin, middle, end);
    Box other;
    const auto first = [&] { box = build(tree, references, begin, middle, node + 1); };
    const auto second = [&] { other = build(tree, references, middle, end, right); };
    if (count >= kMedianParallelLimit)
      tbb::parallel_invoke(first, second);
    else
      first(), second();
    box.add(other);
  }
  tree.nodes[node] = BinaryNode(box, count, begin);
  return box;
}

}  // namespace

/// Each node is split along the longest axis of its triangles' centres, at their median, which
/// quickselect finds [Hoare 1961, algorithm 65]. Like other trees it goes down to single triangles,
/// which layouts join to leaves: bvh2 and bvh4 of at most 4, the others of at most 8. Depth is at
/// most log2(n) + 1.
/// throws InputError for more than 2^28 triangles
/// source [Kay, Kajiya 1986, "Ray tracing complex scenes"]
BinaryTree build_median_tree(TriangleSoup triangles) {
  if (triangles.size() > Reference::kLimit) {
    throw InputError(fmt::format("cannot build a tree over {} triangles: the limit is {}; split the scene",
                                 triangles.size(), Reference::kLimit));
  }
  std::vector<Reference> references;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (is_degenerate(triangles, i)) continue;
    references.emplace_back();
    references.back().set(triangle_box(triangles, i), static_cast<std::uint32_t>(i));
  }
  BinaryTree tree;
  if (references.empty()) return tree;
  tree.nodes.resize(2 * references.size() - 1);
  tree.triangles.resize(references.size());
  build(tree, references, 0, references.size(), 0);
  return tree;
}

}  // namespace eikon
