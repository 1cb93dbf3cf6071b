// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "render/scene_builder.h"

namespace eikon::test {

/// Every lane width and every order of stages, each in the layout that is its own: for features
/// whose hits other tests compare in every layout, or that no traversal sees. Hits have the same
/// bits in every layout (the tests of Traverse, TraverseMotion, TraverseInstance, CullingTraverse,
/// OpacityTraverse and ShapeHits, against brute force; here those that use ways_to_trace()), so
/// what shades them cannot tell layouts apart. Of how stages are launched, a launch for each stage
/// differs from one launch for all by where the same functions are called from, whatever the width;
/// so one width of it will do.
inline std::vector<Execution> ways_to_shade() {
  std::vector<Execution> ways;
  const auto add = [&](std::uint32_t lanes, bool chunked, bool fused) {
    Execution execution;
    execution.lanes = lanes, execution.chunked = chunked, execution.fused = fused;
    ways.push_back(execution);
  };
  for (const std::uint32_t lanes : {16U, 8U, 1U}) add(lanes, true, true);
  add(16, true, false);
  add(1, false, false);
  return ways;
}

}  // namespace eikon::test
