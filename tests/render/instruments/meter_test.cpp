// SPDX-License-Identifier: Apache-2.0
// The light meter against radiometry's closed forms. Judged at significance 1 % per test.
#include "instruments/meter.h"

#include "pack/origin.h"
#include "render/materials/glass_builder.h"
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

Reading measured(Scene scene, const Meter& meter, const glm::vec3& sky = glm::vec3(0), std::uint64_t spp = 64) {
  Settings settings = settings_for(16, 16, spp);
  settings.environment.radiance = sky;
  aim(meter, scene, settings);
  return read(meter, film_of(scene, settings));
}

Meter facing(const glm::dvec3& at, const glm::dvec3& normal) {
  return {.quantity = Meter::Quantity::irradiance, .at = at, .direction = glm::normalize(normal)};
}

Scene bulb(float intensity) {
  Scene scene;
  PunctualLight light;
  light.position = {0, 0, 0};
  light.intensity = glm::vec3(intensity);
  scene.lights.push_back(light);
  return scene;
}

TEST(Meter, of_a_bulb_follows_the_inverse_square_and_the_cosine) {
  const double flux = 4 * kPi * 5;
  for (const double r : {0.5, 1.0, 3.0, 100.0})
    for (const double degrees : {0.0, 30.0, 60.0, 85.0}) {
      const double angle = degrees * kPi / 180;
      const Reading reading = measured(bulb(5), facing({0, 0, -r}, {std::sin(angle), 0, std::cos(angle)}));
      const double expected = flux / (4 * kPi * r * r) * std::cos(angle);
      EXPECT_NEAR(reading.value.y, expected, 2e-3 * expected) << r << " m, " << degrees << " degrees";
      EXPECT_LT(reading.sigma.y, 1e-3 * expected);
    }
  EXPECT_EQ(measured(bulb(5), facing({0, 0, -1}, {0, 0, -1})).value.y, 0);  // turned away
}

TEST(Meter, under_an_even_sky_is_pi_times_its_radiance_however_it_is_turned) {
  for (const glm::dvec3& normal : {glm::dvec3(0, 1, 0), glm::dvec3(1, -2, 3), glm::dvec3(-1, 0, 0)}) {
    const Reading reading = measured(Scene{}, facing({3, -2, 7}, normal), {1, 0.5F, 2});
    EXPECT_NEAR(reading.value.x, kPi, 1e-4);
    EXPECT_NEAR(reading.value.y, 0.5 * kPi, 1e-4);
    EXPECT_NEAR(reading.value.z, 2 * kPi, 1e-4);
  }
}

TEST(Meter, L1_a_square_lamp_gives_a_floor_the_irradiance_of_its_closed_form) {
  // On the surface itself, and in the air; the floor below does not matter to what falls on it.
  for (const double height : {0.0, 1e-3}) {
    const Reading reading = measured(square_light(), facing({0, height, 0}, {0, 1, 0}), glm::vec3(0), 256);
    const double bound = 2.58 * reading.sigma.y + 4e-3 * height / 1e-3 + 2e-4;  // dE / E is about 2 dh / h above
    EXPECT_NEAR(reading.value.y, kSquareLightIrradiance, bound) << height;
    EXPECT_LT(reading.sigma.y, 2e-3);
  }
  EXPECT_EQ(measured(square_light(), facing({0, 0, 0}, {0, -1, 0})).value.y, 0);  // below the floor
}

TEST(Meter, reads_the_same_far_from_the_origin) {
  const glm::dvec3 away(0x1p18, -0x1p19, 0x1p17);
  const Scene near = square_light(), far = seen_from_origin(near, -away);
  for (const auto quantity : {Meter::Quantity::irradiance, Meter::Quantity::radiance}) {
    Meter here = facing({0, 0, 0}, {0, 1, 0}), there = facing(away, {0, 1, 0});
    here.quantity = there.quantity = quantity;
    const Reading expected = measured(near, here), reading = measured(far, there);
    EXPECT_GT(expected.value.y, 0);
    EXPECT_NEAR(reading.value.y, expected.value.y,
                2.58 * std::hypot(reading.sigma.y, expected.sigma.y) + 1e-5 * expected.value.y);
    EXPECT_LT(reading.sigma.y, 1.5 * expected.sigma.y + 1e-5 * expected.value.y);
  }
}

TEST(Meter, reads_the_same_in_a_large_scene) {
  // What lies far away does not matter; a receiver whose side followed the size of the scene read
  // up to 14 % too much and 42 % too little.
  for (const float away : {10.0F, 1e3F, 1e4F, 1e5F}) {
    Scene scene = bulb(2);
    scene.lights[0].position = {0, 2, 0};
    for (const float x : {-away, away}) {
      Primitive wall;
      add_quad(wall, {x, -1, -1}, {0, 2, 0}, {0, 0, 2});
      add_mesh(scene, "wall", std::move(wall), lambert(0.5F));
    }
    const double expected = 2 / (1.999 * 1.999);
    EXPECT_NEAR(measured(std::move(scene), facing({0, 0.001, 0}, {0, 1, 0})).value.y, expected, 5e-4 * expected)
        << away;
  }
}

