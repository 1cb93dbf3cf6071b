// SPDX-License-Identifier: Apache-2.0
#include "accel/collapse.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <limits>

namespace eikon {
namespace {

constexpr std::uint32_t kTaskLimit = 4096;

}  // namespace

template <std::uint32_t kWidth>
Collapse<kWidth>::Collapse(const BinaryTree& tree, const CollapseCosts& costs)
    : tree_(tree), unit_(costs), costs_(tree.nodes.size()) {
  solve(0);
}

template <std::uint32_t kWidth>
std::vector<WideChild> Collapse<kWidth>::children(std::uint32_t n) const {
  std::vector<WideChild> list;
  if (is_leaf(n)) {
    list.push_back({n, true});  // only a root that is itself one leaf
  } else {
    const Division d = divide(n, kWidth);
    collect(left_child(n), d.left, list);
    collect(right_child(tree_, n), kWidth - d.left, list);
  }
  std::stable_sort(list.begin(), list.end(),
                   [&](const WideChild& a, const WideChild& b) { return area(a.binary) < area(b.binary); });
  return list;
}

template <std::uint32_t kWidth>
float Collapse<kWidth>::leaf_cost(std::uint32_t n) const {
  const std::uint32_t count = tree_.nodes[n].count;
  return count <= unit_.leaf_limit ? area(n) * (unit_.leaf + unit_.triangle * static_cast<float>(count))
                                   : std::numeric_limits<float>::infinity();
}

template <std::uint32_t kWidth>
auto Collapse<kWidth>::divide(std::uint32_t n, std::uint32_t k) const -> Division {
  const std::uint32_t left = left_child(n), right = right_child(tree_, n);
  Division best{std::numeric_limits<float>::infinity()};
  for (std::uint32_t i = 1; i < k; ++i) {
    const float c = cost(left, i) + cost(right, k - i);
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
    // Depth-first order: every child lies behind its parent.
    for (std::uint32_t i = n + 2 * count - 1; i-- > n;) solve_one(i);
  }
}

template <std::uint32_t kWidth>
void Collapse<kWidth>::solve_one(std::uint32_t n) {
  auto& costs = costs_[n];
  if (tree_.nodes[n].count == 1) {
    costs.fill(leaf_cost(n));
    return;
  }
  costs[0] = std::min(leaf_cost(n), area(n) * unit_.node + divide(n, kWidth).cost);
  for (std::uint32_t k = 2; k < kWidth; ++k) costs[k - 1] = std::min(costs[k - 2], divide(n, k).cost);
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

std::uint32_t first_of(const BinaryTree& tree, std::uint32_t ancestor, std::uint32_t node) {
  std::uint32_t first = 0;
  while (ancestor != node) {
    const std::uint32_t right = right_child(tree, ancestor);
    if (node >= right) first += tree.nodes[left_child(ancestor)].count;
    ancestor = node >= right ? right : left_child(ancestor);
  }
  return first;
}

}  // namespace eikon
