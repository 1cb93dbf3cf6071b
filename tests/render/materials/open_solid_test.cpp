// SPDX-License-Identifier: Apache-2.0
// Solids that rays may pass by alphaMode MASK or BLEND: behind such an opening a path is inside of
// the solid, as behind the glass beside it. Judged at significance 1 % per test.
#include "pack/geometry/solid_openings.h"

#include "pack/lights/pack_light_paths.h"
#include "render/lights/light_path_scenes.h"

namespace eikon::test {
namespace {

Material open_glass(Material m, float opacity) {
  m.alpha_mode = AlphaMode::blend;
  m.opacity = opacity;
  return m;
}

/// Black walls of radiance 1 around a ball.
Scene ball_within_walls(const Material& material, bool is_shape) {
  Scene scene = furnace(0, 1);
  if (!is_shape) {
    add_mesh(scene, "ball", sphere({0, 0, 0}, 0.5F, 12, false), material);
    return scene;
  }
  Shape shape;
  shape.name = "ball";
  shape.kind = ShapeKind::sphere;
  shape.size[0] = 0.5;
  shape.material = std::uint32_t(scene.materials.size());
  scene.materials.push_back(material);
  scene.shapes.push_back(shape);
  return scene;
}

Settings seen_from(const glm::dvec3& eye) {
  Settings settings = settings_for(12, 12, 32);
  settings.camera = look_at_camera(eye, eye - glm::dvec3(0.01, 0.02, 1), {0, 1, 0}, 0.9);
  settings.roulette_depth = 1000;  // total reflection keeps paths for long; roulette would make them heavy
  return settings;
}

TEST(OpenSolid, neither_makes_nor_loses_light_among_surfaces) {
  for (const bool is_shape : {false, true})
    for (const bool has_priority : {false, true})
      for (const float opacity : {0.2F, 0.5F, 0.9F}) {
        Material material = open_glass(glass(1.5F, 0, true), opacity);
        if (has_priority) material.medium_priority = 1;
        const Scene scene = ball_within_walls(material, is_shape);
        for (const glm::dvec3& eye : {glm::dvec3(0, 0, 0.95), glm::dvec3(0, 0, 0.2)}) {
          const bool is_inside = eye.z < 0.5;
          const Settings settings = seen_from(eye);
          const Film film = film_of(scene, settings);
          const double expected = is_inside ? 1.5 * 1.5 : 1;
          for (std::uint32_t y = 0; y < 12; ++y)
            for (std::uint32_t x = 0; x < 12; ++x)
              ASSERT_NEAR(film.mean(x, y, 0), expected, 2e-3)
                  << x << ',' << y << ", opacity " << opacity << (is_shape ? ", shape" : ", mesh");
          Execution queues;
          queues.lanes = 1, queues.chunked = false, queues.layout = "bvh2";
          EXPECT_TRUE(same_film(film_of(scene, settings, queues), film)) << "queues";
        }
      }
}

TEST(OpenSolid, rough_and_dispersing_ones_neither_make_nor_lose_light) {
  Material rough = glass(1.5F, 0.4F, true), flint = glass(1.62F, 0, true);
  flint.dispersion = 2;
  for (const Material& material : {rough, flint}) {
    Settings settings = seen_from({0, 0, 0.95});
    settings.sample_end = 512;
    settings.energy_compensation = true;
    const Film film = film_of(ball_within_walls(open_glass(material, 0.5F), false), settings);
    EXPECT_NEAR(mean_of(film).mean, 1, 2e-3) << "roughness " << material.roughness;
  }
}

/// A slab of two metres that leaves half of the light in each, with holes in its front: alphaMode
/// MASK, and corners whose alpha is below the cutoff.
Scene slab_with_holes(const Material& amber_glass) {
  Scene scene;
  add_lamp(scene);
  Primitive slab;
  add_box(slab, {-20, -20, 0}, {20, 20, 2}, false);
  std::vector<glm::vec4> colors;
  for (const glm::vec3& p : slab.positions_object) colors.emplace_back(1, 1, 1, p.z > 1 ? 0.1F : 1.0F);
  slab.colors = colors;
  Material material = amber_glass;
  material.alpha_mode = AlphaMode::mask;
  add_mesh(scene, "slab", std::move(slab), material);
  return scene;
}

TEST(OpenSolid, absorbs_behind_its_openings) {
  for (const bool has_priority : {false, true}) {
    Material material = amber(0.5F, 1);
    if (has_priority) material.medium_priority = 1;
    const Settings settings = settings_for_beam({0, 0, 4}, {0, 0, 0}, 64);
    const Scene holes = slab_with_holes(material);
    EXPECT_TRUE(Features(holes, settings).has(Feature::open_solid));
    EXPECT_TRUE(agrees(mean_of(film_of(holes, settings)), 0.25, 4, 1e-4)) << has_priority;
    Scene scene;
    add_lamp(scene);
    add_block(scene, "slab", {-20, -20, 0}, {20, 20, 2}, open_glass(material, 0.6F));
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 0.25, 4, 1e-4)) << has_priority;
  }
}

