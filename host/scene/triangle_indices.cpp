// SPDX-License-Identifier: Apache-2.0
#include "scene/triangle_indices.h"

#include <algorithm>
#include <limits>
#include <type_traits>

namespace eikon {
namespace {

template <class T>
SharedVector<T> read_corners(const TriangleIndices::Source& source, std::size_t count) {
  std::vector<T> corners(count);
  for (std::size_t i = 0; i < count; ++i) corners[i] = static_cast<T>(source.corner(i));
  return corners;
}

}  // namespace

TriangleIndices::TriangleIndices(const Source& source) : mode_(source.mode) {
  const bool is_list = mode_ == TriangleMode::list;
  const std::size_t count = is_list ? source.count / 3 * 3 : source.count;
  if (count < 3) return;
  if (source.largest <= std::numeric_limits<std::uint8_t>::max())
    corners_ = read_corners<std::uint8_t>(source, count);
  else if (source.largest <= std::numeric_limits<std::uint16_t>::max())
    corners_ = read_corners<std::uint16_t>(source, count);
  else
    corners_ = read_corners<std::uint32_t>(source, count);
  if (is_list) return;
  const auto is_dropped = [&](std::size_t at) {
    const std::array<std::uint32_t, 3> t = triangle_at(at);
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  };
  std::size_t drops = 0;
  for (std::size_t at = 0; at + 2 < count; ++at) drops += is_dropped(at) ? 1 : 0;
  if (drops <= count / 8) {
    std::vector<std::uint32_t> dropped;
    dropped.reserve(drops);
    for (std::size_t at = 0; at + 2 < count; ++at)
      if (is_dropped(at)) dropped.push_back(static_cast<std::uint32_t>(at));
    dropped_ = std::move(dropped);
    return;
  }
  // To number so many would take more memory than a list of the rest.
  std::size_t at = 0;
  const Source kept{.mode = TriangleMode::list,
                    .count = 3 * (count - 2 - drops),
                    .largest = source.largest,
                    .corner = [&](std::size_t i) {
                      if (i > 0 && i % 3 == 0) ++at;
                      while (is_dropped(at)) ++at;
                      return triangle_at(at)[i % 3];
                    }};
  *this = TriangleIndices(kept);
}

std::size_t TriangleIndices::corner_count() const {
  return std::visit([](const auto& corners) { return corners.size(); }, corners_);
}

std::size_t TriangleIndices::triangle_count() const {
  const std::size_t count = corner_count();
  if (mode_ == TriangleMode::list) return count / 3;
  return count < 3 ? 0 : count - 2 - dropped_.size();
}

std::array<std::uint32_t, 3> TriangleIndices::triangle_at(std::size_t at) const {
  if (mode_ == TriangleMode::fan) return {corner(at + 1), corner(at + 2), corner(0)};
  return {corner(at), corner(at + 1 + at % 2), corner(at + 2 - at % 2)};
}

std::array<std::uint32_t, 3> TriangleIndices::triangle(std::size_t t) const {
  if (mode_ == TriangleMode::list) return {corner(3 * t), corner(3 * t + 1), corner(3 * t + 2)};
  // The k-th that is dropped stands before triangle t if no more than t kept ones stand before it.
  std::size_t before = 0;
  for (std::size_t end = dropped_.size(); before < end;) {
    const std::size_t k = before + (end - before) / 2;
    if (dropped_.all()[k] - k <= t)
      before = k + 1;
    else
      end = k;
  }
  return triangle_at(t + before);
}

std::vector<std::uint32_t> TriangleIndices::list() const {
  std::vector<std::uint32_t> all;
  all.reserve(size());
  for (std::size_t t = 0; t < triangle_count(); ++t) {
    const std::array<std::uint32_t, 3> corners = triangle(t);
    all.insert(all.end(), corners.begin(), corners.end());
  }
  return all;
}

std::size_t TriangleIndices::bytes() const {
  return dropped_.size() * sizeof(std::uint32_t) +
         std::visit([](const auto& corners) { return corners.size() * sizeof(corners.all()[0]); }, corners_);
}

void TriangleIndices::push_back(std::uint32_t index) {
  if (mode_ != TriangleMode::list || !std::holds_alternative<Words>(corners_)) *this = TriangleIndices(list());
  std::get<Words>(corners_).push_back(index);
}

void TriangleIndices::renumber(const std::vector<std::uint32_t>& number) {
  std::visit(
      [&](auto& corners) {
        for (auto& corner : corners) corner = static_cast<std::remove_reference_t<decltype(corner)>>(number[corner]);
      },
      corners_);
}

}  // namespace eikon
