// SPDX-License-Identifier: Apache-2.0
#include "accel/accelerators.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "accel/classic/builders.h"
#include "accel/layouts/layouts.h"
#include "accel/reinsertion.h"
#include "core/error.h"

namespace eikon {
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
    Accelerator{"bvh", nullptr, bvh, "boxes, split by the surface area heuristic"},
    Accelerator{"bvh-median", nullptr, bvh_median, "boxes, split at the median of the longest axis"},
#define EK_CELLS(name, about) \
  Accelerator{#name, #name, [](TriangleSoup t, const AccelOptions&) { return build_##name(t); }, about},
#include "shared/layouts.def"
    Accelerator{"kdtree-rotate", "kdtree", [](TriangleSoup t, const AccelOptions&) { return build_kdtree_rotate(t); },
                "planes through the middle, axes in turn"},
    Accelerator{"none", "none", [](TriangleSoup t, const AccelOptions&) { return layout_none(t); },
                "every ray against every triangle"},
};

}  // namespace

std::span<const Accelerator> accelerators() { return kAccelerators; }

std::vector<std::string> accelerator_names() {
  std::vector<std::string> names;
  for (const Accelerator& each : accelerators()) names.emplace_back(each.name);
  return names;
}

const Accelerator& find_accelerator(const std::string& name) {
  const auto found = std::ranges::find(kAccelerators, name, &Accelerator::name);
  if (found == kAccelerators.end()) {
    throw UsageError(
        fmt::format("--accel {}: there is no such accelerator; try {}", name, fmt::join(accelerator_names(), ", ")));
  }
  return *found;
}

std::string own_layout(const std::string& accel) {
  const auto found = std::ranges::find(kAccelerators, accel, &Accelerator::name);
  return found == kAccelerators.end() || found->layout == nullptr ? std::string() : std::string(found->layout);
}

}  // namespace eikon
