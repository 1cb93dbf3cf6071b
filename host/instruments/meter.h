// SPDX-License-Identifier: Apache-2.0
// A light meter. It measures at a point of a scene by rendering a picture, which is the
// measurement.
#pragma once
#include <glm/glm.hpp>

#include "film/film.h"
#include "pack/settings.h"

namespace eikon {

struct Meter {
  enum class Quantity {
    irradiance,  // on a small flat receiver at `at` with normal `direction`; W / m^2
    radiance,    // that arrives at `at` from `direction`; W / (sr m^2)
  };
  Quantity quantity = Quantity::irradiance;
  glm::dvec3 at{0.0};         // world, metres
  glm::dvec3 direction{0.0};  // unit
};

/// R, G, B: means over the paths of the measurement, and their standard errors.
struct Reading {
  glm::dvec3 value{0.0}, sigma{0.0};
};

/// Sets the camera such that each pixel of a film of `settings` is one measurement; their spread
/// gives the uncertainty of the mean. For irradiance it adds a receiver to the scene: white,
/// exactly Lambertian, and as small as single precision allows there. Seen from above, its radiance
/// times pi is the irradiance. Returns the side of the square over which the reading is a mean,
/// metres: of the part of the receiver that is seen, or of the bundle of parallel rays.
/// throws InputError when single precision cannot represent the receiver there
double aim(const Meter& meter, Scene& scene, Settings& settings);

/// Computes the reading from the film that was rendered then.
[[nodiscard]] Reading read(const Meter& meter, const Film& film);

}  // namespace eikon
