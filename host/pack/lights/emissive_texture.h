// SPDX-License-Identifier: Apache-2.0
// The mean emission of textured triangles, by which light sampling chooses among them.
#pragma once
#include <map>
#include <span>

#include "pack/pack.h"

namespace eikon {

/// Finds the emission of triangles of one packed scene, and caches sums over its images.
class EmissiveTextures {
 public:
  explicit EmissiveTextures(const PackedScene& packed) : packed_(packed) {}

  /// Mean over triangle `index` and over R, G and B of its material's emission, W / (sr m^2). It is
  /// an estimate from points spread over the triangle, but 0 if and only if no texel that a lookup
  /// can touch emits, so that every lit place is sampled.
  [[nodiscard]] double mean_emission(std::uint32_t index);
  /// The same for a shape's record, as if it showed every part of the texture equally.
  [[nodiscard]] double mean_emission_of_whole_texture(std::uint32_t index);

 private:
  /// Summed-area table of an image: for each texel, how many above and left of it are lit in a
  /// channel of the mask.
  struct LitTexels {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint32_t> sums;
  };
  struct Place {
    double x = 0, y = 0;  // in texels, before wrapping
  };

  [[nodiscard]] Place corner_place(std::uint32_t index, const TextureRecord& texture, int corner) const;
  [[nodiscard]] static Place place_of(const TextureRecord& texture, double u, double v);
  [[nodiscard]] double mean_between(const MaterialRecord& material, const Place (&corners)[3]);
  [[nodiscard]] std::span<const std::uint32_t> texels_of(const TextureRecord& texture) const;
  [[nodiscard]] const LitTexels& lit_texels(const TextureRecord& texture, std::uint32_t channels);
  [[nodiscard]] bool may_emit(const TextureRecord& texture, std::uint32_t channels, const Place (&corners)[3]);
  [[nodiscard]] glm::dvec3 lookup(const TextureRecord& texture, Place place) const;

  const PackedScene& packed_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, LitTexels> lit_;  // by first texel and mask
};

}  // namespace eikon