TEST(OpenSolid, openings_do_not_count_towards_depth) {
  const Scene scene = ball_within_walls(open_glass(glass(1.5F, 0, true), 1e-3F), false);
  Settings settings = seen_from({0, 0, 0.95});
  settings.aovs = {"emission"};
  for (const std::uint32_t max_depth : {0U, 1U}) {
    settings.max_depth = max_depth;
    const Film film = film_of(scene, settings);
    // Two of a thousand rays meet the glass itself.
    for (const std::uint32_t channel : {0U, film.channel_index("scattered.0.R").value()})
      EXPECT_NEAR(mean_of(film, channel).mean, 1, 4e-3) << "max_depth " << max_depth << ", channel " << channel;
  }
}

TEST(OpenSolid, light_is_the_same_with_and_without_light_paths) {
  auto [scene, settings] = room_of_glass(16, 1024);
  for (Material& material : scene.materials)
    if (material.solid) {
      material = open_glass(material, 0.6F);
      material.attenuation_color = {0.3F, 0.5F, 0.9F};
      material.attenuation_distance = 0.3F;
    }
  expect_the_same_mean("smooth", scene, settings, 8192, 24);
  for (Material& material : scene.materials)
    if (material.solid) material.roughness = 0.3F;
  settings.sample_end = 2048;
  expect_the_same_mean("rough", scene, settings, 16384, 24);
}

TEST(OpenSolid, light_is_the_same_with_and_without_light_paths_where_one_half_is_open) {
  // Light enters the ball by an opening and leaves it by glass, or the reverse.
  for (const bool top_is_open : {true, false})
    for (const float roughness : {0.0F, 0.3F}) {
      auto [scene, settings] = room_of_glass(16, 512);
      for (Mesh& mesh : scene.meshes) {
        Primitive& primitive = mesh.primitives[0];
        Material& material = scene.materials[primitive.material];
        if (!material.solid) continue;
        std::vector<glm::vec4> colors;
        for (const glm::vec3& p : primitive.positions_object)
          colors.emplace_back(1, 1, 1, (p.y > -0.5F) == top_is_open ? 0.0F : 1.0F);
        primitive.colors = colors;
        material.alpha_mode = AlphaMode::mask;
        material.roughness = roughness;
      }
      ASSERT_TRUE(Features(scene, settings).has(Feature::open_solid));
      expect_the_same_mean(top_is_open ? "top" : "bottom", scene, settings, 8192, 48);
    }
}

