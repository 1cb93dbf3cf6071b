// SPDX-License-Identifier: Apache-2.0
#include "accel/reinsertion.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace eikon {
namespace {

constexpr std::uint32_t kUnit = 8;    // triangles of a subtree that stays whole
constexpr std::size_t kPart = 10;     // a round tries one of this many nodes
constexpr int kRounds = 8;            // most rounds
constexpr double kRoundGain = 0.005;  // of the area: a round that gains less is the last
constexpr double kMinGain = 0.01;     // of the area: with less the tree stays as it was
constexpr std::uint32_t kDepth = 64;  // + log2(triangles)

constexpr std::size_t kVisits = 1024;  // most nodes of a search, because overlapping subtrees defeat its bounds
constexpr double kLargestArea = 1e30;  // up to here float sums of areas stay finite

/// A node of a tree that changes: siblings lie at 2k + 1 and 2k + 2, the root at 0.
struct Link {
  static constexpr std::uint32_t kUnitBit = 0x80000000U;
  float lo[3];
  std::uint32_t down;  // the first child, or kUnitBit and a node of the binary tree whose subtree stays whole
  float hi[3];
  std::uint32_t up;
  [[nodiscard]] bool is_unit() const { return (down & kUnitBit) != 0; }
  [[nodiscard]] std::uint32_t unit() const { return down & ~kUnitBit; }
  [[nodiscard]] Box box() const { return {Float4{lo[0], lo[1], lo[2], 0}, Float4{hi[0], hi[1], hi[2], 0}}; }
  [[nodiscard]] float area() const { return box().half_area(); }
  void set(const Box& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lo[axis] = box.lo[axis];
      hi[axis] = box.hi[axis];
    }
  }
};

std::uint32_t sibling(std::uint32_t n) { return ((n - 1) ^ 1U) + 1; }

struct Move {
  std::uint32_t from = 0, to = 0;  // the subtree, and its new sibling
  float gain = 0;                  // area saved
};

class Reinsertion {
 public:
  explicit Reinsertion(const BinaryTree& tree) : tree_(tree) {
    links_.reserve(tree.nodes.size() / 2);
    links_.resize(1);
    links_[0].up = 0;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> todo{{0, 0}};  // binary node, link
    while (!todo.empty()) {
      const auto [node, to] = todo.back();
      todo.pop_back();
      links_[to].set(tree.nodes[node].box());
      if (tree.nodes[node].count <= kUnit) {
        links_[to].down = Link::kUnitBit | node;
        continue;
      }
      const auto down = static_cast<std::uint32_t>(links_.size());
      links_.resize(down + 2);
      links_[to].down = down;
      links_[down].up = links_[down + 1].up = to;
      todo.emplace_back(right_child(tree, node), down + 1);
      todo.emplace_back(left_child(node), down);
    }
  }

  /// The sum of the areas, which is minimised.
  [[nodiscard]] double area() const {
    double sum = 0;
    for (const Link& link : links_) sum += static_cast<double>(link.area());
    return sum;
  }

