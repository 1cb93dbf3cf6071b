// SPDX-License-Identifier: Apache-2.0
#include "accel/classic/cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "scene/endless.h"

namespace eikon {
namespace {

constexpr std::size_t kMaxTriangles = std::size_t{1} << 26;  // lists of 16 entries for each are numbered in 31 bits
// In halves of the scene's longest side. It allows a camera at three times the scene's size.
constexpr double kReachLimit = 8;

}  // namespace

CellScene::CellScene(TriangleSoup triangles) : triangles_(triangles) {
  if (triangles.size() > kMaxTriangles) {
    throw InputError(fmt::format("cannot divide the space of {} triangles: the limit is {}; try --accel bvh",
                                 triangles.size(), kMaxTriangles));
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (is_degenerate(triangles, i)) continue;
    if (triangles.is_box(i) && is_endless_box(triangles.corners(i))) {
      endless_.push_back(static_cast<std::uint32_t>(i));
      continue;
    }
    ids_.push_back(static_cast<std::uint32_t>(i));
    boxes_.push_back(triangle_box(triangles, i));
    box_.add(boxes_.back());
  }
  double half = 0;
  for (std::size_t axis = 0; axis < 3 && !ids_.empty(); ++axis) {
    half = std::max(half, 0.5 * (double{box_.hi[axis]} - double{box_.lo[axis]}));
    largest_ = std::max({largest_, std::abs(double{box_.lo[axis]}), std::abs(double{box_.hi[axis]})});
  }
  reach_limit_ = kReachLimit * half;
  for (const std::uint32_t id : ids_) planes_.push_back(plane_of(triangles.corners(id)));
}

namespace {


/// A point within `around` of the box, projected along the normal, is a weighted mean of the
/// corners. Returns the largest sum of the absolute weights. normal: of any length
double most_weights(const std::array<Point3, 3>& p, const Point3& normal, const Box& box, double around) {
  double most = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    Point3 x{};
    for (std::size_t k = 0; k < 3; ++k)
      x[k] = (corner >> k & 1U) != 0 ? double{box.hi[k]} + around : double{box.lo[k]} - around;
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += std::abs(dot(cross(minus(p[i], x), minus(p[(i + 1) % 3], x)), normal));
    most = std::max(most, sum);
  }
  return most / dot(normal, normal);
}

}  // namespace

CellScene::Plane CellScene::plane_of(const float* corners) const {
  std::array<Point3, 3> p{};
  for (std::size_t i = 0; i < 9; ++i) p[i / 3][i % 3] = double{corners[i]};
  // A box has NaN for its third corner, and has no plane either.
  Plane plane{cross(minus(p[1], p[0]), minus(p[2], p[0])), 0, std::numeric_limits<double>::infinity()};
  const Box box = triangle_box(corners);
  double longest = 0;  // s
  for (std::size_t axis = 0; axis < 3; ++axis) longest = std::max(longest, double{box.hi[axis]} - double{box.lo[axis]});
  const double length = std::hypot(plane.normal[0], plane.normal[1], plane.normal[2]);  // |M|
  if (!(664 * kUnit * reach_limit_ * (longest + 2 * error()) <= length)) return plane;
  const double weights = most_weights(p, plane.normal, box, error());
  for (double& n : plane.normal) n /= length;
  plane.offset = dot(plane.normal, p[0]);
  // Item 2 of traverse/classic/cells.h, and sqrt(3) (40 u E + 4 u |o|) with |o| <= largest_ + E.
  // Rounding up covers the errors of double precision too.
  plane.slack =
      1.01 * kUnit * (reach_limit_ * (14 * (weights + 1) + 20) + 200 * (longest * longest / length) * longest) +
      error();
  return plane;
}

CellReferences CellScene::references() const {
  CellReferences all(size());
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    const Box& box = boxes_[i];
    all[i] = {{box.lo[0], box.lo[1], box.lo[2]}, {box.hi[0], box.hi[1], box.hi[2]}, i};
  }
  return all;
}

