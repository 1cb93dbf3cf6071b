// SPDX-License-Identifier: Apache-2.0
// Small scenes with known answers, and functions that judge their films, for `eikon selftest` and
// tests.
#pragma once
#include <string>

#include "film/film.h"
#include "pack/settings.h"

namespace eikon {

/// Adds the corners p, p + a, p + a + b, p + b as two triangles; the front faces along a x b.
void add_quad(Primitive& primitive, glm::vec3 p, glm::vec3 a, glm::vec3 b);
/// Adds the six faces of an axis-parallel box, with their fronts outside or inside.
void add_box(Primitive& primitive, glm::vec3 lo, glm::vec3 hi, bool inwards);
/// Adds a mesh of one primitive, its material and a node without a transform, all of that name.
/// returns  the node, valid until the next one is added
Node& add_mesh(Scene& scene, const std::string& name, Primitive primitive, const Material& material);

/// An exactly Lambertian material; emission in W / (sr m^2), on the front.
Material lambert(glm::vec3 albedo, glm::vec3 emission = glm::vec3(0));
inline Material lambert(float albedo, float emission = 0) { return lambert(glm::vec3(albedo), glm::vec3(emission)); }

/// A closed cube of side 2 around the origin, fronts inside. Every point has the radiance
/// emission / (1 - albedo).
Scene furnace(float albedo, float emission);
/// A white floor at y = 0 under a black unit square at height 1 that emits 1 downwards. Below its
/// middle E / L = 0.752274688.
Scene square_light();
inline constexpr double kSquareLightIrradiance = 0.752274688;

/// Settings for the whole image and samples [0, spp).
Settings settings_for(std::uint32_t width, std::uint32_t height, std::uint64_t spp);

struct MeanAndError {
  double mean = 0, sigma = 0;
};
/// The mean of a channel over the film's pixels, and its standard deviation from the spread between
/// pixels, which is right if all pixels have the same expectation, else too large.
MeanAndError mean_between_pixels(const Film& film, std::uint32_t channel);

/// All sums and counts of the two films, also of mattes, are the same integers.
bool same_bits(const Film& a, const Film& b);

}  // namespace eikon
