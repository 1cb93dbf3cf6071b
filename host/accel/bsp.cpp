// SPDX-License-Identifier: Apache-2.0
#include "accel/bsp.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "accel/cells.h"
#include "core/error.h"

namespace eikon {
namespace {

// Relative times, and what cutting off space gains.
constexpr double kStepCost = 1.5, kTriangleCost = 2, kEmptyGain = 0.8;
constexpr int kAxisPlanes = 7, kBadSplits = 3;
// Oblique planes are tried where there are so few triangles, of so many of them; a plane is judged by so many.
constexpr std::size_t kObliqueLimit = 128, kObliqueTriangles = 3, kJudges = 256;
constexpr std::size_t kParallelLimit = 2048, kNodeWords = 6;
constexpr double kMostSlack = 0.02;  // of a triangle's size
constexpr std::uint64_t kMostNodes = std::uint64_t{1} << 31;
constexpr std::uint32_t kLeafBit = 0x80000000U;

/// A triangle as far as it matters in a cell: the polygon of its region that is left, or for a needle, or one too small, the corners of its box.
struct Reference {
  std::uint32_t triangle;
  bool needle;
  double slack;
  Polygon points;

  [[nodiscard]] bool is_in(const HalfSpace& half) const {
    return std::any_of(points.begin(), points.end(), [&](const Point3& p) { return half.height(p) >= -slack; });
  }
  /// What is in the half space; no points if nothing is.
  [[nodiscard]] Reference cut(const HalfSpace& half) const {
    if (needle) return is_in(half) ? *this : Reference{triangle, needle, slack, {}};
    return {triangle, needle, slack, clipped(points, half, -slack)};
  }
};
using References = std::vector<Reference>;

/// As the traversal reads it, and the same in double precision.
struct Plane {
  std::array<float, 4> words{};
  HalfSpace front{};
  double cost = std::numeric_limits<double>::infinity();
};

struct Part {
  std::vector<std::uint32_t> nodes, leaves;
  std::uint32_t root = 0;

  /// returns the word of `other`'s root within this.
  std::uint32_t append(const Part& other) {
    const auto node = static_cast<std::uint32_t>(nodes.size() / kNodeWords);
    const auto leaf = static_cast<std::uint32_t>(leaves.size());
    const auto moved = [&](std::uint32_t word) { return word + ((word & kLeafBit) != 0 ? leaf : node); };
    for (std::size_t i = 0; i < other.nodes.size(); ++i)
      nodes.push_back(i % kNodeWords >= 4 ? moved(other.nodes[i]) : other.nodes[i]);
    leaves.insert(leaves.end(), other.leaves.begin(), other.leaves.end());
    return moved(other.root);
  }
};

class Builder {
 public:
  Builder(const CellScene& scene, const Point3& center) : scene_(scene), center_(center) {
    max_depth_ = 8 + static_cast<int>(1.3 * std::log2(static_cast<double>(scene.size()) + 1));
  }
  [[nodiscard]] int max_depth() const { return max_depth_; }

  [[nodiscard]] Part build(References&& references, const Solid& cell, CellBudget budget, int depth, int bad) const {
    const double as_leaf = kTriangleCost * static_cast<double>(references.size());
    const bool divide = depth < max_depth_ && references.size() > 1;
    const Plane plane = divide ? choose(references, cell) : Plane{};
    if (plane.cost > as_leaf) ++bad;
    if (!std::isfinite(plane.cost) || bad > kBadSplits || (plane.cost > 4 * as_leaf && references.size() < 16))
      return leaf(references);
    std::array<References, 2> side;
    for (const Reference& each : references) {
      for (std::size_t i = 0; i < 2; ++i) {
        Reference part = each.cut(i == 0 ? plane.front.opposite() : plane.front);
        if (!part.points.empty()) side[i].push_back(std::move(part));
      }
    }
    const std::size_t behind = side[0].size(), both = behind + side[1].size();
    if (!budget.allows(both) || std::min(behind, both - behind) >= references.size()) return leaf(references);
    References().swap(references);

    std::array<Part, 2> parts;
    const auto descend = [&](std::size_t i) {
      const Solid solid = clipped(cell, i == 0 ? plane.front.opposite() : plane.front);
      const CellBudget share = budget.share(side[i].size(), std::max<std::size_t>(both, 1));
      parts[i] = build(std::move(side[i]), solid, share, depth + 1, bad);
    };
    if (both >= kParallelLimit)
      tbb::parallel_invoke([&] { descend(0); }, [&] { descend(1); });
    else
      descend(0), descend(1);
    Part part;
    for (const float word : plane.words) part.nodes.push_back(std::bit_cast<std::uint32_t>(word));
    part.nodes.resize(kNodeWords);
    for (std::size_t i = 0; i < 2; ++i) {
      const std::uint32_t word = part.append(parts[i]);
      part.nodes[4 + i] = word;
    }
    return part;
  }

