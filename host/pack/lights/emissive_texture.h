// SPDX-License-Identifier: Apache-2.0
// The mean emission of triangles with textures or with openings, by which light sampling chooses
// among them.
#pragma once
#include <array>
#include <glm/glm.hpp>
#include <map>
#include <span>

#include "pack/pack.h"

namespace eikon {

/// Finds the emission of triangles of one packed scene, and caches sums over its images.
class EmissiveTextures {
 public:
  explicit EmissiveTextures(const PackedScene& packed) : packed_(packed) {}

  /// Mean over triangle `index` and over R, G and B of its material's emission times its opacity, W
  /// / (sr m^2). It is an estimate from points spread over the triangle, but 0 if and only if no
  /// texel that a lookup can touch emits, so that every lit place is sampled.
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

  using Corners = std::array<Place, 3>;
  /// The corners of a triangle of the surface, in the textures that decide about its emission.
  struct Part {
    const TextureRecord *emission = nullptr, *opacity = nullptr;  // null: there is none
    Corners emission_at{}, opacity_at{};
    glm::dvec3 alpha{1.0};     // of their colours
    bool is_passable = false;  // its opacity is below 1 somewhere
  };

  [[nodiscard]] Part part_of(const Triangle& triangle, const MaterialRecord& material) const;
  [[nodiscard]] static Place between(const Corners& corners, const glm::dvec3& weights);
  [[nodiscard]] Place corner_place(std::uint32_t index, const TextureRecord& texture, int corner) const;
  [[nodiscard]] static Place place_of(const TextureRecord& texture, double u, double v);
  [[nodiscard]] double mean_over(const MaterialRecord& material, const Part& part);
  [[nodiscard]] double opacity_of(const MaterialRecord& material, const Part& part, const glm::dvec3& weights) const;
  [[nodiscard]] std::span<const std::uint32_t> texels_of(const TextureRecord& texture) const;
  [[nodiscard]] const LitTexels& lit_texels(const TextureRecord& texture, std::uint32_t channels);
  [[nodiscard]] bool may_emit(const TextureRecord& texture, std::uint32_t channels, const Corners& corners);
  [[nodiscard]] glm::dvec4 lookup(const TextureRecord& texture, Place place) const;

  const PackedScene& packed_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, LitTexels> lit_;  // by first texel and mask
};

}  // namespace eikon