  void round() {
    std::vector<Move> moves(candidates());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, moves.size(), 64), [&](const auto& part) {
      Stack stack;
      for (std::size_t i = part.begin(); i < part.end(); ++i) moves[i] = best_move(moves[i].from, stack);
    });
    std::erase_if(moves, [](const Move& move) { return !(move.gain > 0); });
    std::sort(moves.begin(), moves.end(),
              [](const Move& a, const Move& b) { return a.gain > b.gain || (a.gain == b.gain && a.from < b.from); });
    std::vector<bool> touched(links_.size());  // an earlier move makes those next to it stale
    for (const Move& move : moves) {
      const std::array<std::uint32_t, 5> near{move.to, move.from, sibling(move.from), links_[move.to].up,
                                              links_[move.from].up};
      if (std::any_of(near.begin(), near.end(), [&](std::uint32_t n) { return touched[n]; })) continue;
      for (const std::uint32_t n : near) touched[n] = true;
      apply(move);
    }
  }

  /// The tree in its present form; empty if it is too deep.
  [[nodiscard]] BinaryTree tree() const {
    std::vector<std::uint32_t> order{0}, depth(links_.size(), 0), count(links_.size());
    for (std::size_t i = 0; i < order.size(); ++i) {  // parents first
      const std::uint32_t n = order[i];
      if (links_[n].is_unit()) continue;
      for (std::uint32_t child = links_[n].down; child < links_[n].down + 2; ++child) {
        order.push_back(child);
        depth[child] = depth[n] + 1;
      }
    }
    for (std::size_t i = order.size(); i-- > 0;) {
      const Link& link = links_[order[i]];
      count[order[i]] = link.is_unit() ? tree_.nodes[link.unit()].count : count[link.down] + count[link.down + 1];
    }
    const auto log2 = static_cast<std::uint32_t>(std::bit_width(tree_.triangles.size()));
    if (*std::max_element(depth.begin(), depth.end()) + kUnit > kDepth + log2) return {};

    BinaryTree out;
    out.nodes.resize(tree_.nodes.size());
    out.triangles.resize(tree_.triangles.size());
    std::vector<std::array<std::uint32_t, 3>> units;  // binary node from, to, first triangle
    std::vector<std::uint32_t> todo{0};
    std::uint32_t to = 0, first = 0;
    while (!todo.empty()) {
      const std::uint32_t n = todo.back();
      todo.pop_back();
      const Link& link = links_[n];
      if (link.is_unit()) {
        units.push_back({link.unit(), to, first});
        to += 2 * count[n] - 1;
        first += count[n];
      } else {
        out.nodes[to++] = BinaryNode(link.box(), count[n], first);
        todo.push_back(link.down + 1);
        todo.push_back(link.down);
      }
    }
    tbb::parallel_for(std::size_t{0}, units.size(), [&](std::size_t i) {
      const auto [node, node_to, first_to] = units[i];
      const std::uint32_t n = tree_.nodes[node].count, first_from = tree_.nodes[node].first;
      for (std::uint32_t k = 0; k < 2 * n - 1; ++k) {
        out.nodes[node_to + k] = tree_.nodes[node + k];
        out.nodes[node_to + k].first += first_to - first_from;
      }
      for (std::uint32_t k = 0; k < n; ++k) out.triangles[first_to + k] = tree_.triangles[first_from + k];
    });
    return out;
  }

 private:
  using Stack = std::vector<std::pair<float, std::uint32_t>>;

  /// The largest nodes, in the order of their numbers.
  [[nodiscard]] std::vector<Move> candidates() const {
    std::vector<std::pair<float, std::uint32_t>> all(links_.size() - 1);
    for (std::uint32_t n = 1; n < links_.size(); ++n) all[n - 1] = {-links_[n].area(), n};
    const std::size_t kept = std::min(all.size(), all.size() / kPart + 4096);
    if (kept < all.size()) std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(kept), all.end());
    all.resize(kept);
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    std::vector<Move> moves(kept);
    for (std::size_t i = 0; i < kept; ++i) moves[i].from = all[i].second;
    return moves;
  }

  /// Searches the siblings' subtrees of all ancestors, with bounds. `saved` is the area that the
  /// removal saves, less the area that the insertion costs down to the current node. [Meister,
  /// Bittner 2018, algorithm 1]
  [[nodiscard]] Move best_move(std::uint32_t from, Stack& stack) const {
    Move best{from, 0, 0};
    const Box box = links_[from].box();
    const float own = box.half_area();  // every insertion costs this at least
    const std::uint32_t parent = links_[from].up;
    float saved = links_[parent].area();
    std::uint32_t other = sibling(from), pivot = parent;
    Box pivot_box = links_[other].box();  // without the subtree
    std::size_t visits = 0;
    while (visits < kVisits) {
      stack.clear();
      stack.emplace_back(saved, other);
      while (!stack.empty() && ++visits < kVisits) {
        const auto [saved_here, to] = stack.back();
        stack.pop_back();
        if (saved_here - own <= best.gain) continue;
        Box merged = links_[to].box();
        const float area = merged.half_area();
        merged.add(box);
        const float gain = saved_here - merged.half_area();
        if (gain > best.gain) {
          best.gain = gain;
          best.to = to;
        }
        if (!links_[to].is_unit() && gain + area - own > best.gain) {
          stack.emplace_back(gain + area, links_[to].down);
          stack.emplace_back(gain + area, links_[to].down + 1);
        }
      }
      if (pivot != parent) {
        pivot_box.add(links_[other].box());
        saved += links_[pivot].area() - pivot_box.half_area();
      }
      if (pivot == 0) break;
      other = sibling(pivot);
      pivot = links_[pivot].up;
    }
    if (best.to == sibling(from) || best.to == parent) best.gain = 0;  // the subtree is there already
    return best;
  }

  void apply(const Move& move) {
    const std::uint32_t other = sibling(move.from), parent = links_[move.from].up;
    const Link other_link = links_[other], to_link = links_[move.to];
    const auto put = [&](std::uint32_t at, const Link& link) {
      const std::uint32_t up = links_[at].up;
      links_[at] = link;
      links_[at].up = up;
      if (!link.is_unit()) links_[link.down].up = links_[link.down + 1].up = at;
    };
    put(parent, other_link);  // the sibling moves up and leaves its slot to the new one
    put(other, to_link);
    links_[move.to].down = std::min(other, move.from);
    links_[other].up = links_[move.from].up = move.to;
    refit(move.to);
    refit(links_[parent].up);
  }

  void refit(std::uint32_t n) {
    for (;; n = links_[n].up) {
      if (!links_[n].is_unit()) {
        Box box = links_[links_[n].down].box();
        box.add(links_[links_[n].down + 1].box());
        links_[n].set(box);
      }
      if (n == 0) return;
    }
  }

  const BinaryTree& tree_;
  BigVector<Link> links_;
};

// Measured on one core. A round tries at least 4096 subtrees, so that reinsertion takes 350 ns for
// each of the first 40,000 triangles and 60 ns for others. A ray takes 50 to 150 ns, of which 0 to
// 7 % are saved. More cores shorten both alike.
constexpr double kFirst = 40'000, kFirstNs = 350, kOtherNs = 60, kSavedNs = 3;

}  // namespace

bool reinsertion_pays(std::size_t triangles, double rays) {
  const auto count = static_cast<double>(triangles);
  return rays * kSavedNs > kFirstNs * std::min(count, kFirst) + kOtherNs * std::max(0.0, count - kFirst);
}

bool reinsert(BinaryTree& tree) {
  if (tree.triangles.size() <= 2 * std::size_t{kUnit}) return false;
  Reinsertion reinsertion(tree);
  const double before = reinsertion.area();
  if (!(before < kLargestArea)) return false;
  double area = before;
  for (int i = 0; i < kRounds; ++i) {
    const double last = area;
    reinsertion.round();
    area = reinsertion.area();
    if (!(last - area >= kRoundGain * before)) break;
  }
  if (!(before - area >= kMinGain * before)) return false;
  BinaryTree better = reinsertion.tree();
  if (better.nodes.empty()) return false;
  tree = std::move(better);
  return true;
}

}  // namespace eikon
