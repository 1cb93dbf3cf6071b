// SPDX-License-Identifier: Apache-2.0
// Metal and glass in scenes of known answer. Judged at significance 1 % per test.
#include "render/materials/glass_builder.h"

namespace eikon::test {
namespace {

Material metal(glm::vec3 color, float roughness) {
  Material m;
  m.base_color = color;
  m.roughness = roughness;
  return m;
}

Scene slab(const Material& material, float half_thickness) {
  Scene scene;
  add_lamp(scene);
  Primitive box;
  add_box(box, {-20, -20, -half_thickness}, {20, 20, half_thickness}, false);
  add_mesh(scene, "slab", std::move(box), material);
  return scene;
}

TEST(Materials, M11_a_slab_of_glass_passes_twelve_thirteenths) {
  const Settings settings = settings_for_beam({0.1, 0.2, 4}, {0.1, 0.2, 0}, 4096);
  EXPECT_TRUE(agrees(mean_of(film_of(slab(glass(1.5F, 0, true), 0.5F), settings)), 12.0 / 13.0, 1));
}

TEST(Materials, a_thin_wall_passes_what_one_schlick_reflection_leaves_times_its_colour) {
  Scene scene;
  add_lamp(scene);
  Primitive pane;
  add_quad(pane, {-20, -20, 0}, {40, 0, 0}, {0, 40, 0});
  Material m = glass(1.5F, 0, false);
  m.base_color = {0.6F, 0.5F, 1};
  add_mesh(scene, "pane", std::move(pane), m);
  for (double side : {1.0, 0.0}) {  // from the front, and from behind by turning the pane
    if (side == 0) scene.nodes.back().world_from_object = glm::rotate(glm::dmat4(1), kPi, glm::dvec3(0, 1, 0));
    const Film film = film_of(scene, settings_for_beam({0.1, 0.2, 4}, {0.1, 0.2, 0}, 1024));
    EXPECT_TRUE(agrees(mean_of(film, 0), 0.96 * 0.6, 6));
    EXPECT_TRUE(agrees(mean_of(film, 1), 0.96 * 0.5, 6));
    EXPECT_TRUE(agrees(mean_of(film, 2), 0.96, 6));
  }
}

TEST(Materials, M12_smooth_glass_in_an_even_sky_cannot_be_seen) {
  for (const bool solid : {true, false}) {
    Scene scene;
    add_mesh(scene, "ball", sphere(glm::vec3(0), 1, 24, false), glass(1.5F, 0, solid));
    Settings settings = settings_for(32, 32, 64);
    settings.camera = look_at_camera({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.45);
    settings.environment.radiance = glm::vec3(1);
    // A few paths stay within the facets for hundreds of edges, and roulette would weigh them up.
    settings.roulette_survival = 1;
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 1, 2, 2e-5)) << (solid ? "solid" : "thin");
    settings.max_depth = 24;  // up to which roulette makes weights of 2.3 at most
    const MeanAndError short_paths = mean_of(film_of(scene, settings));
    settings.roulette_survival = 0;
    settings.seed = 1;
    EXPECT_TRUE(agree(mean_of(film_of(scene, settings)), short_paths, 2)) << (solid ? "solid" : "thin") << ", roulette";
  }
}

TEST(Materials, M13_an_index_of_one_is_air_and_extreme_ones_are_mirrors) {
  const auto film_with = [](float ior, std::uint64_t spp) {
    Scene scene;
    add_lamp(scene);
    add_mesh(scene, "ball", sphere(glm::vec3(0), 1, 16, false), glass(ior, 0, true));
    Settings settings = settings_for(24, 24, spp);
    settings.camera = look_at_camera({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.7);
    return film_of(scene, settings);
  };
  const Film air = film_with(1, 16), nearly = film_with(1 + 1e-6F, 16), dense = film_with(1e9F, 16),
             mirror = film_with(0, 16);
  for (std::uint32_t y = 0; y < 24; ++y)
    for (std::uint32_t x = 0; x < 24; ++x) {
      ASSERT_NEAR(air.mean(x, y, 0), 1, 1e-6) << x << ',' << y;
      ASSERT_NEAR(nearly.mean(x, y, 0), 1, 1e-2) << x << ',' << y;
    }
  // The middle of a mirror ball shows what is behind the camera: nothing.
  for (const Film* film : {&dense, &mirror}) {
    EXPECT_LT(film->mean(12, 12, 0), 1e-6);
    EXPECT_EQ(film->mean(0, 0, 0), 1);
  }
}

TEST(Materials, M15_light_is_halved_by_each_length_of_a_medium) {
  struct Case {
    float color, distance_m, half_thickness;
    double expected;
  };
  for (const Case& c :
       {Case{0.5F, 1, 1, 0.25}, Case{0.5F, 0, 1, 1.0}, Case{1, 1, 1, 1.0}, Case{0.5F, 2, 1, 0.5}, Case{0, 1, 1, 0.0}}) {
    Material m = glass(1, 0, true);
    m.attenuation_color = glm::vec3(c.color);
    m.attenuation_distance = c.distance_m;
    const Film film = film_of(slab(m, c.half_thickness), settings_for_beam({0.1, 0.2, 4}, {0.1, 0.2, 0}, 16));
    EXPECT_NEAR(mean_of(film).mean, c.expected, 4e-6) << c.color << " per " << c.distance_m << " m";
  }
}

TEST(Materials, M15_a_thing_inside_a_medium_is_seen_through_the_medium) {
  Scene scene = slab(
      [] {
        Material m = glass(1, 0, true);
        m.attenuation_color = glm::vec3(0.5F);
        m.attenuation_distance = 1;
        return m;
      }(),
      2);
  Primitive lamp;
  add_quad(lamp, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  add_mesh(scene, "inner lamp", std::move(lamp), lambert(0, 3));
  const Film film = film_of(scene, settings_for_beam({0.1, 0.2, 4}, {0.1, 0.2, 0}, 16));
  EXPECT_NEAR(mean_of(film).mean, 3 * 0.25, 1e-5);  // 2 m of it
}

/// A ball of `m` around the origin.
void add_ball(Scene& scene, const char* name, float radius, const Material& m) {
  add_mesh(scene, name, sphere({0, 0, 0}, radius, 32, false), m);
}

TEST(Materials, M16_a_camera_in_glass_sees_the_whole_sky_at_the_square_of_its_index) {
  Scene scene;
  add_ball(scene, "ball", 1, amber(1 - 0x1p-20F, 1.5F));  // nearly clear: the medium is asked for
  Settings settings = settings_for(16, 16, 64);
  settings.environment.radiance = glm::vec3(1);
  settings.camera = look_at_camera({0.1, 0.2, 0.1}, {0, 0, -1}, {0, 1, 0}, 0.8);
  const MeanAndError radiance = mean_of(film_of(scene, settings));
  EXPECT_TRUE(agrees(radiance, 1.5 * 1.5, 1)) << radiance.mean;
}

TEST(Materials, M16_a_camera_in_a_medium_sees_a_thing_in_it_through_the_medium) {
  for (const bool camera_in_inner : {false, true}) {
    Scene scene;
    add_ball(scene, "water", 8, amber(0.5F, 1));
    add_ball(scene, "core", 1, amber(0.25F, 1));
    Primitive lamp;
    add_quad(lamp, {-0.5F, -0.5F, -0.25F}, {1, 0, 0}, {0, 1, 0});
    add_mesh(scene, "lamp", std::move(lamp), lambert(0, 3));
    const double z = camera_in_inner ? 0.75 : 4;
    const Film film = film_of(scene, settings_for_beam({0.01, 0.02, z}, {0.01, 0.02, 0}, 16));
    // The inner ball's facet is a little nearer than 1 m.
    const double expected = camera_in_inner ? 3 * 0.25 : 3 * std::pow(0.5, 3) * std::pow(0.25, 1.25);
    EXPECT_NEAR(mean_of(film).mean, expected, (camera_in_inner ? 1e-5 : 0.01) * expected);
  }
}

TEST(Materials, M17_a_grey_mirror_seen_straight_on_reflects_its_base_colour) {
  Scene scene;
  Primitive mirror;
  add_quad(mirror, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  add_mesh(scene, "mirror", std::move(mirror), metal(glm::vec3(0.5F), 0));
  Settings settings = settings_for_beam({0.1, 0.2, 4}, {0.1, 0.2, 0}, 16);
  settings.environment.radiance = glm::vec3(1);
  EXPECT_NEAR(mean_of(film_of(scene, settings)).mean, 0.5, 1e-6);
}

TEST(Materials, M18_facing_mirrors_lose_a_tenth_each_time_and_perfect_ones_stop_at_the_depth_limit) {
  const auto radiance = [](float reflectance, std::uint32_t depth) {
    Scene scene;
    Primitive a, b;
    add_quad(a, {-9, -9, 0}, {18, 0, 0}, {0, 18, 0});  // front to +z
    add_quad(b, {-9, -9, 1}, {0, 18, 0}, {18, 0, 0});  // front to -z
    Material m = metal(glm::vec3(reflectance), 0);
    m.emission = glm::vec3(1);
    add_mesh(scene, "a", std::move(a), m);
    add_mesh(scene, "b", std::move(b), m);
    Settings settings = settings_for_beam({0.1, 0.2, 0.5}, {0.1, 0.2, 0}, 4);
    settings.camera.projection = Projection::perspective;  // parallel rays begin outside the scene
    settings.camera.yfov_rad = 1e-5;
    settings.max_depth = depth;
    return mean_of(film_of(scene, settings)).mean;
  };
  EXPECT_NEAR(radiance(0.9F, 11) - radiance(0.9F, 10), 0.348678, 3e-6);
  EXPECT_NEAR(radiance(1, 60), 60, 1e-4);
}

TEST(Materials, snells_window_closes_at_48_6_degrees_for_water) {
  Scene scene;
  Primitive surface;
  add_quad(surface, {-900, 0, 900}, {1800, 0, 0}, {0, 0, -1800});
  add_mesh(scene, "water", std::move(surface), glass(1.333F, 0, true));
  const auto seen_at = [&](double degrees) {
    const double angle = degrees * kPi / 180;
    Settings settings = settings_for(4, 4, 4096);
    settings.camera = look_at_camera({0, -1, 0}, {std::sin(angle), -1 + std::cos(angle), 0}, {0, 0, 1}, 1e-5);
    settings.roulette_depth = 1000;
    settings.environment.radiance = glm::vec3(1);
    settings.max_depth = 2;
    return mean_of(film_of(scene, settings));
  };
  // Through the window the sky; beyond it the mirror image of what is below, which here is the same
  // sky. Radiance is n^2 times as large under water, so the two are told apart.
  const double n = 1.333;
  EXPECT_TRUE(agrees(seen_at(0), n * n * (1 - std::pow((n - 1) / (n + 1), 2)) + std::pow((n - 1) / (n + 1), 2), 3));
  EXPECT_GT(seen_at(48.5).mean, 1.2);
  EXPECT_NEAR(seen_at(48.7).mean, 1, 1e-6);
}

TEST(Materials, M7_roughness_has_no_step_where_mirrors_become_delta) {
  for (const bool pane : {false, true}) {
    const auto mean_at = [&](float roughness) {
      Scene scene;
      Primitive floor, lamp;
      add_quad(floor, {-3, 0, 3}, {6, 0, 0}, {0, 0, -6});
      add_quad(lamp, {-0.5F, 2, -1.5F}, {1, 0, 0}, {0, 0, 1});
      add_mesh(scene, "floor", std::move(floor), pane ? glass(5, roughness, false) : metal(glm::vec3(0.8F), roughness));
      add_mesh(scene, "lamp", std::move(lamp), lambert(0, 5));
      Settings settings = settings_for(24, 24, 1024);
      settings.camera = look_at_camera({0, 1.2, 2.4}, {0, 0, 0}, {0, 1, 0}, 0.8);
      return mean_of(film_of(scene, settings));
    };
    const MeanAndError mirror = mean_at(0);
    for (const float roughness :
         {1e-10F, 1e-5F, 1e-3F, 1.1e-2F, 1.11e-2F, 2e-2F}) {  // the switch is at 2^-6.5 = 0.01105
      const MeanAndError rough = mean_at(roughness);
      EXPECT_NEAR(rough.mean, mirror.mean, 0.01 * mirror.mean + 3 * std::hypot(rough.sigma, mirror.sigma)) << roughness;
      EXPECT_LT(rough.sigma, 0.004 * rough.mean);
    }
  }
}

TEST(Materials, M5_no_surface_gives_back_more_than_it_gets) {
  for (const float roughness : {0.0F, 0.1F, 0.4F, 1.0F}) {
    Material plastic = metal(glm::vec3(1), roughness);
    plastic.metallic = 0;
    for (const Material& m :
         {metal(glm::vec3(1), roughness), plastic, glass(1.5F, roughness, true), glass(1.5F, roughness, false)}) {
      Scene scene;
      add_mesh(scene, "ball", sphere(glm::vec3(0), 1, 16, false, true), m);
      Settings settings = settings_for(24, 24, 64);
      settings.camera = look_at_camera({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.45);
      settings.environment.radiance = glm::vec3(1);
      const MeanAndError mean = mean_of(film_of(scene, settings));
      EXPECT_LT(mean.mean, 1 + 4 * mean.sigma + 1e-4) << roughness;
      EXPECT_GT(mean.mean, 0.2) << roughness;  // what rough microfacets lose among each other
    }
  }
}

// A brushed floor under a lamp, its grooves along x or z.
Film brushed_floor(bool turned, glm::vec4 tangent) {
  Scene scene;
  Primitive floor, lamp;
  add_quad(floor, {-3, 0, 3}, {6, 0, 0}, {0, 0, -6});
  floor.tangents_object.assign(floor.positions_object.size(), tangent);
  add_quad(lamp, {-0.5F, 2, -1.5F}, {1, 0, 0}, {0, 0, 1});
  Material steel = metal(glm::vec3(0.8F), 0.2F);
  steel.anisotropy = 1;
  steel.anisotropy_rotation_rad = turned ? kPi / 2 : 0;
  add_mesh(scene, "floor", std::move(floor), steel);
  add_mesh(scene, "lamp", std::move(lamp), lambert(0, 5));
  Settings settings = settings_for(16, 16, 1024);
  settings.camera = look_at_camera({0, 1.2, 2.4}, {0, 0, 0}, {0, 1, 0}, 0.8);
  return film_of(scene, settings);
}

TEST(Materials, M21_anisotropy_turned_by_90_degrees_is_that_of_turned_tangents) {
  const Film turned = brushed_floor(true, {1, 0, 0, 1}), tangents = brushed_floor(false, {0, 0, -1, 1}),
             other = brushed_floor(false, {1, 0, 0, 1});
  double most = 0, apart = 0;
  for (std::uint32_t y = 0; y < 16; ++y)
    for (std::uint32_t x = 0; x < 16; ++x) {
      const auto sigmas = [&](const Film& b) {
        const double noise = std::sqrt(turned.variance_of_mean(x, y, 0) + b.variance_of_mean(x, y, 0));
        return noise > 0 ? std::abs(turned.mean(x, y, 0) - b.mean(x, y, 0)) / noise : 0.0;
      };
      most = std::max(most, sigmas(tangents));
      apart = std::max(apart, sigmas(other));
    }
  EXPECT_LT(most, 6);  // few samples per replicate: tails are longer than normal ones
  EXPECT_GT(apart, 20);
}

TEST(Materials, a_coated_lamp_shines_the_same_however_its_light_is_found) {
  const auto found_by = [](LightSampling sampling, float clearcoat) {
    Scene scene;
    Primitive floor, lamp;
    add_quad(floor, {-2, 0, 2}, {4, 0, 0}, {0, 0, -4});
    add_quad(lamp, {-1, 0.5F, -1}, {2, 0, 0}, {0, 0, 2});
    add_mesh(scene, "floor", std::move(floor), lambert(0.5F));
    Material shining = lambert(0, 5);
    shining.clearcoat = clearcoat;
    add_mesh(scene, "lamp", std::move(lamp), shining);
    Settings settings = settings_for(16, 16, 1024);
    settings.camera = look_at_camera({0, 0.8, 3}, {0, 0, 0}, {0, 1, 0}, 0.6);
    settings.light_sampling = sampling;
    settings.max_depth = 2;
    return mean_of(film_of(scene, settings));
  };
  const MeanAndError both = found_by(LightSampling::mis, 1), bare = found_by(LightSampling::mis, 0);
  for (const LightSampling sampling : {LightSampling::light, LightSampling::bsdf}) {
    const MeanAndError one = found_by(sampling, 1);
    EXPECT_NEAR(one.mean, both.mean, 4 * std::hypot(one.sigma, both.sigma));
  }
  // A twenty-fifth stays in the coat straight down, all of it at grazing angles.
  EXPECT_LT(both.mean, 0.96 * bare.mean);
  EXPECT_GT(both.mean, 0.7 * bare.mean);
}

Material flint(float dispersion) {
  Material m = glass(1.5F, 0, true);
  m.dispersion = dispersion;
  return m;
}

// Out of a prism by a face tilted by 30 degrees: sin(out) = n sin(30), n = 1.4875, 1.5, 1.5125.
TEST(Materials, a_prism_parts_red_green_and_blue_by_their_indices) {
  const double across[] = {4.5 * std::tan(std::asin(1.4875 / 2) - kPi / 6),
                           4.5 * std::tan(std::asin(1.5 / 2) - kPi / 6),
                           4.5 * std::tan(std::asin(1.5125 / 2) - kPi / 6)};
  for (int first = 0; first < 3;
       ++first) {  // a lamp that begins just before where this channel lands, or after the one before
    Scene scene;
    Primitive entry, exit, lamp;
    add_quad(entry, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    const float s = 0.5F, c = std::sqrt(0.75F);
    add_quad(exit, {-c, -1, -0.5F - s}, {0, 2, 0}, {2 * c, 0, 2 * s});
    const double begins = first == 0 ? across[0] - 0.02 : 0.5 * (across[first - 1] + across[first]);
    add_quad(lamp, {-10, -5, -5}, {float(10 - begins), 0, 0}, {0, 10, 0});
    add_mesh(scene, "entry", std::move(entry), flint(1));
    add_mesh(scene, "exit", std::move(exit), flint(1));
    add_mesh(scene, "lamp", std::move(lamp), lambert(0, 1));
    Settings settings = settings_for_beam({0, 0, 4}, {0, 0, 0}, 4096);
    settings.max_depth = 3;
    const Film film = film_of(scene, settings);
    for (int channel = 0; channel < 3; ++channel) {
      double sum = 0;
      for (std::uint32_t y = 0; y < 4; ++y)
        for (std::uint32_t x = 0; x < 4; ++x) sum += film.mean(x, y, std::uint32_t(channel)) / 16;
      // About 0.96 * 0.93 passes; three channels are chosen in turns, which is noise.
      EXPECT_NEAR(sum, channel >= first ? 0.89 : 0, channel >= first ? 0.04 : 1e-9)
          << channel << ", lamp from " << first;
    }
  }
}

TEST(Materials, glass_that_disperses_neither_makes_nor_loses_light) {
  for (const float roughness : {0.0F, 0.1F}) {
    Scene scene;
    Material m = flint(3);
    m.roughness = roughness;
    add_ball(scene, "ball", 1, m);
    Settings settings = settings_for(24, 24, 256);
    settings.environment.radiance = glm::vec3(1);
    settings.camera = look_at_camera({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.3);
    const MeanAndError radiance = mean_of(film_of(scene, settings));
    EXPECT_TRUE(roughness > 0 ? radiance.mean < 1 + 4 * radiance.sigma && radiance.mean > 0.9 : agrees(radiance, 1, 2))
        << radiance.mean;
  }
}

TEST(Materials, an_unlit_surface_shows_its_colour_and_lights_nothing) {
  Scene scene;
  Primitive floor, sign;
  add_quad(floor, {-3, 0, 3}, {6, 0, 0}, {0, 0, -6});
  add_quad(sign, {-1, 0, -1}, {2, 0, 0}, {0, 2, 0});
  add_mesh(scene, "floor", std::move(floor), lambert(0.8F));
  Material m = lambert({0.2F, 0.5F, 0.9F});
  m.unlit = true;
  add_mesh(scene, "sign", std::move(sign), m);
  Settings settings = settings_for_beam({0.1, 0.9, 3}, {0.1, 0.9, 0}, 16);
  const Film film = film_of(scene, settings);
  EXPECT_EQ(film.mean(1, 1, 0), 0.2F);
  EXPECT_EQ(film.mean(1, 1, 1), 0.5F);
  EXPECT_EQ(film.mean(1, 1, 2), 0.9F);
  settings.camera = beam({0.1, 2, 1}, {0.1, 0, 0.5});
  EXPECT_EQ(mean_of(film_of(scene, settings)).mean, 0);
}

// Radiance inside glass is divided by the square of its index until it leaves. Roulette that went
// by it would end three of five of these paths when they enter, for a variance of about 1. As it
// is, no event ends one before the eighth, and those from there on keep 0.95 of them, q = 1 / 0.95
// times as heavy. With r reflected at every crossing, squares of values inside before event d have
// the mean w(d) = q(d) (r w(d + 1) + 1 - r), and v = q(1) (r + (1 - r) w(2)) outside.
TEST(Glass, roulette_does_not_take_radiance_inside_glass_for_less_than_it_will_be) {
  Scene scene;
  Primitive box;
  add_box(box, {-20, -20, -1}, {20, 20, 1}, false);
  add_mesh(scene, "slab", std::move(box), glass(2.4F, 0, true));
  Settings settings = settings_for(64, 64, 2);  // one sample in each replicate
  settings.camera = beam({0, 0, 3}, {0, 0, 0});
  settings.environment.radiance = {1, 1, 1};
  settings.roulette_depth = 1;
  const Film film = film_of(scene, settings);
  const double r = (1.4 / 3.4) * (1.4 / 3.4);
  const auto q = [](int event) { return event < 8 ? 1.0 : 1 / 0.95; };
  double inside = 1;
  for (int event = 60; event > 1; --event) inside = q(event) * (r * inside + 1 - r);
  const double variance = q(1) * (r + (1 - r) * inside) - 1;
  double sum = 0;
  for (std::uint32_t y = 0; y < 64; ++y)
    for (std::uint32_t x = 0; x < 64; ++x) sum += 2 * film.variance_of_mean(x, y, 0);
  // Half the squared difference of two samples is at most about 0.6, with a deviation of 0.25.
  EXPECT_NEAR(sum / (64 * 64), variance, 4 * 0.25 / 64);
}

}  // namespace
}  // namespace eikon::test
