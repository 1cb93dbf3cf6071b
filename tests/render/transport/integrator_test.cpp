// SPDX-License-Identifier: Apache-2.0
// What else than a whole path tracer the settings make: against the path tracer, and closed forms.
#include "render/scene_builder.h"
#include "render/ways_to_shade.h"

namespace eikon::test {
namespace {

Material polished(float metallic) {
  Material m;
  m.base_color = glm::vec3(0.9F);
  m.metallic = metallic;
  m.roughness = 0;
  return m;
}

Material clear_glass() {
  Material m = polished(0);
  m.transmission = 1;
  m.solid = true;
  return m;
}

/// A diffuse floor seen directly, in a mirror, and through a ball of glass, lit by a bulb that no
/// ray can meet.
std::pair<Scene, Settings> still_life(float albedo) {
  Scene scene;
  Primitive floor, mirror;
  add_quad(floor, {-4, 0, 4}, {8, 0, 0}, {0, 0, -8});
  add_quad(mirror, {-3, 0, -2}, {6, 0, 0}, {0, 3, -0.5F});
  add_mesh(scene, "floor", std::move(floor), lambert(albedo));
  add_mesh(scene, "mirror", std::move(mirror), polished(1));
  add_mesh(scene, "ball", sphere({0.6F, 0.7F, 0.3F}, 0.6F, 16, false, true), clear_glass());
  PunctualLight bulb;
  bulb.position = {-1, 3, 1};
  bulb.intensity = glm::vec3(10);
  scene.lights.push_back(bulb);
  Settings settings = settings_for(40, 30, 16);
  settings.camera = look_at_camera({0, 1.6, 4.5}, {0, 0.6, 0}, {0, 1, 0}, 0.7);
  settings.light_sampling = LightSampling::light;
  settings.max_depth = 24;
  settings.roulette_depth = 100;
  return {std::move(scene), settings};
}

TEST(Whitted, is_the_path_of_one_diffuse_vertex_seen_through_mirrors_and_glass) {
  // Light that met the floor k times has the factor albedo^k: of so dark a floor only k = 1 is
  // left, and both integrators follow the same rays there.
  constexpr float kDark = 0x1p-14F;
  auto [scene, settings] = still_life(kDark);
  const Film path = film_of(scene, settings);
  settings.integrator = Integrator::whitted;
  const Film whitted = film_of(scene, settings);
  int lit = 0;
  for (std::uint32_t i = 0; i < 40 * 30; ++i) {
    const double expected = path.mean(i % 40, i / 40, 0), found = whitted.mean(i % 40, i / 40, 0);
    // Where only light is that met the floor twice, the path tracer sees kDark^2 of some radiance
    // below 10.
    ASSERT_NEAR(found, expected, 2e-3 * expected + 10 * double(kDark) * double(kDark)) << i % 40 << ',' << i / 40;
    lit += found > 0 ? 1 : 0;
  }
  EXPECT_GT(lit, 500);  // the floor fills about half of the picture
}

TEST(Whitted, sees_nothing_twice_diffuse_and_glass_only_with_two_edges_more) {
  auto [scene, settings] = still_life(0.5F);
  settings.integrator = Integrator::whitted;
  const auto mean_with = [&, &scene = scene, &settings = settings](std::uint32_t edges) {
    settings.max_depth = edges;
    return mean_of(film_of(scene, settings)).mean;
  };
  const double direct = mean_with(2), once = mean_with(3), twice = mean_with(4), often = mean_with(12);
  // The same random numbers: what is brighter is so by the edge that came in addition.
  EXPECT_GT(once, direct * 1.002);  // by the mirror
  EXPECT_GT(twice, once * 1.002);   // by the glass, which takes two refractions
  EXPECT_LT(often, twice * 1.05);
  settings.integrator = Integrator::path;
  EXPECT_GT(mean_with(12), often * 1.001);  // the floor lights itself by the mirror
}

TEST(Roulette, of_one_probability_changes_no_mean) {
  for (const float survival : {0.9F, 0.75F}) {
    Settings settings = settings_for(24, 24, 256);
    settings.roulette_survival = survival;
    settings.roulette_depth = 2;
    // Throughput is multiplied by .5^2 / survival in the mean square: the variance is bounded.
    EXPECT_TRUE(agrees(mean_of(film_of(furnace(0.5F, 1), settings)), 2, 2)) << survival;
  }
}

TEST(Roulette, of_probability_one_is_none) {
  auto [scene, settings] = room(16, 16, 4);
  settings.max_depth = 6;
  settings.roulette_depth = 1000;
  const Film without = film_of(scene, settings);
  settings.roulette_survival = 1;
  settings.roulette_depth = 2;
  EXPECT_TRUE(same_bits(without, film_of(scene, settings)));
}

/// A floor under many bulbs, of which each point sees some near and most far.
std::pair<Scene, Settings> bulbs(std::uint32_t count) {
  Scene scene;
  Primitive floor;
  add_quad(floor, {-4, 0, 4}, {8, 0, 0}, {0, 0, -8});
  add_mesh(scene, "floor", std::move(floor), lambert({0.8F, 0.5F, 0.3F}));
  for (std::uint32_t i = 0; i < count; ++i) {
    PunctualLight bulb;
    bulb.position = {-3 + 6 * std::fmod(0.618034 * i, 1.0), 0.7 + 0.3 * (i % 4), -3 + 6 * (i + 0.5) / count};
    bulb.intensity = glm::vec3(float(1 + i % 3), 1, float(1 + i % 5));
    scene.lights.push_back(bulb);
  }
  Settings settings = settings_for(20, 20, 2);
  settings.camera = look_at_camera({0, 6, 0}, {0, 0, 0}, {0, 0, -1}, 0.9);
  settings.max_depth = 2;
  return {std::move(scene), settings};
}

/// Mean over the pixels of the variance of their means.
double noise_of(const Film& film) {
  double sum = 0;
  const Crop& crop = film.layout().crop;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x) sum += film.variance_of_mean(x, y, 0);
  return sum / double(crop.pixel_count());
}

TEST(LightSamples, of_many_lights_divide_the_variance_and_keep_the_mean) {
  auto [scene, settings] = bulbs(64);
  const Film one = film_of(scene, settings);
  for (const std::uint32_t count : {2U, 5U, 16U}) {
    settings.light_samples = count;
    settings.seed = count;
    const Film several = film_of(scene, settings);
    // The variance of 400 pixels, a degree of freedom each, is known to about a tenth; samples of
    // one vertex share out the lights, which makes it fall faster than 1 / N rather than more
    // slowly.
    const double ratio = noise_of(one) / noise_of(several);
    EXPECT_GT(ratio, 0.75 * count) << count;
    EXPECT_LT(ratio, 6.0 * count) << count;
    settings.sample_end = 128;
    Settings single = settings;
    single.light_samples = 1;
    single.seed = 99;
    EXPECT_TRUE(agree(mean_of(film_of(scene, settings)), mean_of(film_of(scene, single)), 3)) << count;
    settings.sample_end = 2;
  }
}

TEST(LightSamples, beside_scattered_rays_keep_the_mean_of_lamps_and_sky) {
  auto [scene, settings] = room(24, 24, 256);
  settings.max_depth = 2;
  Material& ball = scene.materials[scene.meshes[scene.nodes[3].mesh].primitives[0].material];
  ball.metallic = 1, ball.roughness = 0.2F, ball.specular = 1;  // which rays find light better than light finds rays
  const MeanAndError expected = mean_of(film_of(scene, settings));
  for (const LightSampling sampling : {LightSampling::mis, LightSampling::light})
    for (const std::uint32_t count : {3U, 8U}) {
      settings.seed = 7 + count;
      settings.light_sampling = sampling;
      settings.light_samples = count;
      EXPECT_TRUE(agree(mean_of(film_of(scene, settings)), expected, 4)) << count;
    }
}

TEST(LightSamples, have_the_same_bits_on_every_way_to_trace) {
  auto [scene, settings] = room(17, 13, 3);
  settings.max_depth = 2;
  settings.light_samples = 3;
  scene.materials[0].alpha_mode = AlphaMode::blend;  // decided for each shadow ray
  scene.materials[0].opacity = 0.6F;
  const Film expected = film_of(scene, settings);
  for (const Execution& execution : ways_to_shade())
    EXPECT_TRUE(same_film(film_of(scene, settings, execution), expected)) << describe(execution);
}

Settings raycast(Settings settings) {
  settings.integrator = Integrator::raycast;
  settings.light_sampling = LightSampling::light;
  settings.max_depth = 2;
  return settings;
}

/// One point of the floor, seen from afar through a keyhole: a pixel of some 3e-5 m.
Settings keyhole(Settings settings, const glm::dvec3& at, const glm::dvec3& eye) {
  settings.camera = look_at_camera(eye, at, {0, 1, 0}, 1e-5);
  settings.width = settings.height = 1;
  settings.crop = {0, 0, 1, 1};
  return raycast(settings);
}

TEST(Raycast, irradiance_of_a_bulb_is_its_flux_over_the_sphere_times_the_cosine) {
  auto [scene, settings] = bulbs(1);
  constexpr double kFlux = 50;  // W
  const glm::dvec3 bulb(0.5, 1.25, -0.25);
  scene.lights[0].position = bulb;
  scene.lights[0].intensity = glm::vec3(float(kFlux / (4 * std::numbers::pi)));
  for (int i = 0; i < 12; ++i) {
    const glm::dvec3 at(-3 + 0.5 * i, 0, 2 - 0.4 * i), to = bulb - at;
    const RenderOutput output = output_of(scene, keyhole(settings, at, at + glm::dvec3(0.3, 3, 1)));
    EXPECT_EQ(output.report.rays.scattered, 0U);
    EXPECT_EQ(output.report.rays.shadow, output.report.rays.camera);
    const double r2 = glm::dot(to, to), irradiance = kFlux / (4 * std::numbers::pi * r2) * (to.y / std::sqrt(r2));
    // E goes as r^-3 at most, and the pixel reaches 1.6e-5 m from its middle: 3 / 1.25 * 1.6e-5.
    const double expected = irradiance * double(0.8F) / std::numbers::pi;
    EXPECT_NEAR(output.film.mean(0, 0, 0), expected, 5e-5 * expected) << i;
  }
}

TEST(Raycast, adds_up_all_bulbs_without_noise_and_samples_them_when_they_are_many) {
  auto [scene, settings] = bulbs(16);
  const Film all = film_of(scene, raycast(settings));
  std::vector<double> sum(400);
  for (const PunctualLight& bulb : std::vector<PunctualLight>(scene.lights)) {
    scene.lights = {bulb};
    const Film one = film_of(scene, raycast(settings));
    for (std::uint32_t i = 0; i < 400; ++i) sum[i] += one.mean(i % 20, i / 20, 2);
  }
  for (std::uint32_t i = 0; i < 400; ++i) EXPECT_NEAR(all.mean(i % 20, i / 20, 2), sum[i], 1e-5 * sum[i]) << i;

  auto [many, with] = bulbs(17);
  with.sample_end = 256;
  const Film sampled = film_of(many, raycast(with));
  EXPECT_TRUE(agree(mean_of(sampled), mean_of(film_of(many, with)), 1));
}

TEST(Raycast, of_lambert_surfaces_is_direct_light_of_lamps_and_sky) {
  auto [scene, settings] = room(24, 24, 256);
  settings.max_depth = 2;
  const Film direct = film_of(scene, settings);
  settings.seed = 1;
  const Film cast = film_of(scene, raycast(settings));
  EXPECT_TRUE(agree(mean_of(cast), mean_of(direct), 2));
  EXPECT_TRUE(agree(mean_of(cast, 2), mean_of(direct, 2), 2));
  settings = raycast(settings);
  settings.sample_end = 3;
  const Film expected = film_of(scene, settings);
  for (const Execution& execution : ways_to_shade())
    EXPECT_TRUE(same_film(film_of(scene, settings, execution), expected)) << describe(execution);
}

TEST(Raycast, highlights_are_blinns_of_the_material_or_of_its_roughness) {
  struct Case {
    Material material;
    double base, highlight, shininess;
  };
  std::vector<Case> cases;
  Material phong = lambert(0.5F);
  phong.lobe = Lobe::phong;
  phong.phong_shininess = 40;
  phong.phong_specular = glm::vec3(0.3F);
  cases.push_back({phong, 0.5, 0.3, 40});
  for (const float metallic : {0.0F, 1.0F, 0.5F}) {
    Material m = lambert(0.5F);
    m.metallic = metallic;
    m.specular = 1;
    m.roughness = 0.4F;
    const double alpha = 0.4 * 0.4;
    cases.push_back({m, 0.5 * (1 - metallic), 0.04 * (1 - metallic) + 0.5 * metallic, 2 / (alpha * alpha) - 2});
  }
  Material glass = clear_glass();
  cases.push_back({glass, 0.9, 0.04, 65536});
  for (const Case& c : cases) {
    auto [scene, settings] = bulbs(1);
    scene.materials[0] = c.material;
    scene.lights[0].position = {0.1, 2, -2};
    scene.lights[0].intensity = glm::vec3(10);
    const glm::dvec3 eye(0, 2, 2.2);
    const Film film = film_of(scene, keyhole(settings, glm::dvec3(0), eye));
    const glm::dvec3 to = scene.lights[0].position, wi = glm::normalize(to), wo = glm::normalize(eye);
    const double cos_h = glm::normalize(wi + wo).y, n = c.shininess;
    const double scale = (n + 2) * (n + 4) / (8 * std::numbers::pi * (std::exp2(-n / 2) + n));
    const double f = c.base * (1 - c.highlight) / std::numbers::pi + c.highlight * scale * std::pow(cos_h, n);
    const double expected = f * wi.y * 10 / glm::dot(to, to);
    EXPECT_NEAR(film.mean(0, 0, 0), expected, 1e-3 * expected) << c.shininess << ' ' << c.base;
  }
}

}  // namespace
}  // namespace eikon::test