TEST(OpenSolid, light_paths_pass_openings) {
  // Light falls at right angles and goes straight on. It enters and leaves the slab by glass, which
  // passes T and reflects F = 1 - T, or by an opening, where its radiance over the square of the
  // index stays the same, and so does its solid angle.
  const double f = std::pow(0.5 / 2.5, 2), n2 = 1.5 * 1.5;
  for (const float opacity : {0.1F, 0.5F, 1.0F}) {
    Scene scene;
    Primitive floor;
    add_quad(floor, {-3, 0, 3}, {6, 0, 0}, {0, 0, -6});
    add_mesh(scene, "floor", std::move(floor), lambert(0.01F));
    add_block(scene, "slab", {-2, 1, -2}, {2, 1.2F, 2}, open_glass(glass(1.5F, 0, true), opacity));
    scene.lights.push_back(sunshine({0, -1, 0}, 1));
    Settings settings = settings_for(16, 16, 256);
    settings.camera = look_at_camera({0.6, 0.6, 0.6}, {0.6, 0, 0}, {0, 1, 0}, 0.3);
    const double there = double(opacity), open = 1 - there, reflected = there * f;
    const double enters = open * n2 + there * (1 - f), leaves = open / n2 + there * (1 - f);
    const double passed = enters * leaves / (1 - reflected * reflected);
    EXPECT_TRUE(agrees(mean_of(film_of(scene, with_light_paths(settings, 64))), 0.01 / kPi * passed, 3, 3e-3))
        << opacity;
  }
}

TEST(OpenSolid, rough_ones_let_light_paths_pass_however_rough_they_are) {
  // At opacity .001 the slab is as good as not there.
  for (const float roughness : {0.3F, 0.9F}) {
    Scene scene;
    Primitive floor;
    add_quad(floor, {-3, 0, 3}, {6, 0, 0}, {0, 0, -6});
    add_mesh(scene, "floor", std::move(floor), lambert(0.01F));
    add_block(scene, "slab", {-2, 1, -2}, {2, 1.2F, 2}, open_glass(glass(1.5F, roughness, true), 1e-3F));
    scene.lights.push_back(sunshine({0, -1, 0}, 1));
    EXPECT_TRUE(only_light_paths_find_some(scene));
    Settings settings = settings_for(16, 16, 64);
    settings.camera = look_at_camera({0.6, 0.6, 0.6}, {0.6, 0, 0}, {0, 1, 0}, 0.3);
    EXPECT_TRUE(agrees(mean_of(film_of(scene, with_light_paths(settings, 64))), 0.01 / kPi, 3, 5e-3)) << roughness;
  }
}

TEST(OpenSolid, the_layers_of_the_first_hit_show_the_glass_in_its_openings) {
  const Scene scene = ball_within_walls(open_glass(glass(1.5F, 0, true), 0.5F), false);
  Settings settings = seen_from({0, 0, 0.95});
  settings.aovs = {"depth"};
  const Film film = film_of(scene, settings);
  EXPECT_NEAR(film.mean(6, 6, film.channel_index("depth.Z").value()), 0.45, 0.02);
}

TEST(OpenSolid, the_opacity_of_an_implicit_surface_does_not_count) {
  SceneChoice choice;
  Scene scene = load_scene(std::string(EIKON_SOURCE_DIR) + "/scenes/implicit_gyroid.gltf", choice);
  const Settings settings = settings_of(scene, 16, 8);
  ASSERT_FALSE(scene.shapes.empty());
  const std::uint32_t glass_of_it = scene.shapes[0].material;
  ASSERT_TRUE(scene.materials[glass_of_it].solid);
  const Film opaque = film_of(scene, settings);
  scene.materials[glass_of_it].alpha_mode = AlphaMode::blend;
  scene.materials[glass_of_it].opacity = 0.3F;
  EXPECT_FALSE(Features(scene, settings).has(Feature::open_solid));
  EXPECT_TRUE(same_film(film_of(scene, settings), opaque));
  // Nor does it where another solid has openings.
  const auto with_ball = [&](float opacity) {
    Scene two = scene;
    two.materials[glass_of_it].opacity = opacity;
    add_mesh(two, "ball", sphere({0, 10, 0}, 0.1F, 6, false), open_glass(glass(1.5F, 0, true), 0.5F));
    EXPECT_TRUE(Features(two, settings).has(Feature::open_solid));
    return film_of(two, settings);
  };
  EXPECT_TRUE(same_film(with_ball(0.3F), with_ball(1)));
}

