// SPDX-License-Identifier: Apache-2.0
#include "accel/two_level.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <limits>
#include <vector>

#include "accel/layouts/layouts.h"
#include "accel/reinsertion.h"
#include "core/error.h"

namespace eikon {
namespace {

constexpr std::size_t kBlockWords = 80, kBlockIds = 72;  // traverse/wide/wide.h
constexpr std::uint64_t kMaxEntries = std::uint64_t{1} << 28;

/// Describes the words by which a tree refers to its own nodes and leaves, so that it can be
/// appended to others.
struct Words {
  std::size_t node, children, child_count;  // words of a node; first of its child words, and their number
  std::size_t leaf;                         // words of `leaves` per leaf number
  std::uint32_t number;                     // mask of the leaf number in a child word
};

Words words_of(const std::string& layout) {
  if (layout == "bvh2") return {16, 12, 2, 1, 0x0fffffffU};
  const std::size_t width = layout == "bvh16" ? 16 : 8;
  return {8 * width, 6 * width, width, kBlockWords, 0x7fffffffU};
}

/// Replaces the triangle numbers of all leaves by those of their records, to(number).
template <class To>
void number_records(Accel& accel, const To& to) {
  const bool blocks = accel.layout != "bvh2";
  for (std::size_t at = 0; at < accel.leaves.size(); ++at) {
    if (blocks && at % kBlockWords < kBlockIds) continue;
    std::uint32_t& id = accel.leaves[at];
    if (id != 0xffffffffU) id = to(id);
  }
}

/// Appends `tree` to `all`. Returns the child word of its root.
std::uint32_t append(Accel& all, const Accel& tree, const Words& words) {
  const auto nodes = std::uint32_t(all.nodes.size() / words.node),
             leaves = std::uint32_t(all.leaves.size() / words.leaf);
  const auto moved = [&](std::uint32_t word) { return (word & kLeafBit) != 0 ? word + leaves : word + nodes; };
  const std::uint32_t* const children = tree.nodes.data() + words.children;
  // A root with one leaf and nothing else is left out, because rays enter an instance through its
  // own box.
  const bool wide = words.child_count > 2;
  const auto used = [&](std::size_t i) {
    const auto lo = std::bit_cast<float>(tree.nodes[wide ? i : 6 * i]);
    return lo < std::numeric_limits<float>::infinity();
  };
  bool single = (children[0] & kLeafBit) != 0 && used(0);
  for (std::size_t i = 1; i < words.child_count; ++i) single = single && !used(i);
  all.leaves.insert(all.leaves.end(), tree.leaves.begin(), tree.leaves.end());
  if (single) return moved(children[0]);
  const std::size_t begin = all.nodes.size();
  all.nodes.insert(all.nodes.end(), tree.nodes.begin(), tree.nodes.end());
  for (std::size_t node = begin; node < all.nodes.size(); node += words.node)
    for (std::size_t i = 0; i < words.child_count; ++i) {
      std::uint32_t& word = all.nodes[node + words.children + i];
      if (!wide || word != 0) word = moved(word);
    }
  all.node_count += tree.node_count;
  return nodes;
}

BinaryTree improved_tree(TriangleSoup soup, double rays, bool& reinserted) {
  BinaryTree tree = build_binary_tree(soup);
  tree.is_part = true;
  if (reinsertion_pays(tree.triangles.size(), rays) && reinsert(tree)) reinserted = true;
  return tree;
}

/// Builds the tree of the scene, with the instances behind its triangles and shapes.
Accel build_top(const TwoLevelScene& scene, std::size_t flat, const AccelOptions& options) {
  const std::size_t stored = scene.records.size() - scene.shapes - flat, first_instance = flat + scene.shapes;
  const std::size_t entries = first_instance + scene.boxes.size();
  if (entries > kMaxEntries)
    throw InputError(
        fmt::format("{} triangles, shapes and instances of meshes are more than {}; use fewer", entries, kMaxEntries));
  BigVector<float> corners(9 * entries);
  tbb::parallel_for(std::size_t{0}, entries, [&](std::size_t i) {
    float* const to = corners.data() + 9 * i;
    if (i < first_instance) {
      std::copy_n(scene.records.corners(i < flat ? i : i + stored), 9, to);
      return;
    }
    const InstanceBox& box = scene.boxes[i - first_instance];
    for (int k = 0; k < 3; ++k) to[k] = box.lo[k], to[3 + k] = box.hi[k];
    std::fill_n(to + 6, 3, std::numeric_limits<float>::quiet_NaN());
  });
  const TriangleSoup soup(corners.data(), entries, 9, entries - flat);
  bool reinserted = false;
  BinaryTree tree = improved_tree(soup, options.rays, reinserted);
  tree.first_instance = std::uint32_t(first_instance);
  tree.instances_before.resize(tree.triangles.size() + 1);
  tree.instances_before[0] = 0;
  for (std::size_t i = 0; i < tree.triangles.size(); ++i)
    tree.instances_before[i + 1] = tree.instances_before[i] + (tree.triangles[i] >= first_instance ? 1 : 0);
  Accel accel = lay_out(tree, soup, options.layout);
  accel.reinserted = reinserted;
  number_records(accel, [&](std::uint32_t id) { return id < flat ? id : std::uint32_t(id + stored); });
  return accel;
}

Accel build(const TwoLevelScene& scene, const AccelOptions& options) {
  const std::size_t flat = scene.meshes.front().first;
  Accel accel = build_top(scene, flat, options);
  std::vector<Accel> trees(scene.meshes.size());
  tbb::parallel_for(std::size_t{0}, trees.size(), [&](std::size_t m) {
    const StoredMesh& mesh = scene.meshes[m];
    const TriangleSoup soup = scene.records.part(mesh.first, mesh.count);
    bool reinserted = false;
    const BinaryTree tree = improved_tree(soup, options.rays, reinserted);
    trees[m] = lay_out(tree, soup, options.layout);
    number_records(trees[m], [&](std::uint32_t id) { return std::uint32_t(id + mesh.first); });
  });
  const Words words = words_of(options.layout);
  std::vector<std::uint32_t> roots;
  std::uint32_t below = 0;
  for (Accel& tree : trees) {
    below = std::max(below, tree.stack_size);
    roots.push_back(append(accel, tree, words));
    tree = {};
  }
  const std::uint64_t leaves = accel.leaves.size() / words.leaf;
  if (leaves > std::min<std::uint64_t>(words.number, (1U << 28) - 1))
    throw InputError(fmt::format("trees of {} leaves are more than can be named; use simpler meshes", leaves));
  accel.stack_size += below + 1;  // one more entry marks the end of an instance
  accel.instances.assign(scene.instances.begin(), scene.instances.end());
  for (InstanceRecord& instance : accel.instances) instance.root = roots[instance.mesh];
  return accel;
}

}  // namespace

Accel build_two_level(const TwoLevelScene& scene, const AccelOptions& options) {
  if (options.accel != "bvh" || (options.layout != "bvh16" && options.layout != "bvh8" && options.layout != "bvh2"))
    throw UsageError(fmt::format(
        "--accel {} --layout {} has no second level; take bvh with bvh16, bvh8 or bvh2, or --instances flat",
        options.accel, options.layout));
  const auto start = std::chrono::steady_clock::now();
  tbb::task_arena arena(arena_size(options));
  Accel accel = arena.execute([&] { return build(scene, options); });
  accel.build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return accel;
}

}  // namespace eikon
