// SPDX-License-Identifier: Apache-2.0
#include "accel/refit.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <limits>
#include <utility>
#include <vector>

#include "accel/binary_tree.h"
#include "accel/layouts/layouts.h"
#include "accel/reinsertion.h"

namespace eikon {
namespace {

constexpr std::uint32_t kInfinity = 0x7f800000U;

/// The places in a node of its children's planes and words, which depend on the layout.
struct NodeShape {
  std::size_t width = 2, words = 16;
  [[nodiscard]] bool is_wide() const { return width > 2; }
  [[nodiscard]] std::size_t lo(std::size_t child, std::size_t axis) const {
    return is_wide() ? 2 * width * axis + child : 6 * child + axis;
  }
  [[nodiscard]] std::size_t hi(std::size_t child, std::size_t axis) const {
    return is_wide() ? (2 * axis + 1) * width + child : 6 * child + 3 + axis;
  }
  [[nodiscard]] std::size_t link(std::size_t child) const { return (is_wide() ? 6 * width : 12) + child; }
};

/// Nothing for trees that cannot be refitted.
std::optional<NodeShape> shape_of(const Accel& tree) {
  const bool is_plain = tree.instances.empty() && tree.motion_nodes.empty();
  if (!is_plain) return std::nullopt;
  if (tree.layout == "bvh2") return NodeShape{};
  if (tree.layout == "bvh8") return NodeShape{.width = 8, .words = 64};
  if (tree.layout == "bvh16") return NodeShape{.width = 16, .words = 128};
  return std::nullopt;
}

/// A child that is not there has planes at infinity.
bool is_missing(const Accel& tree, const NodeShape& shape, std::size_t node, std::size_t child) {
  return tree.nodes[node * shape.words + shape.lo(child, 0)] == kInfinity;
}

Box child_box(const Accel& tree, const NodeShape& shape, std::size_t node, std::size_t child) {
  const std::uint32_t* const words = tree.nodes.data() + node * shape.words;
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lo[int(axis)] = std::bit_cast<float>(words[shape.lo(child, axis)]);
    box.hi[int(axis)] = std::bit_cast<float>(words[shape.hi(child, axis)]);
  }
  return box;
}

class Refitter {
 public:
  Refitter(Accel& tree, const NodeShape& shape, TriangleSoup triangles)
      : tree_(tree), shape_(shape), triangles_(triangles) {}

  /// returns  false if the tree does not have exactly the triangles that can be hit
  [[nodiscard]] bool has_all() const {
    std::vector<char> has(triangles_.size(), 0);
    bool known = true;
    const auto mark = [&](std::uint32_t triangle) {
      known = known && triangle < has.size();
      if (known) has[triangle] = 1;
    };
    if (shape_.is_wide()) {
      for (std::size_t block = 0; block + kBlockWords <= tree_.leaves.size(); block += kBlockWords)
        for (std::size_t i = 0; i < kBlock; ++i)
          if (const std::uint32_t triangle = tree_.leaves[block + kBlockTriangles + i]; triangle != EK_NO_HIT)
            mark(triangle);
    } else {
      for (const std::uint32_t triangle : tree_.leaves) mark(triangle);
    }
    for (std::size_t i = 0; i < has.size() && known; ++i) known = (has[i] != 0) != is_degenerate(triangles_, i);
    return known;
  }

  void fit() {
    if (shape_.is_wide())
      tbb::parallel_for(std::size_t{0}, tree_.leaves.size() / kBlockWords, [&](std::size_t b) { fit_block(b); });
    std::vector<Box> of_node(tree_.nodes.size() / shape_.words);
    for (std::size_t n = of_node.size(); n-- > 0;)  // children come after their parents
      for (std::size_t child = 0; child < shape_.width; ++child) {
        if (is_missing(tree_, shape_, n, child)) continue;
        const std::uint32_t link = tree_.nodes[n * shape_.words + shape_.link(child)];
        const Box box = (link & kLeafBit) == 0 ? of_node[link] : leaf_box(link & ~kLeafBit);
        write(n, child, box);
        of_node[n].add(box);
      }
  }

