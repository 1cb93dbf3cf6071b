// SPDX-License-Identifier: Apache-2.0
// Scenes whose answer is known in closed form. Judged at significance 1 % per test.
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

constexpr LightSampling kAll[] = {LightSampling::mis, LightSampling::light, LightSampling::bsdf,
                                  LightSampling::hemisphere};

/// Looks straight down on the origin from under the square light.
Settings under_the_light(std::uint64_t spp) {
  Settings settings = settings_for(16, 16, spp);
  // So narrow that the irradiance at the origin is that of all that is seen, to 2e-7.
  settings.camera = look_at_camera({0, 0.9, 0.001}, {0, 0, 0}, {0, 1, 0}, 0.001);
  return settings;
}

TEST(Analytic, L1_square_light_by_each_way_of_finding_it) {
  for (LightSampling sampling : kAll) {
    Settings settings = under_the_light(1024);
    settings.light_sampling = sampling;
    EXPECT_TRUE(agrees(mean_of(film_of(square_light(), settings)), kSquareLightIrradiance / kPi, 4))
        << name_of(sampling);
  }
}

TEST(Analytic, L2_slanted_triangles_over_a_grey_floor) {
  const std::pair<int, double> known[] = {
      {1, 0.0898394}, {2, 0.02292}, {3, 0.0534198}, {4, 0.0205314}, {5, 0.26174}};  // six digits are given
  for (const auto& [number, radiance] : known) {
    const Scene scene = load_shipped("nori_triangle_" + std::to_string(number) + ".gltf");
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings_of(scene, 8, 1024))), radiance, 5, 5e-5)) << number;
  }
}

TEST(Analytic, L9_closed_sphere_that_emits_half_and_reflects_half) {
  const Scene scene = load_shipped("sphere_kd_half.gltf");
  for (LightSampling sampling : {LightSampling::mis, LightSampling::bsdf}) {
    Settings settings = settings_of(scene, 24, 64);
    settings.light_sampling = sampling;
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 1.0, 2)) << name_of(sampling);
  }
}

TEST(Analytic, L10_furnace_reaches_its_series) {
  const Settings settings = settings_for(24, 24, 64);
  EXPECT_TRUE(agrees(mean_of(film_of(furnace(0.5F, 1), settings)), 2, 2));
  EXPECT_TRUE(agrees(mean_of(film_of(furnace(0.8F, 1), settings)), 5, 2));
}

TEST(Analytic, L10_furnace_with_a_depth_limit_is_the_truncated_series) {
  Settings settings = settings_for(24, 24, 64);
  settings.max_depth = 9;
  EXPECT_TRUE(agrees(mean_of(film_of(furnace(0.8F, 1), settings)), 4.328911, 2));
  EXPECT_TRUE(agrees(mean_of(film_of(furnace(0.95F, 1), settings)), 7.395012, 2));
}

TEST(Analytic, N10_roulette_changes_no_mean) {
  struct Case {
    float albedo;
    double expected;
    std::uint32_t roulette_depth, max_depth;
  };
  // Survival of 0.95 at most: above an albedo of sqrt(0.95) the variance has no bound, so there
  // roulette comes late and paths end.
  const double longest = (1 - std::pow(0.99, 400)) / 0.01;
  for (const Case& c : {Case{0.8F, 5, 1, 0}, Case{0.8F, 5, 4, 0}, Case{0.8F, 5, 40, 0}, Case{0.95F, 20, 4, 0},
                        Case{0.99F, longest, 300, 400}}) {
    Settings settings = settings_for(24, 24, 128);
    settings.roulette_depth = c.roulette_depth;
    settings.max_depth = c.max_depth;
    // Hundreds of edges: the rounding of each throughput adds up, and 0.99F is off by 2e-8 / 0.01.
    EXPECT_TRUE(agrees(mean_of(film_of(furnace(c.albedo, 1), settings)), c.expected, 5, 2e-5))
        << c.albedo << " from " << c.roulette_depth;
  }
}

TEST(Analytic, N10_every_depth_limit_without_roulette_is_the_truncated_series) {
  for (std::uint32_t depth : {1U, 2U, 3U, 8U, 64U}) {
    Settings settings = settings_for(16, 16, 16);
    settings.max_depth = depth;
    settings.roulette_depth = 1000;
    EXPECT_TRUE(agrees(mean_of(film_of(furnace(0.8F, 1), settings)), (1 - std::pow(0.8, depth)) / 0.2, 5)) << depth;
  }
}

TEST(Analytic, N1_as_dim_and_as_bright_as_it_gets) {
  for (const float emission : {1e-9F, 1e9F}) {
    const Film film = film_of(furnace(0.5F, emission), settings_for(16, 16, 64));
    // The film's unit is 2^-64 = 5.4e-20; each sample is cut by less.
    EXPECT_TRUE(agrees(mean_of(film), 2.0 * static_cast<double>(emission), 2, 1e-5)) << emission;
  }
}

