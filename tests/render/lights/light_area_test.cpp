// SPDX-License-Identifier: Apache-2.0
// Area lights: closed forms, and textures that say where they emit.
#include "film/exr/film_file.h"
#include "image/image.h"
#include "pack/pack.h"
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

TEST(LightArea, L3_a_disk_lights_a_floor_as_its_closed_form_says) {
  Scene scene;
  Primitive floor, disk;
  add_quad(floor, {-0.01F, 0, 0.01F}, {0.02F, 0, 0}, {0, 0, -0.02F});
  constexpr int sides = 1024;
  const auto rim = [](int i) {
    const double angle = 2 * kPi * (i % sides) / sides;
    return glm::vec3(std::cos(angle), 1, std::sin(angle));
  };
  for (int i = 0; i < sides; ++i) add_triangle(disk, {0, 1, 0}, rim(i), rim(i + 1));  // faces down
  add_mesh(scene, "floor", std::move(floor), lambert(1));
  add_mesh(scene, "disk", std::move(disk), lambert(0, 1));
  for (LightSampling sampling : {LightSampling::mis, LightSampling::light, LightSampling::bsdf}) {
    Settings settings = settings_for(16, 16, 1024);
    settings.camera = look_at_camera({0, 0.9, 0.001}, {0, 0, 0}, {0, 1, 0}, 0.001);
    settings.light_sampling = sampling;
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 0.5, 3, 2e-5)) << int(sampling);
  }
}

TEST(LightArea, L19_a_million_and_more_are_exact) {
  Scene scene;
  Primitive lamp;
  add_quad(lamp, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  add_mesh(scene, "lamp", std::move(lamp), lambert(0, 1e6F));
  Settings settings = settings_for(4, 4, 16);
  settings.camera = look_at_camera({0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 0.5);
  const Image image = to_image(film_of(scene, settings));
  for (const float value : *image.plane("R")) EXPECT_EQ(value, 1e6F);
}

// ---- emissive textures --------------------------------------------------------------------------

/// A lamp of side 1 at height 1 over a small white floor, its emission times a texture.
Scene textured_lamp(std::uint32_t width, std::uint32_t height, std::vector<std::uint32_t> texels, TextureFilter filter,
                    float emission, glm::vec2 uv_scale = glm::vec2(1)) {
  Scene scene;
  Primitive floor, lamp;
  add_quad(floor, {-0.01F, 0, 0.01F}, {0.02F, 0, 0}, {0, 0, -0.02F});
  add_quad(lamp, {-0.5F, 1, -0.5F}, {1, 0, 0}, {0, 0, 1});
  lamp.uv[0] = {uv_scale * glm::vec2(0, 0), uv_scale * glm::vec2(1, 0), uv_scale * glm::vec2(1, 1),
                uv_scale * glm::vec2(0, 1)};
  add_mesh(scene, "floor", std::move(floor), lambert(1));
  Material material = lambert(0, emission);
  Texture texture;
  texture.filter = filter;
  texture.srgb = true;
  material.emissive_texture = texture;
  scene.images.push_back({.name = "glow", .width = width, .height = height, .rgba8 = std::move(texels)});
  add_mesh(scene, "lamp", std::move(lamp), material);
  return scene;
}

Settings under_the_lamp(std::uint64_t spp, LightSampling sampling, std::uint32_t seed) {
  Settings settings = settings_for(16, 16, spp);
  settings.camera = look_at_camera({0.005, 0.9, 0.001}, {0.005, 0, 0}, {0, 1, 0}, 0.001);
  settings.light_sampling = sampling;
  settings.seed = seed;
  return settings;
}

/// The same light as flat quads: cell (i, j) of an n x n grid over the lamp emits emission(i, j).
template <class Emission>
Scene mosaic(int n, Emission emission) {
  Scene scene;
  Primitive floor;
  add_quad(floor, {-0.01F, 0, 0.01F}, {0.02F, 0, 0}, {0, 0, -0.02F});
  add_mesh(scene, "floor", std::move(floor), lambert(1));
  const float side = 1.0F / float(n);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      if (emission(i, j) == glm::vec3(0)) continue;
      Primitive cell;
      add_quad(cell, {-0.5F + side * float(i), 1, -0.5F + side * float(j)}, {side, 0, 0}, {0, 0, side});
      add_mesh(scene, "cell", std::move(cell), lambert(glm::vec3(0), emission(i, j)));
    }
  return scene;
}

constexpr std::uint32_t kWhite = 0xffffffff, kBlack = 0xff000000, kRed = 0xff0000ff;

TEST(LightArea, a_textured_lamp_is_the_mosaic_of_its_texels_by_each_way_of_finding_it) {
  // Repeated 3 x 2 times: white, red, black and a grey that is 0.215861 of white after decoding.
  const std::vector<std::uint32_t> texels{kWhite, kRed, kBlack, 0xff808080};
  const Scene lamp = textured_lamp(2, 2, texels, TextureFilter::nearest, 4, {3, 2});
  const Scene reference = mosaic(12, [&](int i, int j) {
    const std::uint32_t texel = texels[std::size_t(j / 3 % 2 * 2 + i / 2 % 2)];
    return texel == kWhite   ? glm::vec3(4)
           : texel == kRed   ? glm::vec3(4, 0, 0)
           : texel == kBlack ? glm::vec3(0)
                             : glm::vec3(4 * 0.21586050F);
  });
  const Film expected = film_of(reference, under_the_lamp(4096, LightSampling::mis, 9));
  for (LightSampling sampling : {LightSampling::mis, LightSampling::light, LightSampling::bsdf}) {
    const Film film = film_of(lamp, under_the_lamp(4096, sampling, std::uint32_t(sampling)));
    for (std::uint32_t c = 0; c < 3; ++c)
      EXPECT_TRUE(agree(mean_of(film, c), mean_of(expected, c), 9)) << int(sampling) << ", channel " << c;
  }
}

TEST(LightArea, one_lit_texel_of_many_is_found_by_each_way) {
  std::vector<std::uint32_t> texels(64 * 64, kBlack);
  texels[20 * 64 + 37] = kWhite;
  const Scene lamp = textured_lamp(64, 64, texels, TextureFilter::linear, 1000);
  // Filtered, it is a tent of the same weight, two texels wide; far enough away for a square of
  // one.
  const Scene reference = mosaic(64, [](int i, int j) { return glm::vec3(i == 37 && j == 20 ? 1000.0F : 0.0F); });
  const MeanAndError expected = mean_of(film_of(reference, under_the_lamp(256, LightSampling::mis, 9)));
  for (LightSampling sampling : {LightSampling::mis, LightSampling::light, LightSampling::bsdf}) {
    const MeanAndError found = mean_of(film_of(lamp, under_the_lamp(16384, sampling, std::uint32_t(sampling))));
    EXPECT_TRUE(agrees({found.mean, std::hypot(found.sigma, expected.sigma)}, expected.mean, 3, 2e-3)) << int(sampling);
  }
}

TEST(LightArea, a_lamp_with_holes_gives_what_its_opacity_leaves) {
  for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend}) {
    // A quarter of the lamp is opaque; of the rest a tenth, which MASK cuts off.
    Scene lamp = textured_lamp(2, 2, {kWhite, 0x1affffff, 0x1affffff, 0x1affffff}, TextureFilter::nearest, 4);
    Material& material = lamp.materials.back();
    material.base_color_texture = material.emissive_texture;
    material.alpha_mode = mode;
    const float rest = mode == AlphaMode::mask ? 0 : 4 * 26.0F / 255;
    const Scene reference = mosaic(2, [&](int i, int j) { return glm::vec3(i == 0 && j == 0 ? 4 : rest); });
    const Film expected = film_of(reference, under_the_lamp(4096, LightSampling::mis, 9));
    for (LightSampling sampling : {LightSampling::mis, LightSampling::light, LightSampling::bsdf}) {
      const Film film = film_of(lamp, under_the_lamp(4096, sampling, std::uint32_t(sampling)));
      EXPECT_TRUE(agree(mean_of(film, 0), mean_of(expected, 0), 6)) << int(mode) << ", " << int(sampling);
    }
  }
}

