// SPDX-License-Identifier: Apache-2.0
#include "accel/accel.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>

#include "accel/accelerators.h"
#include "accel/layouts/layouts.h"
#include "core/error.h"

namespace eikon {

namespace {

// Sizes of nodes and leaves beyond which a core's own caches, or any caches, do not hold all of
// them.
constexpr std::uint64_t kMediumBytes = 1'500'000;
constexpr std::uint64_t kLargeBytes = 16'000'000;

}  // namespace

const std::vector<std::string>& tree_layouts() {
  static const std::vector<std::string> names{
#define EK_LAYOUT(name) #name,
#include "shared/layouts.def"
  };
  return names;
}

namespace {

/// Builds the structures of layouts.def that are not trees of boxes.
const std::vector<std::string>& cell_layouts() {
  static const std::vector<std::string> names{
#define EK_LAYOUT(name)
#define EK_CELLS(name, about) #name,
#include "shared/layouts.def"
  };
  return names;
}

}  // namespace

std::map<std::string, std::string> Accel::defines() const {
  std::map<std::string, std::string> all{{"EK_LAYOUT_none", layout == "none" ? "1" : "0"},
                                         {"EK_STACK_SIZE", std::to_string(stack_size)},
                                         {"EK_SMALL_TREE", together ? "1" : "0"},
                                         {"EK_MEDIUM_TREE", bytes() > kMediumBytes ? "1" : "0"},
                                         {"EK_LARGE_TREE", bytes() > kLargeBytes ? "1" : "0"}};
  for (const auto* names : {&tree_layouts(), &cell_layouts()})
    for (const std::string& each : *names) all["EK_LAYOUT_" + each] = layout == each ? "1" : "0";
  return all;
}

namespace {

std::uint32_t in_steps(std::uint32_t stack_size) { return (stack_size + 63) / 64 * 64; }

}  // namespace

Accel layout_none(TriangleSoup triangles) {
  Accel accel;
  accel.name = "none";
  accel.layout = "none";
  accel.nodes.resize(1, 0);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (!is_degenerate(triangles, i)) accel.leaves.push_back(static_cast<std::uint32_t>(i));
  }
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
  accel.stack_size = in_steps(accel.stack_size);
  return accel;
}

Accel build_accel(TriangleSoup triangles, const AccelOptions& options) {
  const Accelerator& accelerator = find_accelerator(options.accel);
  if (accelerator.layout == nullptr && options.layout != "none" && std::ranges::count(tree_layouts(), options.layout) == 0) {
    throw UsageError(
        fmt::format("--layout {}: there is no such layout; try {}", options.layout, fmt::join(tree_layouts(), ", ")));
  }
  const auto start = std::chrono::steady_clock::now();
  tbb::task_arena arena(options.threads == 0 ? tbb::task_arena::automatic : static_cast<int>(options.threads));
  Accel accel = arena.execute([&] {
    Accel built = options.layout == "none" ? layout_none(triangles) : accelerator.build(triangles, options);
    built.stack_size = in_steps(built.stack_size);
    return built;
  });
  accel.build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return accel;
}

}  // namespace eikon
