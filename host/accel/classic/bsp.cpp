// SPDX-License-Identifier: Apache-2.0
#include "accel/classic/builders.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "accel/classic/cells.h"
#include "accel/classic/kd_builder.h"

namespace eikon {
namespace {

// Relative time of a step across an oblique plane; kd_builder.h has the others.
constexpr double kObliqueCost = 2.5;
// Oblique planes are tried in nodes of at most this many triangles, and for this many of them.
constexpr std::size_t kObliqueLimit = 64, kObliqueTriangles = 4;
constexpr double kMaxSlack = 0.25;  // largest slack, per size of a triangle, with which its plane is tried
constexpr double kInfinity = std::numeric_limits<double>::infinity();


/// The largest height of a box.
double top_of(const CellReference& box, const HalfSpace& half) {
  double height = -half.offset;
  for (std::size_t k = 0; k < 3; ++k) height += half.normal[k] * double{half.normal[k] > 0 ? box.hi[k] : box.lo[k]};
  return height;
}

HalfSpace across(const KdPlane& plane) {
  HalfSpace above{{}, double{plane.at}};
  above.normal[plane.axis] = 1;
  return above;
}

/// The part of a triangle in a cell: hits are within `box`, and within `slack` of the polygon,
/// which lies in the triangle's plane. There is no polygon if it would not restrict them further.
struct Piece {
  CellReference box;
  double slack = 0;
  Polygon polygon;

  /// Shrinks the box to the points within slack of the polygon.
  void shrink() {
    for (std::size_t k = 0; k < 3; ++k) {
      double lo = kInfinity, hi = -kInfinity;
      for (const Point3& p : polygon) lo = std::min(lo, p[k]), hi = std::max(hi, p[k]);
      box.lo[k] =
          std::max(box.lo[k], std::nextafter(static_cast<float>(lo - slack), -std::numeric_limits<float>::infinity()));
      box.hi[k] =
          std::min(box.hi[k], std::nextafter(static_cast<float>(hi + slack), std::numeric_limits<float>::infinity()));
    }
  }
};
using Pieces = std::vector<Piece>;

/// A plane across an axis, or an oblique plane: in the words that the traversal reads, and in
/// double precision.
struct Split {
  double cost = kInfinity;
  KdPlane across;
  std::array<float, 4> words{};
  HalfSpace front{};
  [[nodiscard]] bool is_oblique() const { return across.axis == 3; }
};

class BspBuilder {
 public:
  BspBuilder(const CellScene& scene, const Point3& center, int max_depth)
      : scene_(scene), center_(center), max_depth_(max_depth) {}

  void build(KdPart& part, KdTask&& task) const {
    Pieces pieces;
    for (const CellReference& each : task.references) pieces.push_back(piece_of(each));
    Solid solid;
    if (!pieces.empty()) {
      Point3 lo{}, hi{};
      for (std::size_t k = 0; k < 3; ++k) lo[k] = double{task.cell.lo[k]}, hi[k] = double{task.cell.hi[k]};
      solid = box_solid(lo, hi);
    }
    build(part, {std::move(pieces), task.cell, std::move(solid), task.budget, task.depth, task.bad});
  }

 private:
  struct Task {
    Pieces pieces;
    KdCell cell;  // around `solid`
    Solid solid;
    CellBudget budget;
    int depth, bad;
  };

  void build(KdPart& part, Task&& task) const {
    Split split;
    if (task.depth < max_depth_ && task.pieces.size() > 1) split = choose(task);
    int bad = task.bad;
    if (!std::isfinite(split.cost) || is_hopeless(split.cost, task.pieces.size(), bad))
      return add_leaf(part, task.pieces);
    std::array<Pieces, 2> side;
    for (std::size_t i = 0; i < 2; ++i) side[i] = pieces_on(task.pieces, split, i);
    const std::size_t behind = side[0].size(), both = behind + side[1].size();
    if (!task.budget.allows(both) || std::min(behind, both - behind) >= task.pieces.size())
      return add_leaf(part, task.pieces);
    if (both == 0) return add_leaf(part, {});
    Pieces().swap(task.pieces);

    const std::size_t node = split.is_oblique() ? part.add_oblique(split.words) : part.add_axis(split.across);
    for (std::size_t i = 0; i < 2; ++i) {
      const HalfSpace half = split.is_oblique() ? split.front : across(split.across);
      if (i == 1) part.link(node);
      const CellBudget share = task.budget.share(side[i].size(), both);
      Task below{std::move(side[i]), task.cell, clipped(task.solid, i == 0 ? half.opposite() : half), share,
                 task.depth + 1,     bad};
      if (!split.is_oblique()) (i == 0 ? below.cell.hi : below.cell.lo)[split.across.axis] = split.across.at;
      shrink(below.cell, below.solid);
      build(part, std::move(below));
    }
  }

