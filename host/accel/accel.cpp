// SPDX-License-Identifier: Apache-2.0
#include "accel/accel.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>

#include "accel/layouts.h"
#include "core/error.h"

namespace eikon {

const std::vector<std::string>& tree_layouts() {
  static const std::vector<std::string> names{
#define EK_LAYOUT(name) #name,
#include "shared/layouts.def"
  };
  return names;
}

std::map<std::string, std::string> Accel::defines() const {
  std::map<std::string, std::string> all{{"EK_LAYOUT_none", layout == "none" ? "1" : "0"},
                                         {"EK_STACK_SIZE", std::to_string(stack_size)}};
  for (const std::string& each : tree_layouts()) all["EK_LAYOUT_" + each] = layout == each ? "1" : "0";
  return all;
}

Accel layout_none(TriangleSoup triangles) {
  Accel accel;
  accel.name = "none";
  accel.layout = "none";
  accel.nodes.resize(1, 0);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (!is_degenerate(triangles.corners(i))) accel.leaves.push_back(static_cast<std::uint32_t>(i));
  }
  accel.nodes[0] = static_cast<std::uint32_t>(accel.leaves.size());
  if (accel.leaves.empty()) accel.leaves.push_back(0);
  return accel;
}

Accel build_accel(TriangleSoup triangles, const AccelOptions& options) {
  if (options.accel != "bvh" && options.accel != "none") {
    throw UsageError(fmt::format("--accel {}: there is no such accelerator; try bvh or none", options.accel));
  }
  if (options.layout != "none" && std::ranges::count(tree_layouts(), options.layout) == 0) {
    throw UsageError(
        fmt::format("--layout {}: there is no such layout; try {}", options.layout, fmt::join(tree_layouts(), ", ")));
  }
  const auto start = std::chrono::steady_clock::now();
  tbb::task_arena arena(options.threads == 0 ? tbb::task_arena::automatic : static_cast<int>(options.threads));
  Accel accel = arena.execute([&] {
    if (options.accel == "none" || options.layout == "none") return layout_none(triangles);
    const BinaryTree tree = build_binary_tree(triangles);
    if (options.layout == "bvh4") return layout_bvh4(tree);
    if (options.layout == "cwbvh") return layout_cwbvh(tree);
    return options.layout == "bvh8" ? layout_bvh8(tree, triangles) : layout_bvh2(tree);
  });
  constexpr std::uint32_t step = 64;
  accel.stack_size = (accel.stack_size + step - 1) / step * step;
  accel.build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return accel;
}

}  // namespace eikon
