// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/lights_in_media.h"

#include <algorithm>

#include "pack/lights/find_lights.h"
#include "pack/lights/light_kind.h"
#include "pack/materials/camera_medium.h"
#include "pack/pack_parts.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxRecords = 1U << 28;  // triangles and shapes that are looked at for all lights together

std::array<glm::dvec3, 3> reals_of(const Triangle& t) {
  const auto [p0, p1, p2] = corners_of(t);
  return {p0, p1, p2};
}

glm::dvec3 low(const std::array<glm::dvec3, 3>& c) { return glm::min(c[0], glm::min(c[1], c[2])); }
glm::dvec3 high(const std::array<glm::dvec3, 3>& c) { return glm::max(c[0], glm::max(c[1], c[2])); }

bool boxes_meet(const glm::dvec3& lo, const glm::dvec3& hi, const glm::dvec3& other_lo, const glm::dvec3& other_hi) {
  return glm::all(glm::lessThanEqual(lo, other_hi)) && glm::all(glm::lessThanEqual(other_lo, hi));
}

bool separates(const glm::dvec3& axis, const std::array<glm::dvec3, 3>& a, const std::array<glm::dvec3, 3>& b) {
  const auto along = [&](const std::array<glm::dvec3, 3>& c) {
    return std::minmax({glm::dot(axis, c[0]), glm::dot(axis, c[1]), glm::dot(axis, c[2])});
  };
  const auto [a_lo, a_hi] = along(a);
  const auto [b_lo, b_hi] = along(b);
  return a_hi < b_lo || b_hi < a_lo;
}

}  // namespace

// Convex bodies do not meet if and only if some axis separates them; for triangles one of these
// does [Gottschalk, Lin, Manocha 1996, "OBBTree", section 5].
bool triangles_meet(const std::array<glm::dvec3, 3>& a, const std::array<glm::dvec3, 3>& b) {
  if (!boxes_meet(low(a), high(a), low(b), high(b))) return false;
  const auto edges = [](const std::array<glm::dvec3, 3>& c) {
    return std::array{c[1] - c[0], c[2] - c[1], c[0] - c[2]};
  };
  const std::array<glm::dvec3, 3> of_a = edges(a), of_b = edges(b);
  const glm::dvec3 normal_a = glm::cross(of_a[0], of_a[1]), normal_b = glm::cross(of_b[0], of_b[1]);
  if (separates(normal_a, a, b) || separates(normal_b, a, b)) return false;
  for (const glm::dvec3& e : of_a) {
    if (separates(glm::cross(normal_a, e), a, b)) return false;  // for triangles of one plane
    for (const glm::dvec3& f : of_b)
      if (separates(glm::cross(e, f), a, b)) return false;
  }
  return std::ranges::none_of(of_b, [&](const glm::dvec3& f) { return separates(glm::cross(normal_b, f), a, b); });
}

LightsInMedia::LightsInMedia(const PackedScene& packed, bool matters) : packed_(packed), matters_(matters) {
  for (std::size_t i = 0; matters && i < packed.triangles.size(); ++i)
    if (is_solid(packed.triangles[i].material)) solids_.push_back(std::uint32_t(i));
}

bool LightsInMedia::is_solid(std::uint32_t material) const {
  return (packed_.materials[material].flags & EK_MATERIAL_SOLID) != 0;
}

bool LightsInMedia::has_time() {
  looked_at_ += packed_.triangles.size();
  return looked_at_ <= kMaxRecords;
}

bool LightsInMedia::holds(const glm::dvec3& place) {
  return matters_ && (!has_time() || camera_medium(packed_, place, {0, -1, 0}) != 0);
}

bool LightsInMedia::may_hold(const Light& light) {
  if (!matters_) return false;
  const Triangle& record = packed_.triangles[light.triangle];
  if (is_solid(record.material) && (light.flags & EK_LIGHT_DOUBLE_SIDED) != 0) return true;
  if (light.kind == kind_word(LightKind::shape_light)) {
    const auto [lo, hi, _] = reals_of(record);
    return holds(0.5 * (lo + hi)) || cuts_box(lo, hi, record);
  }
  const glm::dvec3 p0(light.p0_x, light.p0_y, light.p0_z), p1(light.p1_x, light.p1_y, light.p1_z),
      p2(light.p2_x, light.p2_y, light.p2_z);
  if (holds(middle_of(light)) || cuts({p0, p1, p2}, record)) return true;
  return (light.flags & EK_LIGHT_QUAD) != 0 && cuts({p1, p1 + p2 - p0, p2}, record);
}

template <class Meets>
bool LightsInMedia::any_other_solid(const Triangle& record, const Meets& meets) {
  if (!has_time()) return true;
  return std::ranges::any_of(solids_, [&](std::uint32_t i) {
    const Triangle& solid = packed_.triangles[i];
    // The triangles of a surface meet at their edges.
    const bool is_same_surface = solid.node == record.node && solid.material == record.material;
    return !is_same_surface && meets(reals_of(solid), i >= packed_.triangle_count());
  });
}

bool LightsInMedia::cuts(const Corners& triangle, const Triangle& record) {
  return any_other_solid(record, [&](const Corners& solid, bool is_shape) {
    return is_shape ? boxes_meet(low(triangle), high(triangle), solid[0], solid[1]) : triangles_meet(triangle, solid);
  });
}

bool LightsInMedia::cuts_box(const glm::dvec3& lo, const glm::dvec3& hi, const Triangle& record) {
  return any_other_solid(record, [&](const Corners& solid, bool is_shape) {
    return is_shape ? boxes_meet(lo, hi, solid[0], solid[1]) : boxes_meet(lo, hi, low(solid), high(solid));
  });
}

}  // namespace eikon