  void add_leaf(KdPart& part, const Pieces& pieces) const {
    std::vector<std::uint32_t> triangles;
    for (const Piece& each : pieces) triangles.push_back(scene_.id(each.box.triangle));
    part.add_leaf(triangles);
  }

  [[nodiscard]] Piece piece_of(const CellReference& reference) const {
    Piece piece{reference, 0, {}};
    const Box& whole = scene_.box_of(reference.triangle);
    double size = 0;
    for (std::size_t k = 0; k < 3; ++k) size = std::max(size, double{whole.hi[k]} - double{whole.lo[k]});
    if (!(scene_.slack(reference.triangle) <= kMaxSlack * size)) return piece;
    CellScene::Region region = scene_.region(reference.triangle);
    for (std::size_t k = 0; k < 3; ++k) {
      HalfSpace half{{}, double{reference.lo[k]}};
      half.normal[k] = 1;
      region.polygon = clipped(region.polygon, half, -region.slack);
      half.offset = double{reference.hi[k]};
      region.polygon = clipped(region.polygon, half.opposite(), -region.slack);
    }
    if (region.polygon.empty()) return piece;
    piece.slack = region.slack;
    piece.polygon = std::move(region.polygon);
    piece.shrink();
    return piece;
  }

  /// True if the piece may be hit in the half space.
  [[nodiscard]] bool is_in(const Piece& piece, const HalfSpace& half) const {
    if (!(top_of(piece.box, half) >= -scene_.error())) return false;
    return piece.polygon.empty() || std::any_of(piece.polygon.begin(), piece.polygon.end(),
                                                [&](const Point3& p) { return half.height(p) >= -piece.slack; });
  }

  /// The parts of the pieces behind (side 0) or in front of a plane.
  [[nodiscard]] Pieces pieces_on(const Pieces& pieces, const Split& split, std::size_t side) const {
    const HalfSpace front = split.is_oblique() ? split.front : across(split.across);
    const HalfSpace half = side == 0 ? front.opposite() : front;
    Pieces there;
    for (const Piece& piece : pieces) {
      Piece part{piece.box, piece.slack, {}};
      if (split.is_oblique() ? !is_in(piece, half)
                             : !cut(scene_, piece.box, split.across.axis, split.across.at, side, part.box))
        continue;
      if (!piece.polygon.empty()) {
        part.polygon = clipped(piece.polygon, half, -piece.slack);
        if (part.polygon.empty()) continue;
        part.shrink();
      }
      there.push_back(std::move(part));
    }
    return there;
  }

  static void shrink(KdCell& cell, const Solid& solid) {
    Point3 lo{kInfinity, kInfinity, kInfinity}, hi{-kInfinity, -kInfinity, -kInfinity};
    for (const Polygon& face : solid.faces)
      for (const Point3& p : face)
        for (std::size_t k = 0; k < 3; ++k) lo[k] = std::min(lo[k], p[k]), hi[k] = std::max(hi[k], p[k]);
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(lo[k] < hi[k])) continue;
      cell.lo[k] = std::max(cell.lo[k], static_cast<float>(lo[k]));
      cell.hi[k] = std::min(cell.hi[k], static_cast<float>(hi[k]));
    }
  }

  [[nodiscard]] Split choose(const Task& task) const {
    CellReferences boxes;
    for (const Piece& each : task.pieces) boxes.push_back(each.box);
    Split best;
    best.across = cheapest_plane(boxes, task.cell);
    best.cost = best.across.cost;
    const double area = task.solid.area();
    if (!(area > 0) || !std::isfinite(area)) return best;
    if (best.across.axis != 3) {
      const auto count = [&](std::size_t side) { return pieces_on(task.pieces, best, side).size(); };
      best.cost = cost_of(task.solid, area, across(best.across), kKdStepCost, {count(0), count(1)}, kInfinity);
    }
    const auto flat = static_cast<std::size_t>(
        std::count_if(task.pieces.begin(), task.pieces.end(), [](const Piece& each) { return !each.polygon.empty(); }));
    const std::size_t step = std::max<std::size_t>(flat / kObliqueTriangles, 1);
    std::size_t number = 0;
    for (const Piece& each : task.pieces)
      if (!each.polygon.empty() && number++ % step == 0) consider_triangle(task, area, each, best);
    return best;
  }

