// SPDX-License-Identifier: Apache-2.0
// Light paths by way of rough glass and rough metal: they share the light of lamps with paths that
// meet these, and with the light sampling of paths that meet glossy targets.
#include "render/lights/light_path_scenes.h"

namespace eikon::test {
namespace {

/// Makes glass and metal of a scene rough. roughness: of glass; metal has half of it
void roughen(Scene& scene, float roughness) {
  for (Material& m : scene.materials) {
    if (m.transmission > 0) m.roughness = roughness;
    if (m.metallic == 1 && m.roughness == 0) m.roughness = 0.5F * roughness;
  }
}

void leave_dark(Scene& scene) {
  for (Material& m : scene.materials) m.emission = glm::vec3(0);
}

PunctualLight spot_lamp() {
  PunctualLight light = small_lamp({-0.2, 0.9, 0.2}, 0.5F);
  light.kind = LightKind::spot;
  light.direction = glm::normalize(glm::dvec3(0.25, -1, -0.1));
  light.inner_cone_rad = 0.4, light.outer_cone_rad = 0.7;
  return light;
}

const Change kRooms[] = {
    {"lamp", [](Scene& scene, Settings&) { roughen(scene, 0.2F); }},
    {"lamp, less rough", [](Scene& scene, Settings&) { roughen(scene, 0.05F); }},
    {"two-sided lamp near a lens",
     [](Scene& scene, Settings& s) {
       roughen(scene, 0.2F);
       scene.materials[1].double_sided = true;
       s.camera.lens = Lens{.radius_m = 0.1, .focus_distance_m = 1.5};
     }},
    {"bulb",
     [](Scene& scene, Settings&) {
       leave_dark(scene);
       roughen(scene, 0.3F);
       scene.lights.push_back(small_lamp({-0.1, 0.8, 0.1}, 1));
     }},
    {"spot, and a lamp",
     [](Scene& scene, Settings&) {
       roughen(scene, 0.5F);
       scene.lights.push_back(spot_lamp());
     }},
    {"smooth glass beside rough metal, coats",
     [](Scene& scene, Settings&) {
       roughen(scene, 0.2F);
       for (Material& m : scene.materials) {
         if (m.transmission > 0) m.roughness = 0;
         if (m.metallic == 1) m.clearcoat = 0.5F;
       }
     }},
    {"coloured rough glass, a third of it painted, and dispersion",
     [](Scene& scene, Settings&) {
       roughen(scene, 0.2F);
       for (Material& m : scene.materials)
         if (m.transmission > 0) {
           m.transmission = 0.6F;
           m.dispersion = 5;
           m.attenuation_color = {0.5F, 0.8F, 0.9F};
           m.attenuation_distance = 0.5F;
         }
     }},
    {"a rough mirror that the camera sees",
     [](Scene& scene, Settings&) {
       roughen(scene, 0.1F);
       Material metal;
       metal.metallic = 1;
       metal.roughness = 0.15F;
       scene.materials[0] = metal;
     }},
};

TEST(GlossyTargets, bring_the_mean_that_paths_from_the_camera_find) {
  constexpr int comparisons = int(std::size(kRooms)) * 4 * 3;
  for (const Change& change : kRooms) {
    auto [scene, settings] = room_of_glass(24, 1536);
    change.make(scene, settings);
    EXPECT_FALSE(expect_the_same_mean(change.name, scene, settings, 3072, comparisons).light_paths().empty())
        << change.name;
  }
}

const Change kRoughSunny[] = {
    {"sun in a map", [](Scene& scene, Settings&) { roughen(scene, 0.2F); }},
    {"sun without extent",
     [](Scene& scene, Settings& s) {
       roughen(scene, 0.3F);
       s.environment.map = nullptr;
       s.environment.radiance = glm::vec3(0.1F);
       scene.lights.push_back(sunshine({0.4, -1, 0.3}, 2));
     }},
};

TEST(GlossyTargets, bring_the_light_of_suns) {
  constexpr int comparisons = int(std::size(kRoughSunny)) * 4 * 3;
  for (const Change& change : kRoughSunny) {
    auto [scene, settings] = floor_in_the_sun(24, 4096, 300);
    change.make(scene, settings);
    EXPECT_FALSE(expect_the_same_mean(change.name, scene, settings, 16384, comparisons).light_paths().empty())
        << change.name;
  }
}

TEST(GlossyTargets, bring_caustics_with_a_fraction_of_the_error) {
  for (const auto& [roughness, most] : {std::pair(0.05F, 0.3), std::pair(0.2F, 0.35), std::pair(0.5F, 0.65)}) {
    Scene scene = load_shipped("cornell_spheres.gltf");
    for (Material& m : scene.materials)
      if (m.transmission > 0 || m.metallic == 1) m.roughness = roughness;
    const auto [without, with] = errors_of(scene, settings_of(scene, 64, 64));
    EXPECT_LT(with, most * without) << "roughness " << roughness << ", " << without << " without";
  }
}

TEST(GlossyTargets, have_the_same_bits_by_every_way_of_tracing) {
  auto [scene, settings] = room_of_glass(20, 6);
  roughen(scene, 0.2F);
  scene.lights.push_back(spot_lamp());
  settings = with_light_paths(settings, 0.3);
  expect_the_same_bits_by_every_way(scene, settings, film_of(scene, settings));
}

TEST(GlossyTargets, leave_a_furnace_at_one) {
  Scene scene;
  Primitive walls;
  add_box(walls, glm::vec3(-1), glm::vec3(1), true);
  add_mesh(scene, "walls", std::move(walls), lambert(0.5F, 0.5F));
  add_mesh(scene, "ball", sphere({0.3F, -0.4F, 0}, 0.4F, 12, false, true), glass(1.5F, 0.2F, true));
  Settings settings = settings_for(16, 16, 512);
  settings.camera = look_at_camera({-0.5, 0.3, 0.9}, {0, -0.2, 0}, {0, 1, 0}, 1.2);
  settings.energy_compensation = true;
  // Without light paths it is darker by what a microfacet model loses, too, if nothing compensates
  // for it.
  EXPECT_TRUE(agree(mean_of(film_of(scene, with_light_paths(settings, 1))), mean_of(film_of(scene, settings)), 1));
}

}  // namespace
}  // namespace eikon::test
