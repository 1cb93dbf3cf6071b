// SPDX-License-Identifier: Apache-2.0
// Finds lights that may shine within a solid. A light path begins outside of all solids, so none
// can start from these.
#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "pack/pack.h"

namespace eikon {

/// Finds them in one packed scene. A big scene has too many triangles to look at for each light:
/// after about a second it says of every light that it may.
class LightsInMedia {
 public:
  /// matters  false if no solid absorbs or has a priority: then none is found
  LightsInMedia(const PackedScene& packed, bool matters);

  /// True if a place is within a solid.
  [[nodiscard]] bool holds(const glm::dvec3& place);
  /// True if a light of a surface may shine within a solid: its middle is within one, the surface
  /// of one cuts it, or it is that surface and shines to both sides. Shapes are taken for their
  /// boxes.
  [[nodiscard]] bool may_hold(const Light& light);

 private:
  using Corners = std::array<glm::dvec3, 3>;

  [[nodiscard]] bool has_time();
  /// Calls meets(corners, whether it is a shape) for the triangles and shapes of solids, but for
  /// the surface that the record is part of, until it is true. The first two corners of a shape are
  /// those of its box.
  template <class Meets>
  [[nodiscard]] bool any_other_solid(const Triangle& record, const Meets& meets);
  [[nodiscard]] bool cuts(const Corners& triangle, const Triangle& record);
  [[nodiscard]] bool cuts_box(const glm::dvec3& lo, const glm::dvec3& hi, const Triangle& record);
  [[nodiscard]] bool is_solid(std::uint32_t material) const;

  const PackedScene& packed_;
  bool matters_;
  std::vector<std::uint32_t> solids_;  // triangles and shapes that are the surface of one
  std::uint64_t looked_at_ = 0;
};

/// True if two triangles have a point in common; also, now and then, if they only nearly have one.
[[nodiscard]] bool triangles_meet(const std::array<glm::dvec3, 3>& a, const std::array<glm::dvec3, 3>& b);

}  // namespace eikon