  /// A node of which both children are the leaf: the root is always inner.
  [[nodiscard]] static Part as_inner(const Part& leaf) {
    Part part;
    part.nodes.resize(kNodeWords, 0);
    part.nodes[0] = std::bit_cast<std::uint32_t>(1.0F);
    const std::uint32_t word = part.append(leaf);
    part.nodes[4] = part.nodes[5] = word;
    return part;
  }

 private:
  [[nodiscard]] Part leaf(const References& references) const {
    Part part;
    part.root = kLeafBit;
    part.leaves.push_back(static_cast<std::uint32_t>(references.size()));
    for (const Reference& each : references) part.leaves.push_back(scene_.id(each.triangle));
    return part;
  }

  /// Rounds a plane through `point` to what the traversal reads.
  [[nodiscard]] Plane rounded(const Point3& normal, const Point3& point) const {
    Plane plane;
    const double length = std::hypot(normal[0], normal[1], normal[2]);
    double offset = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      plane.words[k] = static_cast<float>(normal[k] / length);
      plane.front.normal[k] = double{plane.words[k]};
      offset += plane.front.normal[k] * (point[k] - center_[k]);
    }
    plane.words[3] = static_cast<float>(offset);
    plane.front.offset = double{plane.words[3]};
    for (std::size_t k = 0; k < 3; ++k) plane.front.offset += plane.front.normal[k] * center_[k];
    return plane;
  }

  void consider(const References& references, const Solid& cell, double area, const Point3& normal, const Point3& point,
                Plane& best) const {
    Plane plane = rounded(normal, point);
    if (!std::isfinite(plane.front.offset) || !std::isfinite(plane.words[0])) return;
    const HalfSpace behind = plane.front.opposite();
    const std::size_t step = (references.size() + kJudges - 1) / kJudges;
    double judges = 0, in_front = 0, in_back = 0;
    for (std::size_t i = 0; i < references.size(); i += step) {
      ++judges;
      in_front += references[i].is_in(plane.front) ? 1 : 0;
      in_back += references[i].is_in(behind) ? 1 : 0;
    }
    const double count = static_cast<double>(references.size()) / judges;
    // No areas for planes that cannot win whatever they are.
    if (in_front + in_back >= 2 * judges) return;
    const CutAreas areas = cut_areas(cell, plane.front);
    if (!(areas.front < area * (1 - 1e-9) && areas.behind < area * (1 - 1e-9))) return;
    const double gain = in_front == 0 || in_back == 0 ? kEmptyGain : 1.0;
    plane.cost = kStepCost + kTriangleCost * gain * count * (areas.front * in_front + areas.behind * in_back) / area;
    if (plane.cost < best.cost) best = plane;
  }

  [[nodiscard]] Plane choose(const References& references, const Solid& cell) const {
    Plane best;
    const double area = cell.area();
    if (!(area > 0) || !std::isfinite(area)) return best;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double lo = std::numeric_limits<double>::infinity(), hi = -lo;
      for (const Reference& each : references)
        for (const Point3& p : each.points) lo = std::min(lo, p[axis]), hi = std::max(hi, p[axis]);
      Point3 normal{}, point{};
      normal[axis] = 1;
      for (int i = 0; i <= kAxisPlanes + 1; ++i) {
        const double margin = 4 * references.front().slack;  // what touches a plane is on both sides
        const double w = i / (kAxisPlanes + 1.0);
        const bool finite = std::isfinite(margin);
        point[axis] = i == 0 && finite                 ? lo - margin
                      : i == kAxisPlanes + 1 && finite ? hi + margin
                                                       : lo + w * (hi - lo);
        consider(references, cell, area, normal, point, best);
      }
    }
    if (references.size() > kObliqueLimit) return best;
    const std::size_t step = std::max<std::size_t>(references.size() / kObliqueTriangles, 1);
    for (std::size_t i = 0; i < references.size(); i += step)
      consider_triangle(references, cell, area, references[i], best);
    return best;
  }

