// SPDX-License-Identifier: Apache-2.0
// Shading normals in whole images: they bend what is seen, but make no light, let none through
// walls, and blacken no edge.
#include <random>

#include "render/scene_builder.h"

namespace eikon::test {
namespace {

/// A wild normal map: every texel leans another way, up to the surface itself.
Texture add_noise_map(Scene& scene) {
  std::mt19937 random(1);
  TextureImage image;
  image.name = "noise";
  image.width = image.height = 16;
  for (int i = 0; i < 256; ++i)
    image.rgba8.push_back(
        static_cast<std::uint32_t>((random() & 0xffffU) | (128U + (random() & 127U)) << 16 | 0xff000000U));
  scene.images.push_back(image);
  Texture texture;
  texture.image = static_cast<std::uint32_t>(scene.images.size() - 1);
  texture.filter = TextureFilter::nearest;
  return texture;
}

void add_coordinates(Primitive& primitive) {
  primitive.uv[0].clear();
  for (const glm::vec3& p : primitive.positions_object) primitive.uv[0].emplace_back(3 * p.x + p.z, 3 * p.y - p.z);
  primitive.tangents_object.assign(primitive.positions_object.size(), {0.8F, 0, -0.6F, 1});
}

Material metal(float albedo) {
  Material material = lambert(albedo);
  material.metallic = 1;
  material.specular = 1;
  material.roughness = 0.3F;
  return material;
}

/// A coarse ball: its smooth normals are up to 20 degrees off, and dip below the triangles at the
/// silhouette.
Scene ball(Material material, bool mapped) {
  Scene scene;
  Primitive primitive = sphere({0, 0, 0}, 1, 4, false, true);
  if (mapped) {
    add_coordinates(primitive);
    material.normal_texture = add_noise_map(scene);
  }
  add_mesh(scene, "ball", std::move(primitive), material);
  return scene;
}

Settings furnace_view(std::uint32_t side, std::uint64_t spp) {
  Settings settings = settings_for(side, side, spp);
  settings.camera = look_at_camera({0, 1, 4}, {0, 0, 0}, {0, 1, 0}, 0.6);
  settings.environment.radiance = glm::vec3(1);
  return settings;
}

TEST(ShadingNormals, M19_no_sample_of_a_white_ball_is_brighter_than_the_sky_around_it) {
  for (const bool mapped : {false, true}) {
    const Film film = film_of(ball(lambert(1), mapped), furnace_view(128, 1));
    double most = 0;
    for (std::uint32_t y = 0; y < 128; ++y)
      for (std::uint32_t x = 0; x < 128; ++x) {
        ASSERT_TRUE(film.mean(x, y, 0) >= 0) << x << "," << y;
        most = std::max(most, film.mean(x, y, 0));
      }
    EXPECT_LE(most, 1 + 1e-5) << "mapped " << mapped;
  }
}

TEST(ShadingNormals, a_silhouette_has_no_black_pixel) {
  // What a white metal must keep: usable_normal leaves the mirror direction above the face, so at
  // least half of the lobe around it; single scattering of a flat metal of roughness 0.3 keeps 0.88
  // or more of that at any view (0.95 at 0.05); the terminator takes 0.09 of it at most,
  // glossy_terminator. Together 0.4. The share of 256 samples that leave, each all or nothing, has
  // a deviation of 0.031: 0.25 is 4.9 of them below, which in the 1500 pixels of the ball happens
  // once in a thousand such tests. With the whole fade on reflections it was 0.02 for the sharpest
  // here. Lambert keeps more.
  std::vector<Material> materials{lambert(1)};
  for (const float roughness : {0.0F, 0.05F, 0.3F}) {
    materials.push_back(metal(1));
    materials.back().roughness = roughness;
  }
  for (const bool mapped : {false, true})
    for (const Material& material : materials) {
      const Film film = film_of(ball(material, mapped), furnace_view(64, 256));
      double least = 1;
      for (std::uint32_t y = 0; y < 64; ++y)
        for (std::uint32_t x = 0; x < 64; ++x) least = std::min(least, film.mean(x, y, 0));
      EXPECT_GT(least, 0.25) << "mapped " << mapped << ", metallic " << material.metallic << ", roughness "
                             << material.roughness;
    }
}

TEST(ShadingNormals, M19_mapped_walls_let_no_light_into_a_closed_box) {
  Material coated = lambert(0.9F);
  coated.clearcoat = 1;
  coated.clearcoat_roughness = 0.5F;
  for (const Material& base : {lambert(0.9F), metal(0.9F), coated})
    for (const bool inwards : {false, true}) {
      Scene scene;
      Material material = base;
      material.normal_texture = add_noise_map(scene);
      Primitive box;
      add_box(box, glm::vec3(-1), glm::vec3(1), inwards);
      // Normals of its own that lean outwards at the edges, as of a rounded cube.
      for (const glm::vec3& p : box.positions_object)
        box.normals_object.push_back(glm::normalize(p) * (inwards ? -1.0F : 1.0F));
      add_coordinates(box);
      add_mesh(scene, "box", std::move(box), material);
      Settings settings = furnace_view(64, 16);
      settings.camera = look_at_camera({0.2, 0.1, 0.3}, {-1, -0.3, -0.8}, {0, 1, 0}, 2.0);
      const Film film = film_of(scene, settings);
      EXPECT_EQ(mean_of(film).mean, 0) << "metallic " << base.metallic << ", coat " << base.clearcoat << ", inwards "
                                       << inwards;
    }
}

TEST(ShadingNormals, G22_brightness_is_continuous_where_a_coarse_ball_turns_from_a_light) {
  // A small bright light far to the side; along the equator the ball turns away from it. Flat
  // shading falls in 16 steps.
  Scene scene = ball(lambert(1), false);
  Primitive lamp;
  add_quad(lamp, {100, -5, 5}, {0, 0, -10}, {0, 10, 0});
  add_mesh(scene, "lamp", std::move(lamp), lambert(0, 100));
  TriangleIndices& indices = scene.meshes.back().primitives[0].indices;
  indices = {indices[0], indices[2], indices[1], indices[3], indices[5], indices[4]};
  scene.materials.back().double_sided = true;
  Settings settings = settings_for(128, 4, 256);
  settings.max_depth = 2;
  settings.camera = look_at_camera({0, 0.05, 6}, {0, 0.05, 0}, {0, 1, 0}, 0.35 * 4 / 128);
  const Film film = film_of(scene, settings);
  double brightest = 0, largest_step = 0, before = film.mean(40, 1, 0);
  for (std::uint32_t x = 40; x < 88; ++x) {
    const double now = film.mean(x, 1, 0);
    brightest = std::max(brightest, now);
    largest_step = std::max(largest_step, std::abs(now - before));
    before = now;
  }
  EXPECT_GT(brightest, 0);
  EXPECT_LT(largest_step, 0.2 * brightest);
}

}  // namespace
}  // namespace eikon::test
