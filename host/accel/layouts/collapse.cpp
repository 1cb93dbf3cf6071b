// SPDX-License-Identifier: Apache-2.0
#include "accel/layouts/collapse.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>

namespace eikon {
namespace {

constexpr std::uint32_t kTaskLimit = 4096;

}  // namespace

template <std::uint32_t kWidth>
Collapse<kWidth>::Collapse(const BinaryTree& tree, const CollapseCosts& costs)
    : tree_(tree), unit_(costs), rows_(tree.nodes.size() / 2) {
  solve(0);
}

template <std::uint32_t kWidth>
std::vector<WideChild> Collapse<kWidth>::children(std::uint32_t n) const {
  std::vector<WideChild> list;
  list.reserve(kWidth);
  if (is_leaf(n)) {
    list.push_back({n, true});  // a root that is itself one leaf
  } else {
    const Division d = divide(n, kWidth);
    collect(left_child(n), d.left, list);
    collect(right_child(tree_, n), kWidth - d.left, list);
  }
  for (std::size_t i = 1; i < list.size(); ++i) {  // insertion sort, because std::stable_sort allocates
    const WideChild each = list[i];
    std::size_t at = i;
    for (; at > 0 && area(each.binary) < area(list[at - 1].binary); --at) list[at] = list[at - 1];
    list[at] = each;
  }
  return list;
}

template <std::uint32_t kWidth>
auto Collapse<kWidth>::divide(std::uint32_t n, std::uint32_t k) const -> Division {
  const Row left = row(left_child(n)), right = row(right_child(tree_, n));
  Division best{std::numeric_limits<float>::infinity()};
  for (std::uint32_t i = 1; i < k; ++i) {
    const float c = left[i - 1] + right[k - i - 1];
    if (best.left == 0 || c < best.cost) best = {c, i};
  }
  return best;
}

template <std::uint32_t kWidth>
void Collapse<kWidth>::solve(std::uint32_t n) {
  const std::uint32_t count = tree_.nodes[n].count;
  if (count > kTaskLimit) {
    tbb::parallel_invoke([&] { solve(left_child(n)); }, [&] { solve(right_child(tree_, n)); });
    solve_one(n);
  } else {
    // In depth-first order every child comes after its parent.
    for (std::uint32_t i = n + 2 * count - 1; i-- > n;) solve_one(i);
  }
}

template <std::uint32_t kWidth>
void Collapse<kWidth>::solve_one(std::uint32_t n) {
  const BinaryNode& node = tree_.nodes[n];
  if (node.count == 1) return;
  Row best;
  const std::uint32_t l = left_child(n), r = right_child(tree_, n);
  if (node.count == 2) {
    best.fill(leaf_cost(l) + leaf_cost(r));
  } else {
    // Tries every division for every k at once: with i roots on the left the right child's row is
    // shifted by i entries.
    constexpr float infinity = std::numeric_limits<float>::infinity();
    const Row left = row(l), right = row(r);
    std::array<float, 2 * kWidth> moved;
    std::fill_n(moved.begin(), kWidth, infinity);
    std::copy(right.begin(), right.end(), moved.begin() + kWidth);
    best.fill(infinity);
    for (std::uint32_t i = 1; i < kWidth; ++i) {
      for (std::size_t k = 0; k < kWidth; k += 4) {
        const Float4 c = load4(moved.data() + kWidth - i + k) + splat4(left[i - 1]);
        store4(best.data() + k, min4(c, load4(best.data() + k)));
      }
    }
  }
  best[0] = std::min(leaf_cost(n), area(n) * unit_.node + best[kWidth - 1]);
  for (std::uint32_t k = 1; k < kWidth; ++k) best[k] = std::min(best[k], best[k - 1]);  // more roots are never worse
  rows_[n - node.first] = best;
}

template <std::uint32_t kWidth>
void Collapse<kWidth>::collect(std::uint32_t n, std::uint32_t k, std::vector<WideChild>& list) const {
  while (k > 1 && cost(n, k) == cost(n, k - 1)) --k;
  if (k == 1) {
    list.push_back({n, is_leaf(n)});
    return;
  }
  const Division d = divide(n, k);
  collect(left_child(n), d.left, list);
  collect(right_child(tree_, n), k - d.left, list);
}

template class Collapse<4>;
template class Collapse<8>;
template class Collapse<16>;

}  // namespace eikon
