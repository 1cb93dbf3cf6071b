// SPDX-License-Identifier: Apache-2.0
// Trees over triangles: pure functions from geometry to arrays, no OpenCL. The same tree comes out for any number of threads.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace eikon {

/// World-space corners of triangle i: positions[9 * i ...] = p0, p1, p2; metres.
struct TriangleSoup {
  std::span<const float> positions;
  [[nodiscard]] std::size_t size() const { return positions.size() / 9; }
};

/// A flattened accelerator, ready for upload: what kernels/traverse_<layout>.h reads as `accel_nodes` and `accel_leaves`.
struct Accel {
  std::string name;                   // --accel: "bvh", "none"
  std::string layout;                 // --layout: "bvh8", "bvh2", "none"
  std::vector<std::uint32_t> nodes;   // words; never empty (a dummy where there is no tree)
  std::vector<std::uint32_t> leaves;  // words
  std::uint32_t stack_size = 1;       // entries that suffice for any traversal (EK_STACK_SIZE); in coarse steps, so
                                      // that programs are seldom compiled anew for another tree
  double build_s = 0;
  std::uint64_t node_count = 0;
  double sah_cost = 0;  // expected cost of a random ray through the root's box
  [[nodiscard]] std::uint64_t bytes() const { return 4 * (nodes.size() + leaves.size()); }
};

struct AccelOptions {
  std::string accel = "bvh";    // "bvh" or "none"
  std::string layout = "bvh8";  // "bvh8" (CPU devices), "bvh2" (GPU devices); ignored by "none"
  unsigned threads = 0;         // 0: all; the result does not depend on it
};

/// throws UsageError for an unknown accel or layout. Degenerate triangles (zero area) are left out of the tree.
Accel build_accel(TriangleSoup triangles, const AccelOptions& options);

}  // namespace eikon
