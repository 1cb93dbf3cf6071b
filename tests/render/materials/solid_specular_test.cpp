// SPDX-License-Identifier: Apache-2.0
// KHR_materials_specular on glass that refracts: how much it reflects changes, and where light goes
// does not. Judged at significance 1 % per test.
#include "render/lights/light_path_scenes.h"
#include "render/materials/glass_builder.h"

namespace eikon::test {
namespace {

Material colored_glass(float specular, glm::vec3 color) {
  Material m = glass(1.5F, 0, true);
  m.specular = specular;
  m.specular_color = color;
  return m;
}

TEST(SolidSpecular, a_slab_passes_what_its_two_faces_leave) {
  const Settings settings = settings_for_beam({0.1, 0.2, 4}, {0.1, 0.2, 0}, 4096);
  for (const auto& [specular, color] : {std::pair(1.0F, glm::vec3(1, 0, 5)), {0.5F, glm::vec3(10, 1, 40)}}) {
    Scene scene;
    add_lamp(scene);
    add_block(scene, "slab", {-20, -20, -0.5F}, {20, 20, 0.5F}, colored_glass(specular, color));
    EXPECT_TRUE(Features(scene, settings).has(Feature::solid_specular));
    const Film film = film_of(scene, settings);
    for (std::uint32_t c = 0; c < 3; ++c) {
      const double r = std::min(1.0, 0.04 * double(color[int(c)])) * double(specular);
      EXPECT_TRUE(agrees(mean_of(film, c), (1 - r) / (1 + r), 6)) << "specular " << specular << ", channel " << c;
    }
  }
}

TEST(SolidSpecular, only_solids_that_say_so_need_it) {
  Scene scene;
  add_lamp(scene);
  add_block(scene, "slab", {-20, -20, -0.5F}, {20, 20, 0.5F}, glass(1.5F, 0, true));
  Material pane = colored_glass(0.5F, {1, 0, 0});
  pane.solid = false;
  add_block(scene, "pane", {-20, -20, 1}, {20, 20, 1.5F}, pane);
  EXPECT_FALSE(Features(scene, settings_for(4, 4, 1)).has(Feature::solid_specular));
  scene.materials.back().solid = true;
  EXPECT_TRUE(Features(scene, settings_for(4, 4, 1)).has(Feature::solid_specular));
}

TEST(SolidSpecular, light_paths_bring_as_much_as_paths_from_the_camera) {
  auto [scene, settings] = room_of_glass(16, 4096);
  for (Material& m : scene.materials)
    if (m.transmission > 0) m.specular = 0.8F, m.specular_color = {20, 1, 0};
  const Film from_camera = film_of(scene, settings), both = film_of(scene, with_light_paths(settings, 1));
  for (std::uint32_t c = 0; c < 3; ++c)
    EXPECT_TRUE(agree(mean_of(both, c), mean_of(from_camera, c), 3)) << "channel " << c;
}

}  // namespace
}  // namespace eikon::test
