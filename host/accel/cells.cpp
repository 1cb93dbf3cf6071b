// SPDX-License-Identifier: Apache-2.0
#include "accel/cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace eikon {
namespace {

constexpr std::size_t kMostTriangles = std::size_t{1} << 26;  // lists of 16 entries for each are numbered in 31 bits
constexpr double kUnit = 0x1p-24;                             // u
constexpr double kReachLimit = 8;       // in halves of the scene's longest side: a camera at three times its size
constexpr double kConditionLimit = 64;  // k: a needle beyond

}  // namespace

CellScene::CellScene(TriangleSoup triangles) {
  if (triangles.size() > kMostTriangles) {
    throw InputError(fmt::format("cannot divide the space of {} triangles: the limit is {}; try --accel bvh",
                                 triangles.size(), kMostTriangles));
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (is_degenerate(triangles.corners(i))) continue;
    ids_.push_back(static_cast<std::uint32_t>(i));
    boxes_.push_back(triangle_box(triangles.corners(i)));
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

CellScene::Plane CellScene::plane_of(const float* corners) const {
  std::array<double, 3> p{}, q{};
  double longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    p[axis] = double{corners[3 + axis]} - double{corners[axis]};
    q[axis] = double{corners[6 + axis]} - double{corners[axis]};
    longest = std::max({longest, std::abs(p[axis]), std::abs(q[axis]), std::abs(p[axis] - q[axis])});
  }
  Plane plane{{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]}, 0, 0};
  const double length = std::hypot(plane.normal[0], plane.normal[1], plane.normal[2]);
  const double condition = longest * longest / length;
  if (!(condition <= kConditionLimit)) {
    plane.slack = std::numeric_limits<double>::infinity();
    return plane;
  }
  for (double& n : plane.normal) n /= length;
  for (std::size_t axis = 0; axis < 3; ++axis) plane.offset += plane.normal[axis] * double{corners[axis]};
  // u E (416 k + 24), and sqrt(3) (40 u E + 4 u |o|), |o| at most largest_ + E; rounded up, which covers double precision too.
  plane.slack = kUnit * (reach_limit_ * (512 * condition + 110) + 7 * largest_);
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

Accel CellScene::begin(const char* name, const char* layout) const {
  Accel accel;
  accel.name = name;
  accel.layout = layout;
  accel.nodes.resize(kCellsHeader, 0);
  const auto set = [&](std::size_t word, double value) {
    accel.nodes[word] = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  };
  // Rounded down, so that no ray beyond passes for one within.
  set(0, std::min(reach_limit_ * (1 - 0x1p-20), double{std::numeric_limits<float>::max()}));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    set(1 + axis, double{box_.lo[axis]});
    set(4 + axis, double{box_.hi[axis]});
  }
  return accel;
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
