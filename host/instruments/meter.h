// SPDX-License-Identifier: Apache-2.0
// A light meter: radiometry at a point of a scene, by rendering a picture that is the measurement.
#pragma once
#include <glm/glm.hpp>

#include "film/film.h"
#include "pack/settings.h"

namespace eikon {

struct Meter {
  enum class Quantity {
    irradiance,  // what falls on a small flat receiver at `at` whose normal is `direction`; W / m^2
    radiance,    // what comes to `at` from `direction`; W / (sr m^2)
  };
  Quantity quantity = Quantity::irradiance;
  glm::dvec3 at{0.0};         // world, metres
  glm::dvec3 direction{0.0};  // unit
};

/// Means over the measurement's paths and their standard errors, R, G, B.
struct Reading {
  glm::dvec3 value{0.0}, sigma{0.0};
};

/// Sets the camera so that a film of `settings` measures: each of its pixels on its own, which tells how uncertain the mean is. For
/// irradiance a receiver is put into the scene, white, exactly Lambert, and so small that it changes nothing else; as it is seen
/// from above, its radiance times pi is the irradiance.
/// throws InputError for a receiver that coordinates of single precision cannot hold there
void aim(const Meter& meter, Scene& scene, Settings& settings);

/// Of the film that the scene gives then.
[[nodiscard]] Reading read(const Meter& meter, const Film& film);

}  // namespace eikon
