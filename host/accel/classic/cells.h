// SPDX-License-Identifier: Apache-2.0
// The common part of structures that divide space: the scene's triangles, and a test of whether a
// triangle may be hit within a part of its box. kernels/traverse/classic/cells.h proves that this
// test is enough.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "accel/accel.h"
#include "accel/binary_tree.h"
#include "accel/box.h"
#include "accel/classic/polytope.h"

namespace eikon {

/// Words of accel_nodes in front of a structure's own words; CELLS_HEADER in kernels.
inline constexpr std::size_t kCellsHeader = 16;

/// A triangle with its box, or with the part of its box that lies in a cell.
struct CellReference {
  std::array<float, 3> lo, hi;
  std::uint32_t triangle;  // number in CellScene
};
using CellReferences = std::vector<CellReference>;

class CellScene {
 public:
  /// Leaves out degenerate triangles, and keeps endless shapes apart. throws InputError for more
  /// than 2^26 triangles
  explicit CellScene(TriangleSoup triangles);

  [[nodiscard]] std::size_t size() const { return ids_.size(); }
  [[nodiscard]] const Box& box() const { return box_; }  // of all; empty without triangles
  [[nodiscard]] std::uint32_t id(std::uint32_t number) const { return ids_[number]; }  // index into the soup
  [[nodiscard]] CellReferences references() const;                                     // all, whole

  /// False only if the part lies further from the triangle's plane than arithmetic can err, so that
  /// no ray up to the limit of reach can be given a hit within it. It is never false if part and
  /// triangle meet.
  [[nodiscard]] bool may_be_hit(const CellReference& part) const;

  /// The region where the triangle may be hit: all points within `slack` of a convex polygon, which
  /// is the part of its plane in its box. A needle has no polygon, because it may be hit anywhere
  /// in its box.
  struct Region {
    Polygon polygon;
    double slack;
  };
  [[nodiscard]] Region region(std::uint32_t number) const;
  /// The largest distance from the triangle's plane at which it may be hit; infinite for a needle.
  [[nodiscard]] double slack(std::uint32_t number) const { return planes_[number].slack; }
  /// The largest distance from a part of its box at which a ray up to the limit of reach may be
  /// given a hit within the part.
  [[nodiscard]] double error() const { return kUnit * (77 * reach_limit_ + 7 * largest_); }
  [[nodiscard]] Polygon corners(std::uint32_t number) const;
  [[nodiscard]] const Box& box_of(std::uint32_t number) const { return boxes_[number]; }

  /// An Accel with name, layout, header and counts, and no nodes yet.
  [[nodiscard]] Accel begin(const char* name, const char* layout) const;
  /// Adds the endless shapes, which are in no cell.
  void finish(Accel& accel) const;

 private:
  struct Plane {
    std::array<double, 3> normal;  // unit
    double offset, slack;          // slack is infinite if the triangle is a needle
  };
  [[nodiscard]] Plane plane_of(const float* corners) const;
  static constexpr double kUnit = 0x1p-24;  // u

  TriangleSoup triangles_;
  Box box_;
  std::vector<std::uint32_t> ids_, endless_;
  std::vector<Plane> planes_;
  std::vector<Box> boxes_;
  double reach_limit_ = 0;  // metres
  double largest_ = 0;      // of all coordinates
};

/// Finds the part of `parent` below (side 0) or above (side 1) the plane. A triangle that only
/// touches the plane goes to one side. returns false if there is no such part, or the triangle
/// cannot be hit in it
[[nodiscard]] bool cut(const CellScene& scene, const CellReference& parent, std::size_t axis, float plane,
                       std::size_t side, CellReference& part);

/// The number of references that a part of a structure may hold, which bounds duplicates. A node
/// divides its share among its children by their numbers of references.
struct CellBudget {
  std::size_t references;
  static CellBudget of(std::size_t triangles) { return {kPerTriangle * triangles + 4096}; }
  [[nodiscard]] bool allows(std::size_t count) const { return count <= references; }
  [[nodiscard]] CellBudget share(std::size_t count, std::size_t of_all) const {
    return {static_cast<std::size_t>(static_cast<double>(references) * static_cast<double>(count) /
                                     static_cast<double>(of_all))};
  }
  static constexpr std::size_t kPerTriangle = 16;
};

}  // namespace eikon
