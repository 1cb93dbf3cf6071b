// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "core/error.h"
#include "pack/geometry/solid_openings.h"
#include "pack/pack_parts.h"
#include "scene/endless.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxSurfaces = std::uint64_t{1} << 28;  // that layouts of trees can number
constexpr double kSlack = 0x1p-20;  // of a box's extent; more than the rounding error of its matrix in floats

ShapeRecord record_of(const OwnShape& own, ShapeKind kind) {
  const glm::dmat3 &w = own.world_from_own, l = glm::inverse(w);
  ShapeRecord r{};
  r.x_x = float(l[0][0]), r.x_y = float(l[1][0]), r.x_z = float(l[2][0]);
  r.y_x = float(l[0][1]), r.y_y = float(l[1][1]), r.y_z = float(l[2][1]);
  r.z_x = float(l[0][2]), r.z_y = float(l[1][2]), r.z_z = float(l[2][2]);
  r.center_x = float(own.center.x), r.center_y = float(own.center.y), r.center_z = float(own.center.z);
  r.a = float(own.parameters[0]), r.b = float(own.parameters[1]), r.c = float(own.parameters[2]);
  r.kind = std::uint32_t(kind);
  r.wx_x = float(w[0][0]), r.wx_y = float(w[1][0]), r.wx_z = float(w[2][0]);
  r.wy_x = float(w[0][1]), r.wy_y = float(w[1][1]), r.wy_z = float(w[2][1]);
  r.wz_x = float(w[0][2]), r.wz_y = float(w[1][2]), r.wz_z = float(w[2][2]);
  return r;
}

/// True if the shape is a sphere in the world. Then it fills its box, and its centre tells early
/// which rays miss it (traverse/wide/wide.h). Its axes differ by less than the slack of the box.
bool is_round(ShapeKind kind, const glm::dmat3& world_from_own) {
  if (kind != ShapeKind::sphere) return false;
  const glm::dmat3 squares = glm::transpose(world_from_own) * world_from_own;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(squares[i][j] - (i == j ? squares[0][0] : 0)) <= 0x1p-24 * squares[0][0])) return false;
  return true;
}

}  // namespace

void pack_shapes(const Scene& scene, const Features& features, PackedScene& packed) {
  if (scene.shapes.empty()) return;
  packed.formulas = scene.formulas;
  const std::uint64_t all = packed.triangles.size() + scene.shapes.size();
  if (all > kMaxSurfaces)
    throw InputError(
        fmt::format("{}: {} triangles and shapes are more than {}; use fewer", scene.path.string(), all, kMaxSurfaces));
  const PassableMaterials passable(scene);
  const SolidOpenings solid_openings = features.has(Feature::open_solid) ? SolidOpenings(scene) : SolidOpenings();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  packed.triangles.reserve(all);
  for (std::size_t i = 0; i < scene.shapes.size(); ++i) {
    const Shape& shape = scene.shapes[i];
    const OwnShape own = own_shape(shape);
    ShapeRecord record = record_of(own, shape.kind);
    record.middle_x = float(shape.middle.x), record.middle_y = float(shape.middle.y),
    record.middle_z = float(shape.middle.z);
    const Material& material = scene.materials[shape.material];
    const bool has_openings = passable.has(shape.material) && shape.kind != ShapeKind::implicit;
    record.formula = has_openings && material.double_sided ? EK_SHAPE_SHOWS_INSIDE : shape.formula;
    packed.shapes.push_back(record);
    const glm::dvec3 center(record.center_x, record.center_y, record.center_z);
    const glm::dvec3 lo = center - own.half * (1 + kSlack), hi = center + own.half * (1 + kSlack);
    const glm::dvec3 extent = is_endless(shape) ? own_shape(bounded_piece(shape)).half * (1 + kSlack) : hi - center;
    packed.bounds.lo = glm::min(packed.bounds.lo, center - extent);
    packed.bounds.hi = glm::max(packed.bounds.hi, center + extent);
    Triangle t{};
    t.p0_x = down(lo.x), t.p0_y = down(lo.y), t.p0_z = down(lo.z);
    t.p1_x = up(hi.x), t.p1_y = up(hi.y), t.p1_z = up(hi.z);
    t.p2_x = std::copysign(nan, is_round(shape.kind, own.world_from_own) ? -1.0F : 1.0F);
    t.p2_y = t.p2_z = nan;
    t.material = shape.material;
    t.node = std::uint32_t(scene.nodes.size() + i);
    t.n_x = std::bit_cast<float>(std::uint32_t(i));
    t.flags = has_openings && !solid_openings.has(shape) ? EK_TRIANGLE_ALPHA_TESTED : 0;
    t.flags |= surface_flags(material, nullptr);
    t.flags |= light_group(shape.light_group, material) << EK_TRIANGLE_GROUP_SHIFT;
    packed.triangles.push_back(t);
  }
  // The fields that only triangles have are never read, or mean that there is none.
  const auto fill = [&](auto& records, bool needed) {
    if (needed) records.resize(all);
  };
  fill(packed.normals, features.has(Feature::vertex_normal) || features.has(Feature::uv));
  fill(packed.tangents, features.has(Feature::tangent) || features.has(Feature::uv1));
  if (features.has(Feature::vertex_color)) {
    const TriangleColors white{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0};
    packed.colors.reserve(all);
    while (packed.colors.size() < all) packed.colors.push_back(white);
  }
}

}  // namespace eikon