PackedScene packed(const Scene& scene) {
  const Settings settings = settings_for(1, 1, 1);
  return pack_scene(scene, Features(scene, settings), settings);
}

TEST(LightArea, a_triangle_is_no_light_only_where_no_texel_it_can_show_emits) {
  // Eight strips over a picture of 64 columns, of which one is lit: strips that can reach it by
  // filtering are lights.
  for (const TextureFilter filter : {TextureFilter::nearest, TextureFilter::linear})
    for (const Wrap wrap : {Wrap::repeat, Wrap::clamp, Wrap::mirror})
      for (const int lit : {0, 7, 8, 30, 63}) {
        std::vector<std::uint32_t> texels(64, kBlack);
        texels[std::size_t(lit)] = 0xff010000;  // the faintest blue
        Scene scene;
        Primitive strips;
        for (int k = 0; k < 8; ++k) {
          add_quad(strips, {float(k), 0, 0}, {1, 0, 0}, {0, 1, 0});
          for (const glm::vec2& uv : {glm::vec2(k, 0), glm::vec2(k + 1, 0), glm::vec2(k + 1, 1), glm::vec2(k, 1)})
            strips.uv[0].push_back(uv / glm::vec2(8, 1));
        }
        Material material = lambert(0, 1);
        Texture texture;
        texture.filter = filter;
        texture.wrap_u = texture.wrap_v = wrap;
        material.emissive_texture = texture;
        scene.images.push_back({.name = "line", .width = 64, .height = 1, .rgba8 = texels});
        add_mesh(scene, "strips", std::move(strips), material);
        const PackedScene there = packed(scene);
        double sum = 0;
        for (const PackedLight& light : there.light_summary) sum += light.probability;
        EXPECT_EQ(sum, 1);
        for (std::size_t t = 0; t < there.triangles.size(); ++t) {
          const int k = int(t / 2), first = 8 * k, last = 8 * k + 7;
          const bool own = lit >= first && lit <= last;
          const bool beside = filter == TextureFilter::linear &&
                              (lit == first - 1 || lit == last + 1 || (wrap == Wrap::repeat && k == 0 && lit == 63) ||
                               (wrap == Wrap::repeat && k == 7 && lit == 0));
          const bool far = std::abs(lit - (first + 4)) > 14 && k != 0 && k != 7;
          const float pdf = there.triangles[t].light_pdf_m2;
          if (own || beside) {
            EXPECT_GT(pdf, 0) << "lit " << lit << ", strip " << k;
          }
          if (far) {
            EXPECT_EQ(pdf, 0) << "lit " << lit << ", strip " << k;
          }
        }
      }
}

