// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/light_tree.h"

#include <fmt/format.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/error.h"

namespace eikon {
namespace {

constexpr int kBins = 16;
constexpr double kMinShare = 0x1p-20;       // the least share of a side in a node's power
constexpr double kMinVariance = 0x1p-40;    // in the nodes' unit; it keeps estimates within the range of floats
constexpr std::uint32_t kMinOfTask = 1024;  // lights of a side that is worth a task of its own

/// Sums of moments over lights.
struct Sum {
  double power = 0;
  glm::dvec3 first{0};           // power times centroid
  double second = 0;             // power times (variance + |centroid|^2)
  glm::dvec3 mean_direction{0};  // power times mean_direction
  std::uint32_t count = 0;

  Sum() = default;
  explicit Sum(const LightMoments& l)
      : power(l.power),
        first(l.power * l.centroid),
        second(l.power * (l.variance + glm::dot(l.centroid, l.centroid))),
        mean_direction(l.power * l.mean_direction),
        count(1) {}
  void add(const Sum& s) {
    power += s.power;
    first += s.first;
    second += s.second;
    mean_direction += s.mean_direction;
    count += s.count;
  }
  [[nodiscard]] LightMoments mean() const {
    LightMoments m;
    m.power = power;
    m.centroid = first / power;
    m.variance = std::max(second / power - glm::dot(m.centroid, m.centroid), 0.0);
    m.mean_direction = mean_direction / power;
    return m;
  }
  /// Grows with the places and the directions that the node's light comes from.
  [[nodiscard]] double cost() const {
    if (count == 0) return 0;
    const LightMoments m = mean();
    return power * m.variance * (1 + (1 - glm::dot(m.mean_direction, m.mean_direction)));
  }
};

class Builder {
 public:
  explicit Builder(std::vector<LightMoments> lights) : lights_(std::move(lights)) {
    tree_.order.resize(lights_.size());
    std::iota(tree_.order.begin(), tree_.order.end(), 0U);
    to_unit();
    tree_.nodes.resize(lights_.empty() ? 0 : lights_.size() - 1);
  }

  LightTree build() {
    if (!lights_.empty()) static_cast<void>(node({0, std::uint32_t(lights_.size())}, 0, 0));
    return std::move(tree_);
  }

 private:
  /// Divides powers by the largest, and scales positions to a unit of about the lights' extent.
  void to_unit() {
    double largest = 0, extent = 0;
    glm::dvec3 lo(std::numeric_limits<double>::infinity()), hi(-lo);
    for (const LightMoments& l : lights_) {
      largest = std::max(largest, l.power);
      extent = std::max(extent, std::sqrt(l.variance));
      lo = glm::min(lo, l.centroid);
      hi = glm::max(hi, l.centroid);
    }
    extent = std::max({extent, hi.x - lo.x, hi.y - lo.y, hi.z - lo.z});
    const glm::dvec3 center = lights_.empty() ? glm::dvec3(0) : 0.5 * (lo + hi);
    int exponent = 0;
    std::frexp(extent, &exponent);
    const double scale = extent > 0 ? std::ldexp(1.0, -exponent) : 1;
    tree_.scale = float(scale);
    center_ = center * scale;
    for (LightMoments& l : lights_) {
      l.power = std::max(l.power / largest, 1e-100);
      l.centroid = (l.centroid - center) * scale;
      l.variance *= scale * scale;
    }
  }

  /// Some lights: places in the order.
  struct Range {
    std::uint32_t begin = 0, end = 0;
    [[nodiscard]] std::uint32_t count() const { return end - begin; }
  };

  /// A plane between two bins of an axis.
  struct Plane {
    int axis = -1, bin = 0;  // the last bin on its left side; an axis of -1: no plane parts the lights
    double cost = std::numeric_limits<double>::infinity();
  };

  /// The box around the lights' centroids, cut into bins along each axis.
  struct Grid {
    glm::dvec3 lo{std::numeric_limits<double>::infinity()}, extent{0};
    [[nodiscard]] std::size_t bin_of(const LightMoments& light, int axis) const {
      return std::size_t(std::min(int((light.centroid[axis] - lo[axis]) / extent[axis] * kBins), kBins - 1));
    }
  };

  [[nodiscard]] Grid grid_of(Range range) const {
    Grid grid;
    glm::dvec3 hi(-grid.lo);
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      grid.lo = glm::min(grid.lo, at(i).centroid);
      hi = glm::max(hi, at(i).centroid);
    }
    grid.extent = hi - grid.lo;
    return grid;
  }

