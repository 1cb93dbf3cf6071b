// SPDX-License-Identifier: Apache-2.0
#include "instruments/meter.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "core/error.h"
#include "instruments/analytic_scenes.h"
#include "pack/origin.h"
#include "pack/pack_parts.h"
#include "scene/endless.h"
#include "scene/shape.h"
#include "scene/transform.h"

namespace eikon {
namespace {

// The mean irradiance over the receiver differs from that at its middle by the square of the ratio
// of its side to the distance of the light, so its side is as small as single precision allows.

// Least side as a share of the largest triangle or shape around the meter: rays meet that with an
// error in proportion to its size, and the receiver may lie on it.
constexpr double kShareOfSurface = 0x1p-18;
// Least side as a share of its largest coordinate from the origin that the scene is packed around,
// so that rounding keeps its shape.
constexpr double kShareOfCoordinate = 0x1p-12;
// Least side as a share of the scene's size, so that there is one anywhere.
constexpr double kShareOfScene = 0x1p-30;
constexpr double kSideInEmptyScene_m = 0x1p-14;
// Height above a surface on which it may lie, as a share of its side.
constexpr double kLift = 0x1p-3;
// Side of the middle part of the receiver that is seen, as a share of its side.
constexpr double kSeenSide = 0x1p-1;

double largest(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

/// What the side of a receiver depends on.
struct Neighbourhood {
  double extent = 0;  // of the largest triangle or shape whose box holds the meter; 0 if there is none
  Bounds scene;
};

Neighbourhood neighbourhood(const Scene& scene, const glm::dvec3& at) {
  Neighbourhood found;
  const auto holds_meter = [&](const Bounds& box) {
    return largest(at - glm::clamp(at, box.lo, box.hi)) <= kShareOfSurface * largest(box.hi - box.lo);
  };
  const auto look = [&](const Bounds& box) {
    if (holds_meter(box)) found.extent = std::max(found.extent, largest(box.hi - box.lo));
  };
  const std::vector<Bounds> boxes = boxes_of_nodes(scene);
  for (std::size_t n = 0; n < boxes.size(); ++n) {
    const Node& node = scene.nodes[n];
    if (boxes[n].empty()) continue;
    grow(found.scene, boxes[n].lo), grow(found.scene, boxes[n].hi);
    if (!holds_meter(boxes[n])) continue;
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives)
      for (std::size_t i = 0; i < primitive.indices.triangle_count(); ++i) {
        Bounds box;
        for (const std::uint32_t corner : primitive.indices.triangle(i))
          grow(box, transform_point(node.world_from_object, primitive.positions_object[corner]));
        look(box);
      }
  }
  for (const Shape& shape : scene.shapes) {
    const OwnShape own = own_shape(bounded_piece(shape));
    const Bounds box{own.center - own.half, own.center + own.half};
    grow(found.scene, box.lo), grow(found.scene, box.hi);
    look(box);
  }
  return found;
}

double side_of_receiver(const Meter& meter, const Scene& scene) {
  const auto [extent, bounds] = neighbourhood(scene, meter.at);
  const double size = bounds.empty() ? 0 : glm::length(bounds.hi - bounds.lo);
  // A meter of radiance adds nothing to the scene.
  const bool is_added = meter.quantity == Meter::Quantity::irradiance;
  const glm::dvec3 origin = origin_of(scene, {&meter.at, is_added ? std::size_t{1} : 0});
  const double side =
      std::max({kShareOfSurface * extent, kShareOfScene * size, kShareOfCoordinate * largest(meter.at - origin)});
  return side > 0 ? side : kSideInEmptyScene_m;
}

/// Returns a direction perpendicular to another.
glm::dvec3 across(const glm::dvec3& direction) {
  const glm::dvec3 axis = std::abs(direction.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(direction, axis));
}

/// A camera of parallel rays from `eye` along `towards`, over a square of this side.
Camera parallel_camera(const glm::dvec3& eye, const glm::dvec3& towards, double side) {
  Camera camera = look_at_camera(eye, eye + towards, across(towards), 1);
  camera.name = "meter";
  camera.projection = Projection::orthographic;
  camera.ymag_m = 0.5 * side;
  return camera;
}

}  // namespace

double aim(const Meter& meter, Scene& scene, Settings& settings) {
  settings.culling = Culling::none;  // light arrives from both sides of every surface
  settings.light_path_count = 0;     // hardly any would meet so small a receiver, and each would outshine all others
  const double side = side_of_receiver(meter, scene);
  if (meter.quantity == Meter::Quantity::radiance) {
    settings.camera = parallel_camera(meter.at, meter.direction, kLift * side);
    return kLift * side;
  }
  const glm::dvec3 &n = meter.direction, x = side * across(n), y = glm::cross(n, x);
  const glm::dvec3 corner = meter.at + kLift * side * n - 0.5 * (x + y);
  if (!(largest(corner) < 0x1p40))
    throw InputError(fmt::format("the meter at {:g}, {:g}, {:g} is beyond 2^40 m, the largest coordinate", meter.at.x,
                                 meter.at.y, meter.at.z));
  Primitive square;
  add_quad(square, glm::vec3(0), glm::vec3(x), glm::vec3(y));
  add_mesh(scene, "meter", std::move(square), lambert(1)).world_from_object[3] = glm::dvec4(corner, 1);
  // The camera is close above the middle quarter of the receiver: nothing else in the scene is so
  // small.
  settings.camera = parallel_camera(meter.at + 2 * kLift * side * n, -n, kSeenSide * side);
  // The edge from the camera to the receiver does not belong to the light's path.
  if (settings.max_depth > 0) ++settings.max_depth;
  return kSeenSide * side;
}

Reading read(const Meter& meter, const Film& film) {
  Reading reading;
  const double scale = meter.quantity == Meter::Quantity::irradiance ? std::numbers::pi : 1;
  for (int c = 0; c < 3; ++c) {
    const MeanAndError channel = mean_between_pixels(film, std::uint32_t(c));
    reading.value[c] = scale * channel.mean;
    reading.sigma[c] = scale * channel.sigma;
  }
  return reading;
}

}  // namespace eikon
