// SPDX-License-Identifier: Apache-2.0
#include "pack/materials/camera_medium.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "formula/evaluate.h"
#include "pack/pack_parts.h"

namespace eikon {
namespace {

struct Corners {
  glm::dvec3 a, b, c;  // from the eye
};

Corners seen_from(const glm::dvec3& eye, const std::array<glm::vec3, 3>& t) {
  return {glm::dvec3(t[0]) - eye, glm::dvec3(t[1]) - eye, glm::dvec3(t[2]) - eye};
}

/// The signed solid angle of a triangle: positive if its back is seen, as it is from inside.
double solid_angle(const Corners& t) {
  const double a = glm::length(t.a), b = glm::length(t.b), c = glm::length(t.c);
  const double volume = glm::dot(t.a, glm::cross(t.b, t.c));
  const double rest = a * b * c + glm::dot(t.a, t.b) * c + glm::dot(t.b, t.c) * a + glm::dot(t.c, t.a) * b;
  return volume == 0 && rest == 0 ? 0 : 2 * std::atan2(volume, rest);
}

/// The distance, in lengths of `view`, at which a ray from the eye leaves through the triangle;
/// infinite if it does not.
double way_out(const Corners& t, const glm::dvec3& view) {
  const double u = glm::dot(view, glm::cross(t.c, t.b)), v = glm::dot(view, glm::cross(t.a, t.c)),
               w = glm::dot(view, glm::cross(t.b, t.a));
  const double infinite = std::numeric_limits<double>::infinity();
  if (u > 0 || v > 0 || w > 0 || u + v + w == 0) return infinite;
  const double distance = glm::dot(t.a, glm::cross(t.b, t.c)) / -(u + v + w);
  return distance > 0 ? distance : infinite;
}

/// The same for the surface f = 0 within bounds. o and d are in the formula's coordinates, relative
/// to the middle of the bounds. The result is the first of a few thousand places with f above 0,
/// which is precise enough to order media.
double way_out(const ShapeRecord& r, const formula::Formula& f, const glm::dvec3& o, const glm::dvec3& d) {
  constexpr int kPlaces = 4096;
  double end = std::numeric_limits<double>::infinity();
  const glm::dvec3 extent(r.a, r.b, r.c), middle(r.middle_x, r.middle_y, r.middle_z);
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(o[axis]) < extent[axis])) return 0;
    if (d[axis] != 0) end = std::min(end, (std::copysign(extent[axis], d[axis]) - o[axis]) / d[axis]);
  }
  for (int i = 0; i < kPlaces; ++i) {
    const double distance = end * i / kPlaces;
    const glm::dvec3 p = middle + o + distance * d;
    if (!(formula::evaluate_double(f.expressions, f.value, {p.x, p.y, p.z, 0, 0, 0}) < 0)) return distance;
  }
  return end;
}

/// True if a convex solid shape contains a point of its object space.
bool holds(const ShapeRecord& r, const glm::dvec3& p) {
  const double round = std::hypot(p.x, p.z), a = double{r.a}, b = double{r.b}, c = double{r.c};
  switch (ShapeKind(r.kind)) {
    case ShapeKind::sphere:
      return glm::length(p) < 1;
    case ShapeKind::box:
      return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < 1;
    case ShapeKind::plane:
      return false;
    case ShapeKind::cylinder:
      return std::abs(p.y) < 1 && round < a + b * p.y;
    case ShapeKind::capsule: {
      if (std::hypot(round, p.y - a) < b || std::hypot(round, p.y + a) < c) return true;
      const double tilt = (c - b) / (2 * a), flat = std::sqrt(1 - tilt * tilt);  // of the side's normal
      return std::abs(tilt) < 1 && p.y > c * tilt - a && p.y < b * tilt + a &&
             round * flat < 0.5 * (b + c) - tilt * p.y;
    }
    case ShapeKind::implicit:
      return false;  // way_out evaluates its formula instead
  }
  return false;
}

/// The length of a ray along `view` inside a shape that contains `eye`; 0 if the shape does not
/// contain it.
double way_out(const ShapeRecord& r, const std::vector<formula::Formula>& formulas, const glm::dvec3& eye,
               const glm::dvec3& view) {
  const glm::dvec3 from = eye - glm::dvec3(r.center_x, r.center_y, r.center_z);
  const auto own = [&](const glm::dvec3& v) {
    return glm::dvec3(glm::dot(glm::dvec3(r.x_x, r.x_y, r.x_z), v), glm::dot(glm::dvec3(r.y_x, r.y_y, r.y_z), v),
                      glm::dot(glm::dvec3(r.z_x, r.z_y, r.z_z), v));
  };
  const glm::dvec3 o = own(from), d = own(view);
  if (ShapeKind(r.kind) == ShapeKind::implicit) return way_out(r, formulas.at(r.formula), o, d);
  if (!holds(r, o)) return 0;
  double inside = 0, outside = 4 * (1 + double{r.a}) / glm::length(d);  // no shape is larger than 4 (1 + a) across
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (inside + outside);
    (holds(r, o + middle * d) ? inside : outside) = middle;
  }
  return outside;
}