  /// The plane for which the costs of both sides have the least sum.
  [[nodiscard]] Plane best_plane(Range range, const Grid& grid) const {
    std::array<std::array<Sum, kBins>, 3> bins{};
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const Sum light(at(i));
      for (int axis = 0; axis < 3; ++axis)
        if (grid.extent[axis] > 0) bins[std::size_t(axis)][grid.bin_of(at(i), axis)].add(light);
    }
    Plane best;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(grid.extent[axis] > 0)) continue;
      const std::array<Sum, kBins>& of_axis = bins[std::size_t(axis)];
      std::array<Sum, kBins> right{};
      right[kBins - 1] = of_axis[kBins - 1];
      for (std::size_t b = kBins - 1; b-- > 0;) {
        right[b] = right[b + 1];
        right[b].add(of_axis[b]);
      }
      Sum left;
      for (std::size_t b = 0; b + 1 < kBins; ++b) {
        left.add(of_axis[b]);
        if (left.count == 0 || right[b + 1].count == 0) continue;
        const double cost = left.cost() + right[b + 1].cost();
        if (cost < best.cost) best = {axis, int(b), cost};
      }
    }
    return best;
  }

  /// Orders the lights and returns the place at which to split them.
  std::uint32_t split(Range range, int depth) {
    const Grid grid = grid_of(range);
    const Plane plane = depth < most_depth() ? best_plane(range, grid) : Plane{};
    const auto first = tree_.order.begin() + range.begin, last = tree_.order.begin() + range.end;
    if (plane.axis >= 0) {
      const auto is_left = [&](std::uint32_t light) {
        return int(grid.bin_of(lights_[light], plane.axis)) <= plane.bin;
      };
      return std::uint32_t(std::stable_partition(first, last, is_left) - tree_.order.begin());
    }
    // If all lights are in one place, or the tree gets too deep, they are halved along the longest
    // axis.
    const glm::dvec3& extent = grid.extent;
    const int axis = extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
    std::stable_sort(first, last, [&](std::uint32_t a, std::uint32_t b) {
      return lights_[a].centroid[axis] < lights_[b].centroid[axis];
    });
    return range.begin + range.count() / 2;
  }

  /// Writes the nodes of a range's tree from `place` on, one fewer than it has lights. Threads
  /// share the work; each sum is taken in the same order whoever takes it.
  Sum node(Range range, std::size_t place, int depth) {
    if (range.count() == 1) {
      Sum leaf;
      leaf.add(Sum(at(range.begin)));  // to 0, which makes zeros positive
      return leaf;
    }
    const std::uint32_t middle = split(range, depth);
    const Range left{range.begin, middle}, right{middle, range.end};
    Sum of_left, of_right;
    const auto do_left = [&] { of_left = node(left, place + 1, depth + 1); };
    const auto do_right = [&] { of_right = node(right, place + left.count(), depth + 1); };
    if (std::min(left.count(), right.count()) >= kMinOfTask) {
      tbb::parallel_invoke(do_left, do_right);
    } else {
      do_left();
      do_right();
    }
    tree_.nodes[place] = record(of_left.mean(), of_right.mean(), left.count(), right.count() == 1);
    of_left.add(of_right);
    return of_left;
  }

  LightNode record(const LightMoments& a, const LightMoments& b, std::uint32_t left_count, bool right_is_light) const {
    LightNode n{};
    const glm::dvec3 left = a.centroid + center_, right = b.centroid + center_;
    n.left_centroid_x = float(left.x), n.left_centroid_y = float(left.y), n.left_centroid_z = float(left.z);
    n.left_variance = float(std::max(a.variance, kMinVariance));
    n.left_mean_direction_x = float(a.mean_direction.x);
    n.left_mean_direction_y = float(a.mean_direction.y);
    n.left_mean_direction_z = float(a.mean_direction.z);
    n.left_share = float(std::clamp(a.power / (a.power + b.power), kMinShare, 1 - kMinShare));
    n.right_centroid_x = float(right.x), n.right_centroid_y = float(right.y), n.right_centroid_z = float(right.z);
    n.right_variance = float(std::max(b.variance, kMinVariance));
    n.right_mean_direction_x = float(b.mean_direction.x);
    n.right_mean_direction_y = float(b.mean_direction.y);
    n.right_mean_direction_z = float(b.mean_direction.z);
    n.link = left_count | (right_is_light ? LIGHT_TREE_RIGHT_IS_LIGHT : 0);
    return n;
  }

  [[nodiscard]] int most_depth() const { return 2 * int(std::bit_width(lights_.size())) + 8; }
  [[nodiscard]] const LightMoments& at(std::uint32_t place) const { return lights_[tree_.order[place]]; }

  std::vector<LightMoments> lights_;  // in the nodes' unit, about center_
  glm::dvec3 center_{0};
  LightTree tree_;
};

}  // namespace

LightTree build_light_tree(std::vector<LightMoments> lights) {
  if (lights.size() > (std::size_t{1} << 28))
    throw InternalError(fmt::format("a tree of {} lights: at most 2^28", lights.size()));
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const LightMoments& l = lights[i];
    const double sum =
        l.power + glm::dot(l.centroid, l.centroid) + l.variance + glm::dot(l.mean_direction, l.mean_direction);
    if (!(l.power > 0) || !std::isfinite(sum))
      throw InternalError(fmt::format("light {} has no power, or moments that are not finite", i));
  }
  return Builder(std::move(lights)).build();
}

}  // namespace eikon
