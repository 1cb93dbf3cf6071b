// SPDX-License-Identifier: Apache-2.0
// Opacity: MASK and BLEND, by factor, texture and vertex colour, for paths, shadow rays and lights.
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

Material in_part(AlphaMode mode, float opacity, glm::vec3 albedo = glm::vec3(0), glm::vec3 emission = glm::vec3(0)) {
  Material material = lambert(albedo, emission);
  material.alpha_mode = mode;
  material.opacity = opacity;
  return material;
}
Material blend(float opacity) { return in_part(AlphaMode::blend, opacity); }

/// `count` parallel quads of one material between z = -3 and z = -2, which fill the view of a
/// camera at the origin.
Scene layers(std::uint32_t count, const Material& material) {
  Scene scene;
  Primitive quads;
  for (std::uint32_t i = 0; i < count; ++i)
    add_quad(quads, {-4, -4, -2 - float(i) / float(count)}, {8, 0, 0}, {0, 8, 0});
  add_mesh(scene, "layers", std::move(quads), material);
  return scene;
}

Settings in_white(std::uint32_t side, std::uint64_t spp) {
  Settings settings = settings_for(side, side, spp);
  settings.environment.radiance = glm::vec3(1);
  return settings;
}

TEST(Opacity, M22_a_thousand_layers_of_opacity_0_are_none) {
  Scene scene = layers(1000, blend(0));
  Primitive ball = sphere({0, 0, -2.5F}, 0.4F, 6, false);
  add_mesh(scene, "ball", std::move(ball), lambert(0.5F));
  Scene solid = scene;
  solid.meshes[0].primitives[0].indices = {};  // its corners stay: with the same bounds hits have the same bits
  const Settings settings = in_white(16, 16);
  const Film film = film_of(scene, settings);
  // Where the ball is not, every sample is the sky, exactly.
  std::size_t sky = 0;
  for (std::uint32_t y = 0; y < 16; ++y)
    for (std::uint32_t x = 0; x < 16; ++x)
      if (film.mean(x, y, 0) == 1.0) ++sky;
  EXPECT_GT(sky, 100U);
  EXPECT_LT(sky, 256U);
  EXPECT_TRUE(same_film(film, film_of(solid, settings)));
}

TEST(Opacity, M22_mask_is_there_from_its_cutoff_on) {
  const Settings settings = in_white(8, 4);
  const auto seen = [&](float opacity, float cutoff) {
    Material material = in_part(AlphaMode::mask, opacity);
    material.alpha_cutoff = cutoff;
    return mean_of(film_of(layers(2, material), settings)).mean;
  };
  EXPECT_EQ(seen(0.5F, 0.5F), 0);
  EXPECT_EQ(seen(std::nextafter(0.5F, 0.0F), 0.5F), 1);
  EXPECT_EQ(seen(1, 1), 0);
  EXPECT_EQ(seen(0, 0), 0);
  EXPECT_EQ(seen(1, std::nextafter(1.0F, 2.0F)), 1);
}

TEST(Opacity, M22_layers_of_opacity_one_half_let_a_power_of_it_through) {
  const std::uint32_t counts[] = {1, 2, 3, 5, 8};
  for (const std::uint32_t n : counts) {
    const Film film = film_of(layers(n, blend(0.5F)), in_white(32, n > 4 ? 512 : 64));
    EXPECT_TRUE(agrees(mean_of(film), std::pow(0.5, n), int(std::size(counts)) + 2)) << n << " layers";
  }
  // No limit to how many surfaces a ray may pass.
  const double expected = std::pow(1 - double(0.001F), 1000);
  EXPECT_TRUE(agrees(mean_of(film_of(layers(1000, blend(0.001F)), in_white(32, 64))), expected, 7));
  const double most = std::pow(1 - double(0.0005F), 4000);
  EXPECT_TRUE(agrees(mean_of(film_of(layers(4000, blend(0.0005F)), in_white(32, 64))), most, 7));
}

TEST(Opacity, of_one_layer_costs_less_noise_than_random_decisions) {
  for (const float opacity : {0.5F, 0.3F}) {
    const Film film = film_of(layers(1, blend(opacity)), in_white(32, 64));
    const double random = opacity * (1 - opacity) / (64.0 * 32 * 32);
    EXPECT_LT(std::pow(mean_of(film).sigma, 2), 0.1 * random);
  }
}