/// Sphere of albedo `albedo` seen from inside, whose faces that `is_patch` chooses by their middle
/// emit 1.
Scene integrating_sphere(float albedo, glm::vec3 towards, float cos_cap, double& flux, double& area) {
  const Primitive whole = sphere({0, 0, 0}, 1, 48, true);
  Primitive wall, patch;
  flux = area = 0;
  for (std::size_t i = 0; i < whole.indices.size(); i += 3) {
    const glm::vec3 a = whole.positions_object[whole.indices[i]], b = whole.positions_object[whole.indices[i + 1]],
                    c = whole.positions_object[whole.indices[i + 2]];
    const bool lit = glm::dot(glm::normalize(a + b + c), glm::normalize(towards)) > cos_cap;
    add_triangle(lit ? patch : wall, a, b, c);
    const double size = 0.5 * glm::length(glm::cross(glm::dvec3(b - a), glm::dvec3(c - a)));
    area += size;
    if (lit) flux += kPi * size;
  }
  Scene scene;
  add_mesh(scene, "wall", std::move(wall), lambert(albedo));
  add_mesh(scene, "patch", std::move(patch), lambert(albedo, 1));
  return scene;
}

TEST(Analytic, L11_integrating_sphere_is_the_same_everywhere_for_every_patch) {
  struct Patch {
    glm::vec3 towards;
    float cos_cap;
  };
  for (const Patch& patch : {Patch{{0, 1, 0}, 0.9F}, Patch{{0.3F, -0.2F, 1}, 0.97F}, Patch{{-1, 0.5F, 0.2F}, 0.6F}}) {
    double flux = 0, area = 0;
    const Scene scene = integrating_sphere(0.8F, patch.towards, patch.cos_cap, flux, area);
    const double expected = 0.8 * flux / (kPi * area * 0.2);
    for (const glm::dvec3& away : {glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0.5)}) {
      Settings settings = settings_for(16, 16, 256);
      // From the middle, away from the patch.
      const glm::dvec3 target = -glm::normalize(glm::dvec3(patch.towards)) + 0.4 * away;
      settings.camera = look_at_camera({0, 0, 0}, target, {0.1, 0.9, 0.2}, 0.3);
      // A polyhedron of 9024 faces is a sphere to (pi / 48)^2 / 4 = 1e-3.
      EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), expected, 6, 1e-3)) << patch.cos_cap;
    }
  }
}

TEST(Analytic, L12_perpendicular_squares_have_their_form_factor) {
  const Scene scene = load_shipped("perpendicular_squares.gltf");
  const Film film = film_of(scene, settings_of(scene, 32, 256));
  EXPECT_TRUE(agrees(mean_of(film), 0.5 * 0.2000438, 1, 1e-5));
  for (std::uint32_t y = 0; y < 32; ++y)  // the shared edge
    EXPECT_TRUE(std::isfinite(film.mean(0, y, 0)) && film.mean(0, y, 0) < 0.5) << y;
}

TEST(Analytic, L13_convex_body_under_a_constant_sky_is_its_albedo) {
  const Scene scene = load_shipped("sphere_in_sky.gltf");
  Settings settings = settings_of(scene, 48, 16);
  settings.crop = {16, 16, 32, 32};  // all sphere
  const double albedo[] = {0.2, 0.5, 0.8};
  for (LightSampling sampling : {LightSampling::mis, LightSampling::light, LightSampling::bsdf}) {
    settings.light_sampling = sampling;
    const Film film = film_of(scene, settings);
    for (std::uint32_t c = 0; c < 3; ++c)  // cosine sampling of a constant sky: no noise at all
      for (std::uint32_t y = 16; y < 32; ++y)
        for (std::uint32_t x = 16; x < 32; ++x)
          ASSERT_NEAR(film.mean(x, y, c), albedo[c], 2e-6) << name_of(sampling) << " " << x << "," << y;
  }
  settings.light_sampling = LightSampling::hemisphere;
  settings.sample_end = 256;
  const Film film = film_of(scene, settings);
  for (std::uint32_t c = 0; c < 3; ++c) EXPECT_TRUE(agrees(mean_of(film, c), albedo[c], 3));
}