  /// The plane of a triangle, moved off it to either side so that it is on one alone, and planes through its edges.
  void consider_triangle(const References& references, const Solid& cell, double area, const Reference& triangle,
                         Plane& best) const {
    if (triangle.needle) return;
    const Polygon p = scene_.corners(triangle.triangle);
    const auto minus = [](const Point3& a, const Point3& b) { return Point3{a[0] - b[0], a[1] - b[1], a[2] - b[2]}; };
    const auto cross = [](const Point3& a, const Point3& b) {
      return Point3{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    };
    const Point3 normal = cross(minus(p[1], p[0]), minus(p[2], p[0]));
    const auto beside = [&](const Point3& n, const Point3& from, double distance) {
      const double length = std::hypot(n[0], n[1], n[2]);
      Point3 to = from;
      for (std::size_t k = 0; k < 3; ++k) to[k] += distance / length * n[k];
      consider(references, cell, area, n, to, best);
    };
    const double margin = 3 * triangle.slack;
    beside(normal, p[0], margin);
    beside(normal, p[0], -margin);
    for (std::size_t i = 0; i < 3; ++i) beside(cross(minus(p[(i + 1) % 3], p[i]), normal), p[i], margin);
  }

  const CellScene& scene_;
  Point3 center_;
  int max_depth_ = 0;
};

}  // namespace

Accel build_bsp(TriangleSoup triangles) {
  const CellScene scene(triangles);
  Accel accel = scene.begin("bsp", "bsp");
  Point3 lo{}, hi{}, center{};
  for (std::size_t k = 0; k < 3; ++k) {
    lo[k] = double{scene.box().lo[k]};
    hi[k] = double{scene.box().hi[k]};
    const float middle = scene.size() == 0 ? 0.0F : static_cast<float>(0.5 * lo[k] + 0.5 * hi[k]);
    center[k] = double{middle};
    accel.nodes[7 + k] = std::bit_cast<std::uint32_t>(middle);
  }
  References references(scene.size());
  for (std::uint32_t i = 0; i < references.size(); ++i) {
    CellScene::Region region = scene.region(i);
    Reference& each = references[i];
    const Box& box = scene.box_of(i);
    double size = 0;
    for (std::size_t k = 0; k < 3; ++k) size = std::max(size, double{box.hi[k]} - double{box.lo[k]});
    // What is not much larger than the slack is better off as its box, which needs none.
    const bool needle = region.polygon.empty() || region.slack > kMostSlack * size;
    each = {i, needle, needle ? 0 : region.slack, needle ? Polygon() : std::move(region.polygon)};
    if (!needle) continue;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      Point3 p{};
      for (std::size_t k = 0; k < 3; ++k) p[k] = double{(corner >> k & 1U) != 0 ? box.hi[k] : box.lo[k]};
      each.points.push_back(p);
    }
  }
  const Builder builder(scene, center);
  const Solid cell = scene.size() == 0 ? Solid{} : box_solid(lo, hi);
  Part tree = builder.build(std::move(references), cell, CellBudget::of(scene.size()), 0, 0);
  if (tree.nodes.empty()) tree = Builder::as_inner(tree);
  accel.nodes.insert(accel.nodes.end(), tree.nodes.begin(), tree.nodes.end());
  accel.leaves.assign(tree.leaves.begin(), tree.leaves.end());
  accel.node_count = tree.nodes.size() / kNodeWords;
  if (accel.node_count >= kMostNodes)
    throw InputError("the BSP tree has more nodes than it can number; try --accel bvh");
  accel.stack_size = static_cast<std::uint32_t>(builder.max_depth()) + 1;
  return accel;
}

}  // namespace eikon
