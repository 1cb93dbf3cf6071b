// SPDX-License-Identifier: Apache-2.0
// Acceleration structures over triangles: pure functions from geometry to arrays, without OpenCL.
// The result does not depend on the number of threads.
#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/device_vector.h"
#include "shared/records.h"

namespace eikon {

/// A view of world-space corners, metres: nine floats p0, p1, p2 for each triangle, which lie
/// `stride` floats apart. The triangles may be followed by boxes of other things that a ray can
/// hit: p0 and p1 are their corners, and p2 is NaN. So are triangles that move, wherever they
/// stand.
class TriangleSoup {
 public:
  TriangleSoup(std::span<const float> positions)
      : first_(positions.data()), size_(positions.size() / 9), triangles_(size_) {}
  /// moves  null, or a word per triangle that is not 0 if it moves
  TriangleSoup(const float* first, std::size_t size, std::size_t stride, std::size_t boxes = 0,
               const std::uint32_t* moves = nullptr)
      : first_(first), size_(size), stride_(stride), triangles_(size - boxes), moves_(moves) {}
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const float* corners(std::size_t i) const { return first_ + stride_ * i; }
  [[nodiscard]] bool is_box(std::size_t i) const { return i >= triangles_ || (moves_ != nullptr && moves_[i] != 0); }
  /// The triangles [first, first + count).
  [[nodiscard]] TriangleSoup part(std::size_t first, std::size_t count) const {
    return {first_ + stride_ * first, count, stride_, 0, moves_ == nullptr ? nullptr : moves_ + first};
  }

 private:
  const float* first_;
  std::size_t size_, stride_ = 9, triangles_;
  const std::uint32_t* moves_ = nullptr;
};

/// The corners of triangles at each pose while the shutter is open. Every triangle of the tree
/// moves.
struct TrianglePoses {
  const std::uint32_t* motion = nullptr;  // per triangle: 1 + its first record among `corners`
  const float* corners = nullptr;         // nine floats for each pose, `stride` floats apart
  std::size_t stride = 9, count = 0;      // count: poses
};

/// The names of kernels/shared/layouts.def.
const std::vector<std::string>& tree_layouts();

/// True for bvh16 and bvh8, in which vectors hold the boxes of a node.
[[nodiscard]] bool is_wide(const std::string& layout);

/// About what the tree of so many triangles takes in this layout (of tree_layouts()): a fifth more
/// or less, but for scenes of less than a few hundred triangles.
[[nodiscard]] std::uint64_t expected_tree_bytes(const std::string& layout, std::uint64_t triangles);

/// Set in a child word of most structures if the child is a leaf.
inline constexpr std::uint32_t kLeafBit = 0x80000000U;

/// A flattened accelerator, ready for upload: kernels read it as `accel_nodes` and `accel_leaves`.
struct Accel {
  std::string name;                    // --accel: of accelerator_names()
  std::string layout;                  // --layout: of tree_layouts(), or the accelerator's own
  DeviceVector<std::uint32_t> nodes{};       // words; never empty (a dummy where there is no tree)
  DeviceVector<std::uint32_t> leaves{};      // words
  DeviceVector<InstanceRecord> instances{};  // of meshes that have trees of their own (two_level.h)
  // The tree of the triangles that move, whose boxes follow them (kernels/traverse/motion_tree.h);
  // empty in a scene where nothing can move, or without a tree.
  DeviceVector<std::uint32_t> motion_nodes{}, motion_leaves{};
  // Entries that suffice for any traversal (EK_STACK_SIZE). They grow in coarse steps, so that
  // programs are seldom compiled anew for another tree.
  std::uint32_t stack_size = 1;
  bool reinserted = false;  // reinsertion.h improved the tree
  bool together = false;    // the tree is so small that any rays share most of their way, and are traced together
  double build_s = 0;
  std::uint64_t node_count = 0;
  double sah_cost = 0;  // expected cost of a random ray through the root's box
  [[nodiscard]] std::uint64_t bytes() const {
    return 4 * (nodes.size() + leaves.size() + motion_nodes.size() + motion_leaves.size()) +
           instances.size() * sizeof(InstanceRecord);
  }
  /// The defines of a program that traces rays through it.
  [[nodiscard]] std::map<std::string, std::string> defines() const;
};

struct AccelOptions {
  std::string accel = "bvh";    // of accelerator_names()
  std::string layout = "bvh8";  // of tree_layouts(), or "none"; ignored by accelerators with a layout of their own
  unsigned threads = 0;         // 0: all; the result does not depend on it
  double rays = 0;              // expected to be traced; for many rays a better tree is built, which takes longer
  const TrianglePoses* poses = nullptr;  // of the triangles of a bvh2, bvh8 or bvh16; the soup has boxes in their place
};

/// The concurrency of the arena of TBB in which a tree is built: at most the processors, since TBB
/// warns of more on stderr.
[[nodiscard]] int arena_size(const AccelOptions& options);

/// throws UsageError for an unknown accel or layout. Degenerate triangles (zero area) are left out
/// of the tree.
Accel build_accel(TriangleSoup triangles, const AccelOptions& options);

/// An accelerator that --accel names. The table in accel.cpp has one line for each.
struct Accelerator {
  const char* name;    // --accel
  const char* layout;  // that programs are compiled for; nullptr: any of tree_layouts(), by device or --layout
  Accel (*build)(TriangleSoup triangles, const AccelOptions& options);
};

[[nodiscard]] std::span<const Accelerator> accelerators();
[[nodiscard]] std::vector<std::string> accelerator_names();

/// The layout that only `accel` has; empty if it takes any of tree_layouts(), or is unknown.
[[nodiscard]] std::string own_layout(const std::string& accel);

}  // namespace eikon
