// SPDX-License-Identifier: Apache-2.0
// How much of its material's emission a triangle gives off where a texture says so, for choosing among lights.
#pragma once
#include <map>
#include <span>

#include "pack/pack.h"

namespace eikon {

/// Answers for the triangles of one packed scene; remembers what it found out about images.
class EmissiveTextures {
 public:
  explicit EmissiveTextures(const PackedScene& packed) : packed_(packed) {}

  /// Mean over triangle `index` of its material's emission, mean of R, G and B, W / (sr m^2): an estimate from points spread
  /// over it, but 0 if and only if no texel that a lookup on it can touch emits. So no place that is lit is never sampled.
  [[nodiscard]] double mean_emission(std::uint32_t index);
  /// The same for a shape's record, as if it showed all of the texture alike.
  [[nodiscard]] double mean_emission_of_whole_texture(std::uint32_t index);

 private:
  /// How many texels of an image, of those above and left of each, are lit in some of the channels of a mask.
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
