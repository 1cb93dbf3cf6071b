// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "core/error.h"
#include "render/light_table.h"
#include "render/pack_parts.h"

namespace eikon {
namespace {

// Values of Light.kind.
enum : std::uint32_t {
#define EK_LIGHT(name, bit) kLight_##name = bit,
#include "shared/features.def"
};

double mean(const glm::vec3& colour) { return (double(colour.x) + double(colour.y) + double(colour.z)) / 3.0; }

// Light sampling derives a light's normal in floats. A needle for which that fails is not sampled: light_pdf_m2 stays 0, and
// what scattered rays find of it counts in full.
bool can_be_sampled(const Triangle& t, const glm::dvec3& normal) {
  const glm::vec3 p0(t.p0_x, t.p0_y, t.p0_z);
  const glm::dvec3 rounded(glm::cross(glm::vec3(t.p1_x, t.p1_y, t.p1_z) - p0, glm::vec3(t.p2_x, t.p2_y, t.p2_z) - p0));
  return glm::length(glm::normalize(rounded) - glm::normalize(normal)) < 0x1p-14;  // false for NaN
}

}  // namespace

void pack_lights(const Scene& scene, const Settings& settings, PackedScene& packed) {
  std::vector<double> powers;
  std::vector<double> areas;
  std::vector<double> by_material(scene.materials.size(), 0.0);
  std::vector<std::uint32_t> material_of_light;
  for (std::size_t i = 0; i < packed.triangles.size(); ++i) {
    const Triangle& t = packed.triangles[i];
    const Material& material = scene.materials[t.material];
    const double radiance = mean(material.emission);
    if (!(radiance > 0)) continue;
    const glm::dvec3 normal = triangle_normal(t);
    const double area = 0.5 * glm::length(normal);
    if (!(area > 0) || !can_be_sampled(t, normal)) continue;
    Light light{};
    light.p0_x = t.p0_x, light.p0_y = t.p0_y, light.p0_z = t.p0_z;
    light.p1_x = t.p1_x, light.p1_y = t.p1_y, light.p1_z = t.p1_z;
    light.p2_x = t.p2_x, light.p2_y = t.p2_y, light.p2_z = t.p2_z;
    light.emission_r = material.emission.x, light.emission_g = material.emission.y,
    light.emission_b = material.emission.z;
    light.double_sided = material.double_sided ? 1 : 0;
    light.kind = kLight_area;
    light.triangle = std::uint32_t(i);
    packed.lights.push_back(light);
    areas.push_back(area);
    powers.push_back(std::numbers::pi * area * radiance * (material.double_sided ? 2 : 1));
    by_material[t.material] += powers.back();
    material_of_light.push_back(t.material);
  }
  const double sky = mean(settings.environment.radiance);
  if (sky > 0) {
    // What enters the sphere around the scene; a scene without extent is lit by the environment alone.
    const double radius = packed.bounds.empty() ? 0 : 0.5 * glm::length(packed.bounds.hi - packed.bounds.lo);
    Light light{};
    light.kind = kLight_environment;
    packed.lights.push_back(light);
    areas.push_back(0);
    powers.push_back(radius > 0 ? 4 * std::numbers::pi * std::numbers::pi * radius * radius * sky : sky);
  }
  if (packed.lights.empty()) return;
  const LightTable table = build_light_table(powers);
  if (table.buckets.empty()) throw InternalError("lights without power");
  packed.light_buckets = table.buckets;
  std::vector<double> probability(scene.materials.size(), 0.0);
  for (std::size_t i = 0; i < packed.lights.size(); ++i) {
    Light& light = packed.lights[i];
    if (light.kind == kLight_environment) {
      packed.environment_probability = float(table.probability[i]);
      packed.light_summary.push_back({"environment", powers[i], table.probability[i]});
      continue;
    }
    light.pdf_m2 = float(table.probability[i] / areas[i]);
    packed.triangles[light.triangle].light_pdf_m2 = light.pdf_m2;
    probability[material_of_light[i]] += table.probability[i];
  }
  for (std::size_t m = 0; m < by_material.size(); ++m)
    if (by_material[m] > 0)
      packed.light_summary.push_back(
          {fmt::format("material '{}'", scene.materials[m].name), by_material[m], probability[m]});
}

}  // namespace eikon
