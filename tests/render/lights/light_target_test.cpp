// SPDX-License-Identifier: Apache-2.0
// Light paths are aimed at some surfaces, and start in no other directions. Light that surfaces
// beside these reflect or refract exactly comes by paths from the camera alone, which must not
// leave a share of it to light paths.
#include "render/lights/light_path_scenes.h"
#include "scene/endless.h"

namespace eikon::test {
namespace {

Material smooth_plastic(float ior) {
  Material m = lambert(0.2F);
  m.lobe.reset();
  m.metallic = 0;
  m.roughness = 0;
  m.ior = ior;
  m.specular = 1;
  return m;
}

Material metal(float roughness) {
  Material m;
  m.metallic = 1;
  m.roughness = roughness;
  m.base_color = glm::vec3(0.9F);
  return m;
}

/// A small glass ball in a corner, at which light paths are aimed.
void add_glass_ball(Scene& scene) {
  add_mesh(scene, "ball", sphere({0.75F, -0.8F, 0.4F}, 0.15F, 6, false, true), glass(1.5F, 0, true));
}

/// A back wall in a closed room with a lamp, and the ball.
void add_wall_and_ball(Scene& scene, const Material& wall) {
  Primitive quad;
  add_quad(quad, {-0.98F, -0.98F, -0.98F}, {1.96F, 0, 0}, {0, 1.9F, 0});
  quad.uv[0].assign(quad.positions_object.size(), glm::vec2(0.5F));
  add_mesh(scene, "wall", std::move(quad), wall);
  add_glass_ball(scene);
}

/// The same with a plane without end as the wall.
void add_endless_wall_and_ball(Scene& scene, const Material& wall) {
  scene.materials.push_back(wall);
  Shape& plane = scene.shapes.emplace_back();
  plane.name = "plane";
  plane.kind = ShapeKind::plane;
  plane.size = {kEndlessSize, kEndlessSize, 0};
  plane.world_from_object = glm::rotate(glm::translate(glm::dmat4(1), {0, 0, -0.98}), 0.5 * kPi, glm::dvec3(1, 0, 0));
  plane.material = std::uint32_t(scene.materials.size() - 1);
  add_glass_ball(scene);
}

const Change kWalls[] = {
    {"a mirror, which is a target", [](Scene& scene, Settings&) { add_wall_and_ball(scene, metal(0)); }},
    {"smooth plastic", [](Scene& scene, Settings&) { add_wall_and_ball(scene, smooth_plastic(3)); }},
    {"metal that its texture makes smooth",
     [](Scene& scene, Settings&) {
       scene.images.push_back({"smooth", 1, 1, {0xffff00ff}});
       Material m = metal(1);
       m.metallic_roughness_texture = Texture{.image = std::uint32_t(scene.images.size() - 1)};
       add_wall_and_ball(scene, m);
     }},
    {"smooth leaves that let light through",
     [](Scene& scene, Settings&) {
       Material m = smooth_plastic(3);
       m.diffuse_transmission = 0.5F;
       m.diffuse_transmission_color = glm::vec3(0.6F);
       add_wall_and_ball(scene, m);
     }},
    {"a mirror without end", [](Scene& scene, Settings&) { add_endless_wall_and_ball(scene, metal(0)); }},
    {"rough metal without end", [](Scene& scene, Settings&) { add_endless_wall_and_ball(scene, metal(0.2F)); }},
};

TEST(LightTargets, leave_what_other_surfaces_reflect_to_camera_paths) {
  constexpr int comparisons = int(std::size(kWalls)) * 4 * 3;
  for (const Change& change : kWalls) {
    Scene scene = closed_room_with_lamp();
    Settings settings = seen_from_above(24, 1024);
    change.make(scene, settings);
    EXPECT_FALSE(expect_the_same_mean(change.name, scene, settings, 2048, comparisons).light_paths().empty())
        << change.name;
  }
}

TEST(LightTargets, that_are_painted_in_part_let_light_through_whole) {
  // A shading normal that leans towards the sun hides the terminator of what the paint reflects,
  // and of nothing that passes.
  constexpr float passes = 0.4F, albedo = 0.5F, irradiance = 2;
  constexpr double angle = 1.3;
  Scene scene;
  Primitive floor, pane;
  add_quad(floor, {-2, 0, 2}, {4, 0, 0}, {0, 0, -4});
  add_quad(pane, {-2, 1, 2}, {8, 0, 0}, {0, 0, -4});
  pane.normals_object.assign(pane.positions_object.size(), glm::normalize(glm::vec3(1, 1, 0)));
  Material painted = glass(1, 0, false);  // without Fresnel's reflection
  painted.transmission = passes;
  add_mesh(scene, "floor", std::move(floor), lambert(albedo));
  add_mesh(scene, "pane", std::move(pane), painted);
  scene.lights.push_back(sunshine({-std::sin(angle), -std::cos(angle), 0}, irradiance));
  Settings settings = with_light_paths(settings_for(8, 8, 4096), 4);
  settings.camera = look_at_camera({0, 0.8, 0}, {0, 0, 0}, {0, 0, 1}, 0.8);
  settings.max_depth = 3;
  const MeanAndError mean = mean_of(film_of(scene, settings));
  const double expected = double(albedo * irradiance * passes) * std::cos(angle) / kPi;
  EXPECT_NEAR(mean.mean, expected, 4 * mean.sigma);
  EXPECT_LT(mean.sigma, 0.02 * expected);
}

TEST(LightTargets, leave_light_of_normals_that_face_away_to_camera_paths) {
  // A lamp shines at a mirror, and by way of that at a floor, whose shading normals face away from
  // the wall that the camera sees.
  Scene scene;
  Primitive floor, wall, mirror, lamp;
  add_quad(floor, {-1, -1, 1}, {2, 0, 0}, {0, 0, -2});
  floor.normals_object.assign(floor.positions_object.size(), glm::normalize(glm::vec3(1, 1, 0)));
  add_quad(wall, {-1, -1, -1}, {0, 2, 0}, {0, 0, 2});
  add_quad(mirror, {0.95F, -1, -1}, {0, 0, 2}, {0, 2, 0});
  add_quad(lamp, {0.6F, -0.5F, -0.6F}, {0, 1.2F, 0}, {0, 0, 1.2F});
  add_mesh(scene, "floor", std::move(floor), lambert(0.8F));
  add_mesh(scene, "wall", std::move(wall), lambert(0.8F));
  add_mesh(scene, "mirror", std::move(mirror), metal(0));
  add_mesh(scene, "lamp", std::move(lamp), lambert(0, 10));
  Settings settings = settings_for(24, 24, 8192);
  settings.camera = look_at_camera({0.2, -0.5, 0}, {-1, -0.7, 0}, {0, 1, 0}, 0.5);
  EXPECT_FALSE(expect_the_same_mean("floor", scene, settings, 8192, 12).light_paths().empty());
}

TEST(LightTargets, leave_what_plastic_reflects_of_a_sun_to_camera_paths) {
  auto [scene, settings] = floor_in_the_sun(24, 2048, 300);
  scene.materials[0] = smooth_plastic(3);
  Primitive wall;
  add_quad(wall, {-1.2F, -1, 3}, {0, 0, -6}, {0, 3, 0});  // across from the sun
  add_mesh(scene, "wall", std::move(wall), lambert(0.7F));
  EXPECT_FALSE(expect_the_same_mean("plastic in the sun", scene, settings, 8192, 12).light_paths().empty());
}

TEST(LightTargets, leave_what_other_surfaces_reflect_out_of_photons) {
  Scene scene = closed_room_with_lamp();
  add_wall_and_ball(scene, smooth_plastic(3));
  Primitive pane;
  add_quad(pane, {-0.98F, -0.98F, 1.3F}, {1.96F, 0, 0}, {0, 1.9F, 0});
  add_mesh(scene, "pane", std::move(pane), glass(1.5F, 0, false));
  Settings settings = with_light_paths(seen_from_above(16, 1024), 1);
  settings.max_depth = 8;
  const MeanAndError unbiased = mean_of(film_of(scene, settings));
  settings.merges_caustics = true;
  settings.seed = 5;
  const MeanAndError merged = mean_of(film_of(scene, settings));
  // The light that plastic reflects is 6 % of the picture. The bias of merging is smaller than a
  // sixth of that.
  EXPECT_NEAR(merged.mean, unbiased.mean, 0.01 * unbiased.mean);
}

}  // namespace
}  // namespace eikon::test