bool absorbs(const MaterialExtension& e) { return e.absorption_r != 0 || e.absorption_g != 0 || e.absorption_b != 0; }

bool bounds_solid(const PackedScene& packed, const Triangle& t) {
  return (packed.materials[t.material].flags & EK_MATERIAL_SOLID) != 0 && (t.flags & EK_TRIANGLE_ALPHA_TESTED) == 0;
}

struct Solid {
  double turned = 0;  // winding around the eye, steradians
  double way_out = std::numeric_limits<double>::infinity();
};

/// The highest ranks of solids that contain the eye, each as often as it winds around it, as
/// nested_media.h stores them.
std::uint32_t nested_media(const PackedScene& packed, const std::vector<Solid>& solids) {
  std::uint32_t media = 0;
  int free = EK_MEDIA_MOST;
  for (std::size_t rank = packed.material_extensions.size(); rank-- > 0;) {
    const std::uint32_t m = packed.material_extensions[rank].medium_of_rank;
    if (packed.material_extensions[m].medium_rank != rank + 1) continue;  // no solid has this rank
    for (double around = solids[m].turned; around > 2 * std::numbers::pi && free > 0; around -= 4 * std::numbers::pi)
      media |= std::uint32_t(rank + 1) << (8 * --free);
  }
  return media;
}

/// Adds up the solids around a point. A surface whose openings rays pass within the traversal
/// bounds none, because a path would not notice that it leaves the solid there (SolidOpenings).
class Surroundings {
 public:
  Surroundings(const PackedScene& packed, const glm::dvec3& eye, const glm::dvec3& view)
      : eye_(eye), view_(view), solids_(packed.materials.size()) {
    for (std::size_t i = 0; i < packed.shapes.size(); ++i) {
      const Triangle& t = packed.triangles[packed.triangle_count() + i];
      const std::uint32_t m = t.material;
      if (!bounds_solid(packed, t)) continue;
      const double out = way_out(packed.shapes[i], packed.formulas, eye, view);
      if (out > 0) add(m, 4 * std::numbers::pi, out);
    }
  }

  void add(std::uint32_t material, const std::array<glm::vec3, 3>& triangle) {
    const Corners corners = seen_from(eye_, triangle);
    add(material, solid_angle(corners), way_out(corners, view_));
  }

  [[nodiscard]] const std::vector<Solid>& solids() const { return solids_; }

  [[nodiscard]] std::uint32_t innermost() const {
    std::uint32_t innermost = 0;
    for (std::uint32_t m = 0; m < solids_.size(); ++m) {
      const bool inside = solids_[m].turned > 2 * std::numbers::pi;
      if (inside && (innermost == 0 || solids_[m].way_out < solids_[innermost - 1].way_out)) innermost = m + 1;
    }
    return innermost;
  }

 private:
  void add(std::uint32_t material, double turned, double out) {
    solids_[material].turned += turned;
    solids_[material].way_out = std::min(solids_[material].way_out, out);
  }

  glm::dvec3 eye_, view_;
  std::vector<Solid> solids_;  // by material
};

Surroundings surroundings(const PackedScene& packed, const glm::dvec3& eye, const glm::dvec3& view) {
  Surroundings around(packed, eye, view);
  for (std::size_t i = 0; i < packed.triangle_count(); ++i) {
    const Triangle& t = packed.triangles[i];
    if (bounds_solid(packed, t)) around.add(t.material, corners_of(t));
  }
  return around;
}

}  // namespace

std::uint32_t solid_around(const PackedScene& packed, const glm::dvec3& eye, const glm::dvec3& view) {
  return surroundings(packed, eye, view).innermost();
}

std::uint32_t solid_around(const Scene& scene, const PackedScene& light, const glm::dvec3& eye,
                           const glm::dvec3& view) {
  Surroundings around(light, eye, view);
  for (const Node& node : scene.nodes)
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives) {
      if ((light.materials[primitive.material].flags & EK_MATERIAL_SOLID) == 0) continue;
      for (std::size_t i = 0; i < primitive.indices.triangle_count(); ++i) {
        std::array<glm::vec3, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) {
          const glm::dvec4 p(primitive.positions_object[primitive.indices.triangle(i)[k]], 1.0);
          corners[k] = glm::vec3(glm::dvec3(node.world_from_object * p));
        }
        if (node.mirrored) std::swap(corners[1], corners[2]);
        around.add(primitive.material, corners);
      }
    }
  return around.innermost();
}

std::uint32_t camera_medium(const PackedScene& packed, const glm::dvec3& eye, const glm::dvec3& view) {
  const auto& extensions = packed.material_extensions;
  if (std::ranges::any_of(extensions, [](const MaterialExtension& e) { return e.medium_rank != 0; }))
    return nested_media(packed, surroundings(packed, eye, view).solids());
  return std::ranges::any_of(extensions, absorbs) ? solid_around(packed, eye, view) : 0;
}

}  // namespace eikon
