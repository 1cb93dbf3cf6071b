// SPDX-License-Identifier: Apache-2.0
// What structures that divide space share: the scene's triangles, and whether one may be hit within a part of its box. Why that is
// enough: kernels/traverse/classic/cells.h.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "accel/accel.h"
#include "accel/binary_tree.h"
#include "accel/box.h"
#include "accel/classic/polytope.h"

namespace eikon {

/// Words of accel_nodes in front of a structure's own; CELLS_HEADER of the kernels.
inline constexpr std::size_t kCellsHeader = 16;

/// A triangle, or what a cell cuts from its box.
struct CellReference {
  std::array<float, 3> lo, hi;
  std::uint32_t triangle;  // number in CellScene
};
using CellReferences = std::vector<CellReference>;

class CellScene {
 public:
  /// Degenerate triangles are left out, and what has no end is kept apart. throws InputError for more than 2^26 triangles
  explicit CellScene(TriangleSoup triangles);

  [[nodiscard]] std::size_t size() const { return ids_.size(); }
  [[nodiscard]] const Box& box() const { return box_; }  // of all; empty without triangles
  [[nodiscard]] std::uint32_t id(std::uint32_t number) const { return ids_[number]; }  // index into the soup
  [[nodiscard]] CellReferences references() const;                                     // all, whole

  /// False only if no ray up to the limit of reach can be given a hit of the triangle within this part of its box: the part
  /// lies further from the triangle's plane than arithmetic can err. Never false where they meet.
  [[nodiscard]] bool may_be_hit(const CellReference& part) const;

  /// Where the triangle may be hit, as what lies within `slack` of a convex polygon: what of its plane is in its box. No
  /// polygon for a needle: it may be hit anywhere in its box.
  struct Region {
    Polygon polygon;
    double slack;
  };
  [[nodiscard]] Region region(std::uint32_t number) const;
  /// How far from the triangle's plane it may be hit; infinite for a needle.
  [[nodiscard]] double slack(std::uint32_t number) const { return planes_[number].slack; }
  /// How far from a part of its box a ray up to the limit of reach may be given a hit within it.
  [[nodiscard]] double error() const { return kUnit * (77 * reach_limit_ + 7 * largest_); }
  [[nodiscard]] Polygon corners(std::uint32_t number) const;
  [[nodiscard]] const Box& box_of(std::uint32_t number) const { return boxes_[number]; }

  /// Name, layout, header and counts; nodes hold no more than the header.
  [[nodiscard]] Accel begin(const char* name, const char* layout) const;
  /// Adds what has no end, and is in no cell.
  void finish(Accel& accel) const;

 private:
  struct Plane {
    std::array<double, 3> normal;  // unit
    double offset, slack;          // slack is infinite where the plane means nothing
  };
  [[nodiscard]] Plane plane_of(const float* corners) const;
  static constexpr double kUnit = 0x1p-24;  // u

  TriangleSoup triangles_;
  Box box_;
  std::vector<std::uint32_t> ids_, endless_;
  std::vector<Plane> planes_;
  std::vector<Box> boxes_;
  double reach_limit_ = 0, largest_ = 0;  // metres; of the coordinates
};

/// What of `parent` lies below (`side` 0) or above (1) the plane: false if nothing does, or it cannot be hit there. What only
/// touches the plane goes to one side.
[[nodiscard]] bool cut(const CellScene& scene, const CellReference& parent, std::size_t axis, float plane,
                       std::size_t side, CellReference& part);

/// How many references a part of a structure may come to hold below it, so that duplicates are bounded: a node's share goes to
/// its children by their numbers of references.
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