  /// Tries the plane of a triangle, moved to either side so that the triangle is on one side alone,
  /// and planes through its edges.
  void consider_triangle(const Task& task, double area, const Piece& piece, Split& best) const {
    const Polygon p = scene_.corners(piece.box.triangle);
    const Point3 normal = cross(minus(p[1], p[0]), minus(p[2], p[0]));
    const auto beside = [&](const Point3& n, const Point3& from, double distance) {
      const double length = std::hypot(n[0], n[1], n[2]);
      Point3 to = from;
      for (std::size_t k = 0; k < 3; ++k) to[k] += distance / length * n[k];
      consider(task, area, n, to, best);
    };
    const double margin = 2.5 * piece.slack;
    beside(normal, p[0], margin);
    beside(normal, p[0], -margin);
    for (std::size_t i = 0; i < 3; ++i) beside(cross(minus(p[(i + 1) % 3], p[i]), normal), p[i], margin);
  }

  void consider(const Task& task, double area, const Point3& normal, const Point3& point, Split& best) const {
    Split split = rounded(normal, point);
    if (!std::isfinite(split.front.offset) || !std::isfinite(split.words[0])) return;
    const HalfSpace behind = split.front.opposite();
    std::size_t in_front = 0, are_behind = 0;
    for (const Piece& each : task.pieces) {
      in_front += is_in(each, split.front) ? 1 : 0;
      are_behind += is_in(each, behind) ? 1 : 0;
    }
    split.cost = cost_of(task.solid, area, split.front, kObliqueCost, {are_behind, in_front}, best.cost);
    if (split.cost < best.cost) best = split;
  }

  struct Counts {
    std::size_t are_behind, in_front;
  };
  /// The cost by the surface area heuristic; infinite if it is certainly no less than `least`.
  static double cost_of(const Solid& solid, double area, const HalfSpace& front, double step, const Counts& counts,
                        double least) {
    const auto [are_behind, in_front] = counts;
    const double gain = are_behind == 0 || in_front == 0 ? kKdEmptyGain : 1.0;
    // The sum of both areas is at least the area of the whole.
    if (step + kKdTriangleCost * gain * static_cast<double>(std::min(are_behind, in_front)) >= least) return kInfinity;
    const CutAreas cut = cut_areas(solid, front);
    const double hits = cut.behind * static_cast<double>(are_behind) + cut.front * static_cast<double>(in_front);
    return step + kKdTriangleCost * gain * (hits / area);
  }

  /// Rounds a plane through `point` to what the traversal reads.
  [[nodiscard]] Split rounded(const Point3& normal, const Point3& point) const {
    Split split;
    const double length = std::hypot(normal[0], normal[1], normal[2]);
    double offset = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      split.words[k] = static_cast<float>(normal[k] / length);
      split.front.normal[k] = double{split.words[k]};
      offset += split.front.normal[k] * (point[k] - center_[k]);
    }
    split.words[3] = static_cast<float>(offset);
    split.front.offset = double{split.words[3]};
    for (std::size_t k = 0; k < 3; ++k) split.front.offset += split.front.normal[k] * center_[k];
    return split;
  }

  const CellScene& scene_;
  Point3 center_;
  int max_depth_ = 0;
};

}  // namespace

/// The upper part, where nodes have many triangles, is a kd-tree. Below it the surface area
/// heuristic chooses between the best plane of a kd-tree and planes of some triangles and through
/// their edges, whose steps cost more. A bounded number of those is tried on a bounded number of
/// triangles per node, so that building takes O(n log n) with some tens of microseconds per node.
/// The tree does not depend on the number of threads. Each leaf lists the triangles that may be hit
/// in it; all lists together have at most 16 entries per triangle and 4096 more. Depth is at most 8
/// + 1.3 log2(n).
/// throws InputError for more than 2^26 triangles
/// source [Ize, Wald, Parker 2008, "Ray tracing with the BSP tree", section 3]
Accel build_bsp(TriangleSoup triangles) {
  const CellScene scene(triangles);
  std::array<float, 3> middle{};
  Point3 center{};
  for (std::size_t k = 0; k < 3 && scene.size() != 0; ++k) {
    middle[k] = static_cast<float>(0.5 * double{scene.box().lo[k]} + 0.5 * double{scene.box().hi[k]});
    center[k] = double{middle[k]};
  }
  KdBuilder tree(scene, KdSplit::sah);
  const BspBuilder below(scene, center, tree.max_depth());
  tree.set_below(kObliqueLimit, [&](KdPart& part, KdTask&& task) { below.build(part, std::move(task)); });
  Accel accel = tree.build("bsp", "bsp");
  for (std::size_t k = 0; k < 3; ++k) accel.nodes[7 + k] = std::bit_cast<std::uint32_t>(middle[k]);
  return accel;
}

}  // namespace eikon