/// The square light 1 m above the floor, seen from just above the floor, under `count` layers of
/// `material`.
std::pair<Scene, Settings> light_behind(std::uint32_t count, const Material& material, LightSampling sampling,
                                        std::uint64_t spp) {
  Scene scene = square_light();
  Primitive quads;
  for (std::uint32_t i = 0; i < count; ++i) add_quad(quads, {-8, 0.5F + 0.03F * float(i), -8}, {16, 0, 0}, {0, 0, 16});
  if (count > 0) add_mesh(scene, "layers", std::move(quads), material);
  Settings settings = settings_for(8, 8, spp);
  settings.camera = look_at_camera({0, 0.4, 0}, {0, 0, 0}, {0, 0, 1}, 0.01);
  settings.light_sampling = sampling;
  settings.seed = 5 + static_cast<std::uint32_t>(sampling);
  return {std::move(scene), settings};
}

constexpr LightSampling kEveryWay[] = {LightSampling::mis, LightSampling::light, LightSampling::bsdf};

TEST(Opacity, M22_light_behind_layers_is_dimmed_for_shadow_rays_and_scattered_rays_alike) {
  for (const std::uint32_t n : {0U, 1U, 3U})
    for (const LightSampling sampling : kEveryWay) {
      const auto [scene, settings] = light_behind(n, blend(0.5F), sampling, 1024);
      const double expected = kSquareLightIrradiance / std::numbers::pi * std::pow(0.5, n);
      EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), expected, 9)) << n << " layers, " << int(sampling);
    }
}

TEST(Opacity, a_light_shines_as_far_as_it_is_there_however_it_is_found) {
  for (const LightSampling sampling : kEveryWay) {
    auto [scene, settings] = light_behind(0, {}, sampling, 1024);
    Material& light = scene.materials[1];
    ASSERT_GT(light.emission.x, 0);
    light.alpha_mode = AlphaMode::blend;
    light.opacity = 0.3F;
    const double whole = kSquareLightIrradiance / std::numbers::pi;
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), whole * double(0.3F), 9)) << int(sampling);
    // Masked by a texture that is there on the half x < 0; the light is symmetric.
    light.alpha_mode = AlphaMode::mask;
    light.opacity = 1;
    light.base_color_texture.emplace();
    light.base_color_texture->filter = TextureFilter::nearest;
    scene.images.push_back({"half", 2, 1, {0xffffffff, 0x00ffffff}});
    Primitive& quad = scene.meshes[1].primitives[0];
    for (const glm::vec3& p : quad.positions_object) quad.uv[0].emplace_back(p.x + 0.5F, 0.5F);
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 0.5 * whole, 9)) << int(sampling);
    // And by vertex colours.
    light.alpha_mode = AlphaMode::blend;
    light.base_color_texture.reset();
    quad.colors.assign(quad.positions_object.size(), {1, 1, 1, 0.25F});
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 0.25 * whole, 9)) << int(sampling);
  }
}

TEST(Opacity, comes_from_textures_and_vertex_colours) {
  const Settings settings = in_white(16, 64);
  Scene scene = layers(1, blend(0.8F));
  Primitive& quad = scene.meshes[0].primitives[0];
  // Opacity 0 at the left edge of the view to 1 at the right: the camera sees x from -w to w at z =
  // -2.
  const float w = 2 * std::tan(0.5F * float(settings.camera.yfov_rad));
  for (const glm::vec3& p : quad.positions_object) quad.colors.emplace_back(1, 1, 1, 0.5F + 0.5F * p.x / w);
  for (glm::vec4& c : quad.colors) ASSERT_TRUE(std::isfinite(c.w));
  const Film graded = film_of(scene, settings);
  for (const std::uint32_t x : {0U, 5U, 10U, 15U}) {
    const double middle = (x + 0.5) / 16;
    EXPECT_TRUE(agrees(mean_of(graded, 0, {x, 0, x + 1, 16}), 1 - double(0.8F) * middle, 4)) << x;
  }
  // A checkerboard of holes: each pixel is all or nothing, by the >= of codes, and sRGB does not
  // touch alpha.
  quad.colors.clear();
  Material& material = scene.materials[0];
  material.alpha_mode = AlphaMode::mask;
  material.opacity = 1;
  material.alpha_cutoff = 128.0F / 255.0F;
  material.base_color_texture.emplace();
  material.base_color_texture->filter = TextureFilter::nearest;
  material.base_color_texture->srgb = true;
  scene.images.push_back({"holes", 2, 2, {0x80ffffff, 0x7fffffff, 0x00ffffff, 0xffffffff}});
  for (const glm::vec3& p : quad.positions_object)
    quad.uv[0].emplace_back(0.5F + 0.5F * p.x / w, 0.5F - 0.5F * p.y / w);
  const Film holes = film_of(scene, settings);
  for (std::uint32_t y = 0; y < 16; ++y)
    for (std::uint32_t x = 0; x < 16; ++x) ASSERT_EQ(holes.mean(x, y, 0), (x < 8) == (y < 8) ? 0 : 1) << x << "," << y;
}