 private:
  void fit_block(std::size_t block) {
    std::uint32_t* const words = tree_.leaves.data() + block * kBlockWords;
    for (std::size_t i = 0; i < kBlock; ++i) {
      const std::uint32_t triangle = words[kBlockTriangles + i];
      if (triangle == EK_NO_HIT) continue;
      for (std::size_t k = 0; k < 9; ++k)
        words[kBlock * k + i] = std::bit_cast<std::uint32_t>(triangles_.corners(triangle)[k]);
    }
  }

  [[nodiscard]] Box leaf_box(std::uint32_t leaf) const {
    Box box;
    if (shape_.is_wide()) {
      for (std::size_t i = 0; i < kBlock; ++i)
        if (const std::uint32_t triangle = tree_.leaves[std::size_t{leaf} * kBlockWords + kBlockTriangles + i];
            triangle != EK_NO_HIT)
          box.add(triangle_box(triangles_, triangle));
      return box;
    }
    const std::uint32_t first = leaf & ((1U << kCountShift) - 1), count = (leaf >> kCountShift & 7U) + 1;
    for (std::uint32_t i = first; i < first + count; ++i) box.add(triangle_box(triangles_, tree_.leaves[i]));
    return box;
  }

  void write(std::size_t node, std::size_t child, const Box& box) {
    std::uint32_t* const words = tree_.nodes.data() + node * shape_.words;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      words[shape_.lo(child, axis)] = std::bit_cast<std::uint32_t>(float{box.lo[int(axis)]});
      words[shape_.hi(child, axis)] = std::bit_cast<std::uint32_t>(float{box.hi[int(axis)]});
    }
  }

  Accel& tree_;
  const NodeShape& shape_;
  TriangleSoup triangles_;
};

}  // namespace

double tree_area(const Accel& tree) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const std::optional<NodeShape> shape = shape_of(tree);
  if (!shape) return kNone;
  Box root;
  double sum = 0;
  for (std::size_t n = 0; n < tree.nodes.size() / shape->words; ++n)
    for (std::size_t child = 0; child < shape->width; ++child) {
      if (is_missing(tree, *shape, n, child)) continue;
      const Box box = child_box(tree, *shape, n, child);
      if (n == 0) root.add(box);
      sum += double{box.half_area()};
    }
  return sum > 0 && root.half_area() > 0 ? sum / double{root.half_area()} : kNone;
}

std::optional<Accel> refit(const Accel& tree, TriangleSoup triangles) {
  const std::optional<NodeShape> shape = shape_of(tree);
  if (!shape || tree.node_count == 0) return std::nullopt;
  Accel fitted = tree;
  Refitter refitter(fitted, *shape, triangles);
  if (!refitter.has_all()) return std::nullopt;
  refitter.fit();
  return fitted;
}

Accel TreeMemory::tree(TriangleSoup triangles, const AccelOptions& options) {
  const std::string key = fmt::format("{} {} {}", options.accel, options.layout,
                                      reinsertion_pays(triangles.size(), options.rays) ? "improved" : "");
  std::shared_ptr<const Built> built;
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = built_.find(key); found != built_.end()) built = found->second;
  }
  if (built != nullptr) {
    const auto start = std::chrono::steady_clock::now();
    tbb::task_arena arena(arena_size(options));
    std::optional<Accel> fitted = arena.execute([&] { return refit(built->tree, triangles); });
    if (fitted && tree_area(*fitted) <= kMaxRefitCost * built->area) {
      fitted->build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      return *std::move(fitted);
    }
  }
  Accel fresh = build_accel(triangles, options);
  if (shape_of(fresh)) {
    const auto kept = std::make_shared<const Built>(Built{fresh, tree_area(fresh)});
    const std::lock_guard lock(mutex_);
    built_[key] = kept;
  }
  return fresh;
}

}  // namespace eikon
