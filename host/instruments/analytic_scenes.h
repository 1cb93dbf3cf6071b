// SPDX-License-Identifier: Apache-2.0
// Small scenes with known answers, made in code, and how their films are judged: for `eikon selftest` and the tests.
#pragma once
#include <string>

#include "film/film.h"
#include "pack/settings.h"

namespace eikon {

/// Adds the corners p, p + a, p + a + b, p + b as two triangles; the front is where they turn anticlockwise: along a x b.
void add_quad(Primitive& primitive, glm::vec3 p, glm::vec3 a, glm::vec3 b);
/// Adds the six faces of an axis-parallel box, fronts outside or inside.
void add_box(Primitive& primitive, glm::vec3 lo, glm::vec3 hi, bool inwards);
/// Adds a mesh of one primitive, its material and a node without a transform, all of that name. returns the node, until the next is added
Node& add_mesh(Scene& scene, const std::string& name, Primitive primitive, const Material& material);

/// Exactly Lambert; emission in W / (sr m^2), on the front.
Material lambert(glm::vec3 albedo, glm::vec3 emission = glm::vec3(0));
inline Material lambert(float albedo, float emission = 0) { return lambert(glm::vec3(albedo), glm::vec3(emission)); }

/// Closed cube of side 2 around the origin, fronts inside; every point has radiance emission / (1 - albedo).
Scene furnace(float albedo, float emission);
/// White floor y = 0 under a black unit square at height 1 that emits 1 downwards: E / L = 0.752274688 below its middle.
Scene square_light();
inline constexpr double kSquareLightIrradiance = 0.752274688;

/// The whole image, samples [0, spp).
Settings settings_for(std::uint32_t width, std::uint32_t height, std::uint64_t spp);

struct MeanAndError {
  double mean = 0, sigma = 0;
};
/// Mean of a channel over the film's pixels, and its standard deviation as the spread between pixels tells it: right where
/// every pixel expects the same, too large elsewhere.
MeanAndError mean_between_pixels(const Film& film, std::uint32_t channel);

/// Every sum and every count, of mattes too, is the same integer.
bool same_bits(const Film& a, const Film& b);

}  // namespace eikon