TEST(Opacity, blend_where_nothing_passes_is_opaque) {
  const auto [opaque, settings] = room(24, 24, 16);
  Scene blended = opaque;
  for (Material& material : blended.materials) material.alpha_mode = AlphaMode::blend;
  EXPECT_TRUE(same_film(film_of(opaque, settings), film_of(blended, settings)));
}

/// The room with foliage in it: random leaves with holes, a veil, tinted panes, a lamp that is
/// there in part.
std::pair<Scene, Settings> foliage(std::uint32_t leaves) {
  auto [scene, settings] = room(31, 21, 8);
  scene.images.push_back({"leaf", 4, 4, {}});
  for (std::uint32_t i = 0; i < 16; ++i) scene.images[0].rgba8.push_back((i * 37 % 256) << 24 | 0x40a060);
  Primitive leaf;
  std::uint32_t state = 1;
  const auto random = [&] { return float((state = state * 1664525U + 1013904223U) >> 8) * 0x1p-24F; };
  for (std::uint32_t i = 0; i < leaves; ++i) {
    const glm::vec3 p(random() * 1.8F - 0.9F, random() * 1.6F - 0.9F, random() * 1.6F - 0.8F);
    const glm::vec3 a(random() - 0.5F, random() - 0.5F, random() - 0.5F), b(a.y, -a.z, a.x);
    add_quad(leaf, p, 0.3F * a, 0.3F * b);
    for (const glm::vec2& uv : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)}) {
      leaf.uv[0].push_back(uv * 1.7F);
      leaf.colors.emplace_back(1, 1, 1, 0.3F + random());
    }
  }
  Primitive veil;
  for (float z : {0.5F, 0.6F, 0.7F}) add_quad(veil, {-1, -1, z}, {2, 0, 0}, {0, 1.6F, 0});
  Material cut = in_part(AlphaMode::mask, 1, {0.2F, 0.6F, 0.3F});
  cut.base_color_texture.emplace();
  cut.base_color_texture->srgb = true;
  Material soft = cut;
  soft.alpha_mode = AlphaMode::blend;
  Primitive second = leaf;
  for (glm::vec3& p : second.positions_object) p.x = -p.x;
  add_mesh(scene, "cut", std::move(leaf), cut);
  add_mesh(scene, "soft", std::move(second), soft);
  add_mesh(scene, "veil", std::move(veil), in_part(AlphaMode::blend, 0.3F, glm::vec3(0.9F)));
  for (Material& material : scene.materials)
    if (material.emission.x > 0) material.alpha_mode = AlphaMode::blend, material.opacity = 0.7F;
  return {std::move(scene), settings};
}

TEST(Opacity, M22_any_lane_width_order_of_paths_tree_and_device_give_the_same_bits) {
  for (const std::uint32_t leaves : {60U, 1500U}) {
    const auto [scene, settings] = foliage(leaves);
    const Film expected = film_of(scene, settings);
    for (const Execution& execution : leaves == 60 ? ways_to_trace() : each_way_to_trace())
      EXPECT_TRUE(same_film(expected, film_of(scene, settings, execution)))
          << leaves << " leaves, " << describe(execution);
    for (const DeviceInfo& info : select_devices("all")) {
      Execution execution;
      execution.devices = std::to_string(info.index);
      EXPECT_TRUE(same_film(expected, film_of(scene, settings, execution))) << info.name;
    }
    // It is the leaves that are seen through.
    Scene opaque = scene;
    for (Material& material : opaque.materials) material.alpha_mode = AlphaMode::opaque;
    EXPECT_FALSE(same_film(expected, film_of(opaque, settings)));
  }
}

TEST(Opacity, any_pool_crop_and_split_of_samples_give_the_same_bits) {
  const auto [scene, settings] = foliage(200);
  const Film whole = film_of(scene, settings);
  Execution cut;
  cut.unit_paths = 64, cut.chunk = 16, cut.block = 5;
  EXPECT_TRUE(same_film(whole, film_of(scene, settings, cut)));
  Settings window = settings;
  window.crop = {3, 5, 20, 11};
  EXPECT_TRUE(same_window(whole, film_of(scene, window)));
  Settings first = settings, second = settings;
  first.sample_end = second.sample_begin = 3;
  Film parts = film_of(scene, second);
  parts.add(film_of(scene, first));
  EXPECT_TRUE(same_film(whole, parts));
  Execution plain;
  plain.optimise = false;
  EXPECT_TRUE(same_film(whole, film_of(scene, settings, plain)));
}

}  // namespace
}  // namespace eikon::test