TEST(OpenSolid, openings_of_an_open_mesh_lead_to_no_inside) {
  Scene scene;
  Primitive sheet;
  add_quad(sheet, {-4, -4, -2}, {8, 0, 0}, {0, 8, 0});
  Material material = open_glass(glass(1.5F, 0, true), 1e-6F);
  add_mesh(scene, "sheet", std::move(sheet), material);
  Settings settings = settings_for(8, 8, 16);
  settings.environment.radiance = glm::vec3(1);
  EXPECT_FALSE(Features(scene, settings).has(Feature::open_solid));
  EXPECT_NEAR(mean_of(film_of(scene, settings)).mean, 1, 1e-4);
}

TEST(OpenSolid, a_camera_is_inside_of_none_whose_openings_lead_to_no_inside) {
  // Absorption would go on outside, to infinity.
  Material amber = open_glass(glass(1.5F, 0, true), 1e-6F);
  amber.attenuation_color = {0.2F, 0.5F, 0.9F};
  amber.attenuation_distance = 0.1F;
  Material lamp = amber;
  lamp.emission = glm::vec3(1e-4F);
  for (const bool is_shape : {false, true})
    for (const bool emits : {false, true}) {
      const Scene scene = ball_within_walls(emits ? lamp : amber, is_shape);
      Settings settings = seen_from({0, 0, 0.2});
      settings.integrator = emits ? Integrator::path : Integrator::raycast;
      EXPECT_NEAR(mean_of(film_of(scene, settings)).mean, 1, 1e-3) << is_shape << emits;
    }
}

TEST(OpenSolid, a_mesh_is_closed_if_its_triangles_leave_no_hole) {
  const auto closed = [](Primitive primitive, bool is_solid) {
    Scene scene;
    add_mesh(scene, "mesh", std::move(primitive), glass(1.5F, 0, is_solid));
    return is_closed(scene, scene.meshes[0]);
  };
  Primitive box;
  add_box(box, {-1, -1, -1}, {1, 1, 1}, false);  // whose sides have corners of their own
  EXPECT_TRUE(closed(box, true));
  EXPECT_FALSE(closed(box, false)) << "nothing of it is a solid";
  EXPECT_TRUE(closed(sphere({100, 2, 3}, 0.7F, 10, false), true));
  Primitive less = box;
  std::vector<std::uint32_t> corners = less.indices.list();
  std::swap(corners[0], corners[1]);
  less.indices = corners;
  EXPECT_FALSE(closed(less, true)) << "one triangle is turned";
  corners.resize(corners.size() - 3);
  less.indices = corners;
  EXPECT_FALSE(closed(less, true)) << "one triangle is missing";

  // A tube whose ends are open: its normals cancel.
  Primitive tube;
  for (int i = 0; i < 12; ++i) {
    const float a = float(i) * float(kPi) / 6, b = float(i + 1) * float(kPi) / 6;
    add_quad(tube, {std::cos(a), 0, -std::sin(a)}, {std::cos(b) - std::cos(a), 0, std::sin(a) - std::sin(b)},
             {0, 1, 0});
  }
  EXPECT_FALSE(closed(tube, true));

  // Many files have balls whose seam and poles were rounded apart.
  Primitive ball;
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;
  constexpr std::uint32_t kAround = 20, kDown = 10;
  for (std::uint32_t j = 0; j <= kDown; ++j)
    for (std::uint32_t i = 0; i <= kAround; ++i) {
      const double phi = 2 * kPi * i / kAround, theta = kPi * j / kDown;
      positions.emplace_back(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
    }
  for (std::uint32_t j = 0; j < kDown; ++j)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const std::uint32_t a = j * (kAround + 1) + i, b = a + kAround + 1;
      for (const std::uint32_t corner : {a, b, a + 1, a + 1, b, b + 1}) indices.push_back(corner);
    }
  ASSERT_NE(positions[kAround + 1], positions[2 * kAround + 1]) << "the seam is one";
  ball.positions_object = positions;
  ball.indices = indices;
  EXPECT_TRUE(closed(ball, true));
}

}  // namespace
}  // namespace eikon::test