TEST(Analytic, L13_smooth_normals_do_not_darken_a_furnace_beyond_what_leaks_below_the_surface) {
  // Shading normals bend a lobe below the true surface; what goes there is lost, never gained.
  Scene scene;
  add_mesh(scene, "ball", sphere({0, 0, 0}, 1, 32, false, true), lambert(0.5F));
  Settings settings = settings_for(32, 32, 64);
  settings.crop = {10, 10, 22, 22};
  settings.camera = look_at_camera({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.5);
  settings.environment.radiance = glm::vec3(1);
  const double mean = mean_of(film_of(scene, settings)).mean;
  EXPECT_LE(mean, 0.5 * (1 + 1e-5));
  EXPECT_GE(mean, 0.5 * 0.98);
}

TEST(Analytic, N16_closed_box_absorbs_what_it_emits) {
  // From the middle of a cube a square field of view of 90 degrees shows one wall, every part of it
  // as large as it is.
  const double albedo[6] = {0.2, 0.7, 0.5, 0.9, 0.3, 0.6};  // -x +x -y +y -z +z; +y emits
  Scene scene;
  for (int i = 0; i < 6; ++i) {
    Primitive box, wall;
    add_box(box, glm::vec3(-1), glm::vec3(1), true);
    // add_box makes the faces in this order, four points each.
    for (std::size_t k = 0; k < 4; ++k)
      wall.positions_object.push_back(box.positions_object[4 * static_cast<std::size_t>(i) + k]);
    wall.indices = {0, 1, 2, 0, 2, 3};
    add_mesh(scene, "wall " + std::to_string(i), std::move(wall),
             lambert(static_cast<float>(albedo[i]), i == 3 ? 1.0F : 0.0F));
  }
  double absorbed = 0, variance = 0;
  for (int i = 0; i < 6; ++i) {
    Settings settings = settings_for(24, 24, 128);
    settings.seed = static_cast<std::uint32_t>(i);
    glm::dvec3 target(0), up(0);
    target[i / 2] = i % 2 == 0 ? -1 : 1;
    up[(i / 2 + 1) % 3] = 1;
    settings.camera = look_at_camera({0, 0, 0}, target, up, kPi / 2);
    const MeanAndError radiance = mean_of(film_of(scene, settings));
    const double factor = kPi * 4 * (1 - albedo[i]) / albedo[i];  // W absorbed per reflected radiance
    absorbed += factor * (radiance.mean - (i == 3 ? 1.0 : 0.0));
    variance += std::pow(factor * radiance.sigma, 2);
  }
  EXPECT_TRUE(agrees({absorbed, std::sqrt(variance)}, kPi * 4, 1));
}

TEST(Analytic, L16_fifty_thousand_lights_of_powers_twenty_decades_apart) {
  // A ceiling of small triangles over a point; the answer is Lambert's formula, triangle by
  // triangle, in double.
  constexpr int side = 160, kinds = 41;
  Scene scene;
  std::vector<Primitive> parts(kinds);
  double expected = 0;
  std::uint32_t state = 1;
  const auto irradiance = [](const glm::dvec3(&corner)[3]) {  // of a unit floor at the origin by radiance 1
    glm::dvec3 sum(0);
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 a = glm::normalize(corner[k]), b = glm::normalize(corner[(k + 1) % 3]), axis = glm::cross(a, b);
      sum += glm::normalize(axis) * std::atan2(glm::length(axis), glm::dot(a, b));
    }
    return 0.5 * std::abs(sum.y);
  };
  const auto emission_of = [](std::uint32_t kind) {
    return kind == 0 ? 0.0F : static_cast<float>(std::pow(10.0, 0.5 * kind - 10.25));
  };
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const auto at = [&](int x, int z) {
        return glm::vec3(static_cast<float>(x) / side - 0.5F, 1, static_cast<float>(z) / side - 0.5F);
      };
      const glm::vec3 corners[2][3] = {{at(i, j), at(i + 1, j), at(i + 1, j + 1)},
                                       {at(i, j), at(i + 1, j + 1), at(i, j + 1)}};
      for (const auto& t : corners) {
        state = state * 1664525U + 1013904223U;
        const std::uint32_t kind = (state >> 8) % kinds;
        add_triangle(parts[kind], t[0], t[1], t[2]);
        const glm::dvec3 exact[3] = {t[0], t[1], t[2]};
        expected += static_cast<double>(emission_of(kind)) * irradiance(exact);
      }
    }
  for (std::uint32_t kind = 0; kind < kinds; ++kind)
    add_mesh(scene, "light " + std::to_string(kind), std::move(parts[kind]), lambert(0, emission_of(kind)));
  Primitive floor;
  add_quad(floor, {-0.01F, 0, 0.01F}, {0.02F, 0, 0}, {0, 0, -0.02F});
  add_mesh(scene, "floor", std::move(floor), lambert(1));
  EXPECT_TRUE(agrees(mean_of(film_of(scene, under_the_light(1024))), expected / kPi, 1));
}

TEST(Analytic, an_empty_scene_is_its_environment) {
  const Scene scene;
  Settings settings = settings_for(8, 8, 4);
  settings.environment.radiance = {0.25F, 0.5F, 2};
  const Film film = film_of(scene, settings);
  EXPECT_EQ(film.mean(3, 4, 0), 0.25);
  EXPECT_EQ(film.mean(7, 7, 2), 2);
}

TEST(Analytic, N11_constant_scenes_are_constant_in_images_of_any_shape) {
  Settings settings;
  for (const auto& [width, height] : {std::pair{1U, 1U}, {1U, 16384U}, {16384U, 1U}, {65535U, 1U}}) {
    settings = settings_for(width, height, 2);
    settings.camera.yfov_rad = width > height ? 1e-4 : 1.0;
    const Film film = film_of(furnace(0, 0.7F), settings);
    for (std::uint32_t y = 0; y < height; ++y)
      for (std::uint32_t x = 0; x < width; ++x)
        ASSERT_NEAR(film.mean(x, y, 0), 0.7, 0.7e-6) << x << "," << y << " of " << width << "x" << height;
  }
}

}  // namespace
}  // namespace eikon::test
