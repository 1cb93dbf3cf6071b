// SPDX-License-Identifier: Apache-2.0
#include "accel/accel.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "accel/classic/builders.h"
#include "accel/layouts/layouts.h"
#include "accel/reinsertion.h"
#include "core/error.h"

namespace eikon {

namespace {

// Sizes of nodes and leaves beyond which a core's own caches, or any caches, do not hold all of
// them.
constexpr std::uint64_t kMediumBytes = 1'500'000;
constexpr std::uint64_t kLargeBytes = 16'000'000;

/// Rounds up the entries of a ray's stack, so that similar scenes share a program. On GPU devices
/// each work-item has memory for its stack, which competes for caches with that of thousands of
/// others.
std::uint32_t in_steps(std::uint32_t stack_size, const std::string& layout) {
  const std::uint32_t step = layout == "cwbvh" ? 8 : layout == "bvh2" ? 16 : layout == "bvh4" ? 32 : 64;
  return (stack_size + step - 1) / step * step;
}

}  // namespace

const std::vector<std::string>& tree_layouts() {
  static const std::vector<std::string> names{
#define EK_LAYOUT(name) #name,
#include "shared/layouts.def"
  };
  return names;
}

std::uint64_t expected_tree_bytes(const std::string& layout, std::uint64_t triangles) {
  // Measured over the shipped scenes and tools/make_dense.py, of 320 to 2 million triangles: 60 to
  // 76 in bvh16, 58 to 73 in bvh8, 32 to 36 in bvh2, 16 to 18 in bvh4, 11 to 13 in cwbvh.
  static const std::map<std::string, std::uint64_t> bytes_per_triangle{
      {"bvh16", 64}, {"bvh8", 62}, {"bvh2", 34}, {"bvh4", 17}, {"cwbvh", 12}};
  return triangles * bytes_per_triangle.at(layout);
}

bool is_wide(const std::string& layout) { return layout == "bvh16" || layout == "bvh8"; }

std::map<std::string, std::string> Accel::defines() const {
  std::map<std::string, std::string> all{{"EK_STACK_SIZE", std::to_string(stack_size)},
                                         {"EK_SMALL_TREE", together ? "1" : "0"},
                                         {"EK_MEDIUM_TREE", bytes() > kMediumBytes ? "1" : "0"},
                                         {"EK_LARGE_TREE", bytes() > kLargeBytes ? "1" : "0"}};
  const auto add = [&](const std::string& each) { all["EK_LAYOUT_" + each] = layout == each ? "1" : "0"; };
  for (const std::string& each : tree_layouts()) add(each);
  for (const Accelerator& each : accelerators())
    if (each.layout != nullptr) add(each.layout);
  return all;
}

Accel layout_none(TriangleSoup triangles) {
  Accel accel{.name = "none", .layout = "none"};
  accel.nodes.resize(1, 0);
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (!is_degenerate(triangles, i)) accel.leaves.push_back(static_cast<std::uint32_t>(i));
  accel.nodes[0] = static_cast<std::uint32_t>(accel.leaves.size());
  if (accel.leaves.empty()) accel.leaves.push_back(0);
  return accel;
}

Accel lay_out(const BinaryTree& tree, TriangleSoup triangles, const std::string& layout) {
  Accel accel = layout == "bvh16"   ? layout_bvh16(tree, triangles)
                : layout == "bvh8"  ? layout_bvh8(tree, triangles)
                : layout == "bvh4"  ? layout_bvh4(tree)
                : layout == "cwbvh" ? layout_cwbvh(tree)
                                    : layout_bvh2(tree);
  accel.stack_size = in_steps(accel.stack_size, layout);
  return accel;
}

namespace {

Accel bvh(TriangleSoup triangles, const AccelOptions& options) {
  BinaryTree tree = build_binary_tree(triangles);
  const bool better = reinsertion_pays(tree.triangles.size(), options.rays) && reinsert(tree);
  Accel accel = lay_out(tree, triangles, options.layout);
  accel.reinserted = better;
  return accel;
}

Accel bvh_median(TriangleSoup triangles, const AccelOptions& options) {
  Accel accel = lay_out(build_median_tree(triangles), triangles, options.layout);
  accel.name = "bvh-median";
  return accel;
}

constexpr std::array kAccelerators{
    Accelerator{"bvh", nullptr, bvh},                // boxes, split by the surface area heuristic
    Accelerator{"bvh-median", nullptr, bvh_median},  // boxes, split at the median of the longest axis
#define EK_CELLS(name, about) \
  Accelerator{#name, #name, [](TriangleSoup t, const AccelOptions&) { return build_##name(t); }},
#include "shared/layouts.def"
    // Planes through the middle, axes in turn; and every ray against every triangle.
    Accelerator{"kdtree-rotate", "kdtree", [](TriangleSoup t, const AccelOptions&) { return build_kdtree_rotate(t); }},
    Accelerator{"none", "none", [](TriangleSoup t, const AccelOptions&) { return layout_none(t); }},
};

}  // namespace

std::span<const Accelerator> accelerators() { return kAccelerators; }

std::vector<std::string> accelerator_names() {
  std::vector<std::string> names;
  for (const Accelerator& each : accelerators()) names.emplace_back(each.name);
  return names;
}

int arena_size(const AccelOptions& options) {
  const int all = tbb::info::default_concurrency();
  return options.threads == 0 || options.threads > static_cast<std::uint32_t>(all) ? all
                                                                                   : static_cast<int>(options.threads);
}

Accel build_accel(TriangleSoup triangles, const AccelOptions& options) {
  const auto found = std::ranges::find(kAccelerators, options.accel, &Accelerator::name);
  if (found == kAccelerators.end())
    throw UsageError(fmt::format("--accel {}: there is no such accelerator; try {}", options.accel,
                                 fmt::join(accelerator_names(), ", ")));
  if (found->layout == nullptr && options.layout != "none" && std::ranges::count(tree_layouts(), options.layout) == 0)
    throw UsageError(
        fmt::format("--layout {}: there is no such layout; try {}", options.layout, fmt::join(tree_layouts(), ", ")));
  const auto start = std::chrono::steady_clock::now();
  tbb::task_arena arena(arena_size(options));
  Accel accel = arena.execute([&] {
    Accel built = options.layout == "none" ? layout_none(triangles) : found->build(triangles, options);
    built.stack_size = in_steps(built.stack_size, built.layout);
    if (options.poses != nullptr && built.layout == "bvh2") fit_bvh2_to_poses(built, *options.poses);
    if (options.poses != nullptr && is_wide(built.layout)) fit_wide_to_poses(built, *options.poses);
    return built;
  });
  accel.build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return accel;
}

std::string own_layout(const std::string& accel) {
  const auto found = std::ranges::find(kAccelerators, accel, &Accelerator::name);
  return found == kAccelerators.end() || found->layout == nullptr ? std::string() : std::string(found->layout);
}

}  // namespace eikon