TEST(LightArea, black_textures_emit_nothing_and_unlit_surfaces_are_no_lights) {
  Scene black = textured_lamp(2, 2, std::vector<std::uint32_t>(4, kBlack), TextureFilter::linear, 4);
  EXPECT_TRUE(packed(black).lights.empty());
  for (LightSampling sampling : {LightSampling::mis, LightSampling::bsdf})
    EXPECT_EQ(mean_of(film_of(black, under_the_lamp(16, sampling, 0))).mean, 0);
  Scene unlit = square_light();
  unlit.materials.back().unlit = true;
  EXPECT_TRUE(packed(unlit).lights.empty());
  EXPECT_EQ(first_emitter(unlit), nullptr);
  EXPECT_EQ(mean_of(film_of(unlit, under_the_lamp(16, LightSampling::mis, 0))).mean, 0);
}

TEST(LightArea, textured_power_is_near_the_mean_over_the_texture) {
  std::vector<std::uint32_t> texels;
  for (int j = 0; j < 32; ++j)
    for (int i = 0; i < 32; ++i) texels.push_back((i + j) % 2 == 0 ? kWhite : kBlack);
  const PackedScene there = packed(textured_lamp(32, 32, texels, TextureFilter::linear, 4));
  ASSERT_EQ(there.light_summary.size(), 1U);
  EXPECT_NEAR(there.light_summary[0].flux / (2 * kPi), 1, 0.05);
  EXPECT_NEAR(there.light_summary[0].area_m2, 1, 1e-6);
}

// ---- Veach's plates -----------------------------------------------------------------------------

TEST(LightArea, L20_veach_plates_by_bsdf_sampling_and_mis_which_is_no_worse_than_twice_the_better) {
  const Scene scene = load_shipped("veach_plates.gltf");
  Settings settings = settings_of(scene, 64, 512);
  settings.max_depth = 2;
  settings.aovs = {"id"};
  std::vector<std::size_t> plates;
  for (std::size_t n = 0; n < scene.nodes.size(); ++n)
    if (scene.materials[scene.meshes[scene.nodes[n].mesh].primitives[0].material].metallic == 1) plates.push_back(n);
  ASSERT_EQ(plates.size(), 4U);
  struct Strategy {
    LightSampling sampling;
    std::uint64_t spp;
  };
  // What light or BSDF sampling alone does badly takes many samples before its error is known.
  constexpr Strategy strategies[] = {
      {LightSampling::mis, 2048}, {LightSampling::light, 4096}, {LightSampling::bsdf, 16384}};
  MeanAndError found[3][4];
  double per_sample[3][4];
  std::vector<double> shown(
      64 * 64);  // 1 + node, by the first strategy: at rims it hangs on the seed, and all are to see the same
  for (int i = 0; i < 3; ++i) {
    Settings with = settings;
    with.light_sampling = strategies[i].sampling;
    with.sample_end = strategies[i].spp;
    with.seed = std::uint32_t(i);
    const Film film = film_of(scene, with);
    const std::uint32_t id = *film.channel_index("id");
    for (std::uint32_t k = 0; i == 0 && k < 64 * 64; ++k) shown[k] = to_double(film.total(k % 64, k / 64, id));
    for (std::size_t plate = 0; plate < 4; ++plate) {
      double sum = 0, variance = 0, count = 0;
      for (std::uint32_t k = 0; k < 64 * 64; ++k) {
        const std::uint32_t x = k % 64, y = k / 64;
        if (shown[k] != double(plates[plate] + 1)) continue;
        sum += film.mean(x, y, 1);
        variance += film.variance_of_mean(x, y, 1);
        ++count;
      }
      ASSERT_GT(count, 50) << "plate " << plate;
      found[i][plate] = {sum / count, std::sqrt(variance) / count};
      per_sample[i][plate] = variance * double(strategies[i].spp);
    }
  }
  for (std::size_t plate = 0; plate < 4; ++plate) {
    // Light sampling alone meets the mirrored peaks so seldom that its samples do not show how far
    // off their mean is.
    EXPECT_TRUE(agree(found[0][plate], found[2][plate], 4)) << "plate " << plate;
    EXPECT_LT(per_sample[0][plate], 2 * std::min(per_sample[1][plate], per_sample[2][plate])) << "plate " << plate;
  }
}

}  // namespace
}  // namespace eikon::test
