// SPDX-License-Identifier: Apache-2.0
// Finds the lights of a scene of which the geometry is packed, one after the other.
#pragma once
#include <functional>
#include <vector>

#include "pack/lights/emissive_texture.h"
#include "pack/lights/light_tree.h"
#include "pack/pack.h"
#include "pack/settings.h"

namespace eikon {

/// The value of Light.kind.
[[nodiscard]] constexpr std::uint32_t kind_word(LightKind kind) { return std::uint32_t(kind); }

/// The middle of a light that is a triangle or a parallelogram.
[[nodiscard]] glm::dvec3 middle_of(const Light& light);

/// The section of the sphere around a scene, which parallel light meets; 1 for a scene without
/// extent, because then any will do.
[[nodiscard]] double section_m2(const Bounds& bounds);

/// The factor for the power of distant lights where one light is chosen by power. Their flux enters
/// the whole scene, and most of it misses what is seen. So distant lights together count no more
/// than local lights do; otherwise a lamp under an open sky would hardly ever be chosen. local,
/// distant: sums of powers
[[nodiscard]] double scale_of_distant(double local, double distant);

/// Shares the probability of all lights that have a place among their entries by flux. Of lights in
/// a tree it depends on the shading point, and the summary says the share of the power.
void share_by_flux(double probability, std::vector<PackedLight>& summary);

struct FoundLight {
  Light light{};              // but for the probability
  double power = 0;           // selection is proportional to it
  double area_m2 = 0;         // of a surface
  std::uint32_t summary = 0;  // its entry of PackedScene::light_summary
  bool distant = false;       // infinitely far away
  LightMoments moments{};     // without the power; of a light that has a place
};

class LightFinder {
 public:
  /// packed  gets the summary, the poses of lights that move and the environment's map
  /// take    called for each light
  LightFinder(const Scene& scene, const Features& features, const Settings& settings, PackedScene& packed,
              std::function<void(const FoundLight&)> take);

  /// Finds lights among packed.triangles but for the shapes', and returns how many triangles it
  /// looked at. more_follow: the last triangle may belong together with one that follows, and is
  /// then left
  std::size_t find_triangles(bool more_follow);
  /// Finds shapes, lights without extent and the environment. To be called when the bounds are
  /// known. throws InputError for an environment that is too large or too bright
  void find_others();

 private:
  const Scene& scene_;
  const Environment& environment_;
  PackedScene& packed_;
  EmissiveTextures textures_;
  std::function<void(const FoundLight&)> take_;
  bool has_quads_, has_one_;
  std::vector<std::uint32_t> summary_of_;  // by material

  [[nodiscard]] bool find_quad(std::size_t i);
  void find_shapes();
  void find_punctual(std::size_t index);
  void find_environment();
  void take_distant(Light light, const PackedLight& summary);
  void take_surface(Light light, std::uint32_t material_index, double area, double radiance, LightMoments moments);
  [[nodiscard]] std::uint32_t summarise(const PackedLight& light);
};

}  // namespace eikon