TEST(Meter, lies_under_a_plate_close_above_a_wide_ground) {
  Scene scene = bulb(2);
  scene.lights[0].position = {0, 2, 0};
  Primitive ground, plate;
  add_quad(ground, {-1e3F, 0, -1e3F}, {0, 0, 2e3F}, {2e3F, 0, 0});
  add_quad(plate, {-0.5F, 0.01F, -0.5F}, {0, 0, 1}, {1, 0, 0});
  add_mesh(scene, "ground", std::move(ground), lambert(0.5F));
  const Meter meter = facing({0, 0.001, 0}, {0, 1, 0});
  EXPECT_NEAR(measured(scene, meter).value.y, 0.5, 2e-3);
  add_mesh(scene, "plate", std::move(plate), lambert(0.5F));
  Settings settings = settings_for(16, 16, 16);
  settings.max_depth = 1;
  aim(meter, scene, settings);
  EXPECT_EQ(read(meter, film_of(scene, settings)).value.y, 0);
}

TEST(Meter, traces_no_light_paths) {
  Scene scene = bulb(5);
  add_mesh(scene, "ball", sphere({0, 2, 0}, 0.5F, 8, false, true), glass(1.5F, 0, true));
  Settings settings = settings_for(16, 16, 4);
  settings.light_path_count = 16;
  aim(facing({0, 0, -1}, {0, 0, 1}), scene, settings);
  EXPECT_TRUE(film_of(scene, settings).light_paths().empty()) << "one that met the receiver would outshine all light";
}

TEST(Meter, is_as_uncertain_as_it_says) {
  // Light comes back from walls. Of 60 readings with seeds of their own, 2.58 standard errors hold
  // all but 1 %.
  int outside = 0;
  double spread2 = 0, claimed2 = 0;
  const double expected = kPi * 0.5 / (1 - 0.5);  // a furnace: what is emitted and reflected is the same everywhere
  for (std::uint32_t seed = 0; seed < 60; ++seed) {
    Scene scene = furnace(0.5F, 0.5F);
    Settings settings = settings_for(16, 16, 4);
    settings.seed = seed;
    const Meter meter = facing({0.2, 0.1, -0.3}, {1, 2, -1});
    aim(meter, scene, settings);
    const Reading reading = read(meter, film_of(scene, settings));
    const double off = reading.value.y - expected;
    outside += std::abs(off) > 2.58 * reading.sigma.y ? 1 : 0;
    spread2 += off * off / 60;
    claimed2 += reading.sigma.y * reading.sigma.y / 60;
  }
  EXPECT_LE(outside, 4);  // of a binomial of 60 and 1 %: more than 4 has a chance of 4e-4
  EXPECT_LT(std::sqrt(spread2 / claimed2), 1.3);
  EXPECT_GT(claimed2, 0);
}

TEST(Meter, radiance_along_a_ray_is_that_of_what_it_meets_at_any_distance) {
  for (const double distance : {0.01, 1.0, 1e4}) {
    Scene scene;
    Primitive wall;
    add_quad(wall, {-1e5F, -1e5F, 0}, {2e5F, 0, 0}, {0, 2e5F, 0});
    add_mesh(scene, "wall", std::move(wall), lambert({0, 0, 0}, {3, 2, 1}));
    const Meter meter{.quantity = Meter::Quantity::radiance, .at = {1, 2, distance}, .direction = {0, 0, -1}};
    const Reading reading = measured(std::move(scene), meter, glm::vec3(0), 1);
    EXPECT_FLOAT_EQ(float(reading.value.x), 3) << distance;
    EXPECT_FLOAT_EQ(float(reading.value.y), 2);
    EXPECT_FLOAT_EQ(float(reading.value.z), 1);
    EXPECT_EQ(reading.sigma.x, 0);
  }
}

TEST(Meter, between_two_squares_has_their_form_factor) {
  // Two parallel unit squares, one apart: F = 0.199825 [Howell, A Catalog of Radiation Heat
  // Transfer Configuration Factors, C-11]. E of one whose opposite has radiance 1 is pi times the
  // factor of each point: its mean over a grid of Gauss-Legendre points.
  const double nodes[] = {0.5 - 0.5 * std::sqrt(0.6), 0.5, 0.5 + 0.5 * std::sqrt(0.6)};
  const double weights[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  double factor = 0, variance = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      Scene scene;
      Primitive lamp;
      add_quad(lamp, {-0.5F, 1, -0.5F}, {1, 0, 0}, {0, 0, 1});  // emits downwards
      add_mesh(scene, "lamp", std::move(lamp), lambert(0, 1));
      const Reading reading = measured(std::move(scene), facing({nodes[i] - 0.5, 0, nodes[j] - 0.5}, {0, 1, 0}));
      const double weight = weights[i] * weights[j] / kPi;
      factor += weight * reading.value.y;
      variance += std::pow(weight * reading.sigma.y, 2);
    }
  EXPECT_NEAR(factor, 0.199825, 2.58 * std::sqrt(variance) + 1e-4);  // 1e-4: of the nine points' quadrature
}

}  // namespace
}  // namespace eikon::test
