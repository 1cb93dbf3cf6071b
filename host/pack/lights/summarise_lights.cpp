// SPDX-License-Identifier: Apache-2.0
#include "core/error.h"
#include "pack/lights/find_lights.h"
#include "pack/lights/light_table.h"
#include "pack/pack_parts.h"

namespace eikon {
namespace {

/// A light that has no place, as the summary needs it.
struct DistantLight {
  double power = 0;
  std::uint32_t summary = 0;
};

/// Takes away the first triangles, with the data of their corners.
void drop_triangles(PackedScene& packed, std::size_t count) {
  const auto drop = [count](auto& records) {
    if (!records.empty()) records.erase(records.begin(), records.begin() + std::ptrdiff_t(count));
  };
  drop(packed.triangles);
  drop(packed.normals);
  drop(packed.tangents);
  drop(packed.colors);
}

/// The bytes that pack_lights would need for so many lights, but for an environment's map.
std::uint64_t light_bytes(const Features& features, std::uint64_t placed, std::uint64_t distant) {
  const std::uint64_t all = placed + distant;
  const bool has_tree = features.has(Feature::light_tree) && placed > 0;
  return all * sizeof(Light) + (has_tree ? (placed - 1) * sizeof(LightNode) : 0) +
         (has_tree ? distant + 1 : all) * sizeof(AliasEntry) +
         (features.has(Feature::light_paths) ? all * (sizeof(AliasEntry) + sizeof(float)) : 0);
}

}  // namespace

std::uint64_t summarise_lights(const Scene& scene, const Features& features, const Settings& settings,
                               PackedScene& packed) {
  std::uint64_t placed = 0;
  double local = 0, parallel = 0;
  std::vector<DistantLight> distant;
  LightFinder finder(scene, features, settings, packed, [&](const FoundLight& found) {
    (found.distant ? parallel : local) += found.power;
    if (found.distant)
      distant.push_back({found.power, found.summary});
    else
      ++placed;
  });
  pack_emitters(scene, features, packed, [&] { drop_triangles(packed, finder.find_triangles(true)); });
  drop_triangles(packed, finder.find_triangles(false));
  pack_shapes(scene, features, packed);
  finder.find_others();
  if (placed == 0 && distant.empty()) return 0;
  std::vector<double> powers{local};  // the lights that have a place together, then the others
  for (const DistantLight& light : distant) powers.push_back(light.power * scale_of_distant(local, parallel));
  const LightTable table = build_light_table(powers);
  if (table.buckets.empty()) throw InternalError("lights without power");
  if (placed > 0) share_by_flux(table.probability[0], packed.light_summary);
  for (std::size_t i = 0; i < distant.size(); ++i)
    packed.light_summary[distant[i].summary].probability = table.probability[i + 1];
  return light_bytes(features, placed, distant.size());
}

}  // namespace eikon
