// SPDX-License-Identifier: Apache-2.0
// Trees of a scene whose triangles move from frame to frame: the nodes stay, and their boxes
// follow.
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "accel/accel.h"

namespace eikon {

/// A refitted tree is used as long as the expected cost of a ray through it is at most so many
/// times that of the tree when it was built.
inline constexpr double kMaxRefitCost = 1.1;

/// The areas of all boxes of a bvh2, bvh8 or bvh16 in one level, over that of the root: what the
/// cost of a ray follows. Infinite where the root has no area, and for other trees.
[[nodiscard]] double tree_area(const Accel& tree);

/// Fits the boxes and leaves of such a tree to triangles that stand elsewhere. Rays get the hits
/// that any other tree of the triangles gives them.
/// returns  nothing if other triangles than those of the tree can be hit now, or if the tree is of
///          another kind
[[nodiscard]] std::optional<Accel> refit(const Accel& tree, TriangleSoup triangles);

/// The trees that were built for the frames of one file. Any thread may call it.
class TreeMemory {
 public:
  /// As build_accel(), but for a tree that is refitted where that is as good. throws as
  /// build_accel()
  [[nodiscard]] Accel tree(TriangleSoup triangles, const AccelOptions& options);

 private:
  struct Built {
    Accel tree;
    double area = 0;  // tree_area()
  };
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const Built>> built_;  // by accelerator, layout and quality
};

}  // namespace eikon
