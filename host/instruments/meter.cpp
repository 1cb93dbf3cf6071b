// SPDX-License-Identifier: Apache-2.0
#include "instruments/meter.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "core/error.h"
#include "instruments/analytic_scenes.h"

namespace eikon {
namespace {

// Side of the receiver as a share of the scene's size. Irradiance over it differs from that at its middle by the square of the
// ratio of this to the distance of what lights it.
constexpr double kShareOfScene = 0x1p-14;
// And of its largest coordinate at least, so that rounding leaves its shape.
constexpr double kShareOfCoordinate = 0x1p-12;
// Above the surface that it may lie on, of its side.
constexpr double kLift = 0x1p-3;

double largest(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

double side_of_receiver(const Meter& meter, const Scene& scene) {
  const Bounds bounds = world_bounds(scene);
  const double size = bounds.empty() ? 0 : glm::length(bounds.hi - bounds.lo);
  const double side = std::max(kShareOfScene * size, kShareOfCoordinate * largest(meter.at));
  return side > 0 ? side : kShareOfScene;
}

/// A direction square to another.
glm::dvec3 across(const glm::dvec3& direction) {
  const glm::dvec3 axis = std::abs(direction.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(direction, axis));
}

/// Parallel rays from `eye` along `towards`, over a square of that side.
Camera parallel_camera(const glm::dvec3& eye, const glm::dvec3& towards, double side) {
  Camera camera = look_at_camera(eye, eye + towards, across(towards), 1);
  camera.name = "meter";
  camera.projection = Projection::orthographic;
  camera.ymag_m = 0.5 * side;
  return camera;
}

}  // namespace

void aim(const Meter& meter, Scene& scene, Settings& settings) {
  const double side = side_of_receiver(meter, scene);
  if (meter.quantity == Meter::Quantity::radiance) {
    settings.camera = parallel_camera(meter.at, meter.direction, kLift * side);
    return;
  }
  const glm::dvec3 &n = meter.direction, x = side * across(n), y = glm::cross(n, x);
  const glm::dvec3 corner = meter.at + kLift * side * n - 0.5 * (x + y);
  if (!(largest(corner) < 0x1p40))
    throw InputError(fmt::format("the meter at {:g}, {:g}, {:g} is beyond 2^40 m, the largest coordinate", meter.at.x,
                                 meter.at.y, meter.at.z));
  Primitive square;
  add_quad(square, glm::vec3(0), glm::vec3(x), glm::vec3(y));
  add_mesh(scene, "meter", std::move(square), lambert(1)).world_from_object[3] = glm::dvec4(corner, 1);
  // From close above its middle quarter: nothing else of the scene's is that small.
  settings.camera = parallel_camera(meter.at + 2 * kLift * side * n, -n, 0.5 * side);
  if (settings.max_depth > 0) ++settings.max_depth;  // the edge from the camera to the receiver is none of the light's
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
