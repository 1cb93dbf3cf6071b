// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/light_tree.h"

#include <fmt/format.h>

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
constexpr double kLeastShare = 0x1p-20;     // the least share of a side in a node's energy
constexpr double kLeastVariance = 0x1p-40;  // in the nodes' unit; it keeps estimates within the range of floats

/// Sums of moments over lights.
struct Sum {
  double power = 0;
  glm::dvec3 first{0};           // power times centroid
  double second = 0;             // power times (variance + |centroid|^2)
  glm::dvec3 mean_direction{0};  // power times mean_direction
  std::uint32_t count = 0;

  void add(const LightMoments& l) {
    power += l.power;
    first += l.power * l.centroid;
    second += l.power * (l.variance + glm::dot(l.centroid, l.centroid));
    mean_direction += l.power * l.mean_direction;
    ++count;
  }
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
    tree_.nodes.reserve(lights_.size());
  }

  LightTree build() {
    if (!lights_.empty()) node(0, std::uint32_t(lights_.size()), 0);
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

  /// Orders lights [begin, end) and returns the index at which to split them.
  std::uint32_t split(std::uint32_t begin, std::uint32_t end, int depth) {
    glm::dvec3 lo(std::numeric_limits<double>::infinity()), hi(-lo);
    for (std::uint32_t i = begin; i < end; ++i) {
      lo = glm::min(lo, at(i).centroid);
      hi = glm::max(hi, at(i).centroid);
    }
    const glm::dvec3 extent = hi - lo;
    double best = std::numeric_limits<double>::infinity();
    int best_axis = -1, best_bin = 0;
    const auto bin_of = [&](std::uint32_t light, int axis) {
      return std::min(int((lights_[light].centroid[axis] - lo[axis]) / extent[axis] * kBins), kBins - 1);
    };
    for (int axis = 0; axis < 3 && depth < most_depth(); ++axis) {
      if (!(extent[axis] > 0)) continue;
      std::array<Sum, kBins> bins{}, right{};
      for (std::uint32_t i = begin; i < end; ++i) bins[std::size_t(bin_of(tree_.order[i], axis))].add(at(i));
      right[kBins - 1] = bins[kBins - 1];
      for (int b = kBins - 2; b >= 0; --b) {
        right[std::size_t(b)] = right[std::size_t(b + 1)];
        right[std::size_t(b)].add(bins[std::size_t(b)]);
      }
      Sum left;
      for (int b = 0; b + 1 < kBins; ++b) {
        left.add(bins[std::size_t(b)]);
        const Sum& other = right[std::size_t(b + 1)];
        if (left.count == 0 || other.count == 0) continue;
        const double cost = left.cost() + other.cost();
        if (cost < best) best = cost, best_axis = axis, best_bin = b;
      }
    }
    const auto first = tree_.order.begin() + begin, last = tree_.order.begin() + end;
    if (best_axis >= 0)
      return std::uint32_t(std::stable_partition(
                               first, last, [&](std::uint32_t light) { return bin_of(light, best_axis) <= best_bin; }) -
                           tree_.order.begin());
    // If all lights are in one place, or the tree gets too deep, they are halved along the longest
    // axis.
    const int axis = extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::stable_sort(first, last, [&](std::uint32_t a, std::uint32_t b) {
      return lights_[a].centroid[axis] < lights_[b].centroid[axis];
    });
    return middle;
  }

  Sum node(std::uint32_t begin, std::uint32_t end, int depth) {
    if (end - begin == 1) {
      Sum leaf;
      leaf.add(at(begin));
      return leaf;
    }
    const std::size_t place = tree_.nodes.size();
    tree_.nodes.emplace_back();
    const std::uint32_t middle = split(begin, end, depth);
    const Sum left = node(begin, middle, depth + 1), right = node(middle, end, depth + 1);
    tree_.nodes[place] = record(left.mean(), right.mean(), middle - begin, end - middle == 1);
    Sum both = left;
    both.add(right);
    return both;
  }

  LightNode record(const LightMoments& a, const LightMoments& b, std::uint32_t left_count, bool right_is_light) const {
    LightNode n{};
    const glm::dvec3 left = a.centroid + center_, right = b.centroid + center_;
    n.left_centroid_x = float(left.x), n.left_centroid_y = float(left.y), n.left_centroid_z = float(left.z);
    n.left_variance = float(std::max(a.variance, kLeastVariance));
    n.left_mean_direction_x = float(a.mean_direction.x);
    n.left_mean_direction_y = float(a.mean_direction.y);
    n.left_mean_direction_z = float(a.mean_direction.z);
    n.left_share = float(std::clamp(a.power / (a.power + b.power), kLeastShare, 1 - kLeastShare));
    n.right_centroid_x = float(right.x), n.right_centroid_y = float(right.y), n.right_centroid_z = float(right.z);
    n.right_variance = float(std::max(b.variance, kLeastVariance));
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