bool CellScene::may_be_hit(const CellReference& part) const {
  const Plane& plane = planes_[part.triangle];
  double distance = -plane.offset, radius = plane.slack;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double lo = part.lo[axis], hi = part.hi[axis];
    distance += plane.normal[axis] * (0.5 * (lo + hi));
    radius += std::abs(plane.normal[axis]) * (0.5 * (hi - lo));
  }
  return !(std::abs(distance) > radius);
}

Polygon CellScene::corners(std::uint32_t number) const {
  const float* p = triangles_.corners(ids_[number]);
  Polygon corners;
  for (std::size_t i = 0; i < 9; i += 3) corners.push_back({double{p[i]}, double{p[i + 1]}, double{p[i + 2]}});
  return corners;
}

CellScene::Region CellScene::region(std::uint32_t number) const {
  const Plane& plane = planes_[number];
  Region region{{}, plane.slack};
  if (!std::isfinite(plane.slack)) return region;
  // Begins with a square of the plane around the box, and cuts it to the box grown by slack. The
  // foot of every point that is in the box and within slack of the plane lies in this polygon.
  const Box& box = boxes_[number];
  Point3 middle{}, u{}, v{};
  double radius = 0, height = -plane.offset;
  std::size_t least = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    middle[k] = 0.5 * double{box.lo[k]} + 0.5 * double{box.hi[k]};
    height += plane.normal[k] * middle[k];
    radius += double{box.hi[k]} - double{box.lo[k]} + 4 * plane.slack;
    if (std::abs(plane.normal[k]) < std::abs(plane.normal[least])) least = k;
  }
  u[least] = 1;
  const Point3& n = plane.normal;
  v = {n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]};
  u = {v[1] * n[2] - v[2] * n[1], v[2] * n[0] - v[0] * n[2], v[0] * n[1] - v[1] * n[0]};
  for (const auto& [a, b] : {std::pair{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}) {
    Point3 corner{};
    for (std::size_t k = 0; k < 3; ++k)
      corner[k] = middle[k] - height * n[k] + 2 * radius * (a * u[k] + b * v[k]);  // u and v are at least 0.8 long
    region.polygon.push_back(corner);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    HalfSpace side{{}, double{box.lo[k]}};
    side.normal[k] = 1;
    region.polygon = clipped(region.polygon, side, -plane.slack);
    side = {{}, -double{box.hi[k]}};
    side.normal[k] = -1;
    region.polygon = clipped(region.polygon, side, -plane.slack);
  }
  return region;
}

Accel CellScene::begin(const char* name, const char* layout) const {
  Accel accel{.name = name, .layout = layout};
  accel.nodes.resize(kCellsHeader, 0);
  const auto set = [&](std::size_t word, double value) {
    accel.nodes[word] = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  };
  // The limit is rounded down, so that no ray beyond it counts as one within.
  set(0, std::min(reach_limit_ * (1 - 0x1p-20), double{std::numeric_limits<float>::max()}));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    set(1 + axis, double{box_.lo[axis]});
    set(4 + axis, double{box_.hi[axis]});
  }
  return accel;
}

void CellScene::finish(Accel& accel) const {
  accel.nodes[13] = static_cast<std::uint32_t>(accel.leaves.size());
  accel.nodes[14] = static_cast<std::uint32_t>(endless_.size());
  accel.leaves.insert(accel.leaves.end(), endless_.begin(), endless_.end());
  if (accel.leaves.empty()) accel.leaves.push_back(0);
}

bool cut(const CellScene& scene, const CellReference& parent, std::size_t axis, float plane, std::size_t side,
         CellReference& part) {
  const float lo = parent.lo[axis], hi = parent.hi[axis];
  if (side == 0 ? !(lo < plane || hi <= plane) : !(hi > plane)) return false;
  part = parent;
  if (side == 0)
    part.hi[axis] = std::min(hi, plane);
  else
    part.lo[axis] = std::max(lo, plane);
  return scene.may_be_hit(part);
}

}  // namespace eikon
