// SPDX-License-Identifier: Apache-2.0
// Cameras: parallel rays from near and far, lenses that open wide, and panoramas.
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

std::pair<Scene, Settings> ball_from(double distance) {
  Scene scene;
  add_mesh(scene, "ball", sphere({0, 0, 0}, 1, 32, false), lambert(0.5F));
  Settings settings = settings_for(40, 40, 64);
  settings.camera = look_at_camera(glm::normalize(glm::dvec3(3, 2, 5)) * distance, {0, 0, 0}, {0, 1, 0}, 1);
  settings.camera.projection = Projection::orthographic;
  settings.camera.ymag_m = 1.1;
  settings.environment.radiance = glm::vec3(1);
  return {std::move(scene), settings};
}

// A convex body of albedo 1/2 under an even sky has radiance 1/2 everywhere; whatever is amiss near
// the surface shows as rings.
TEST(Camera, G7_a_ball_under_an_even_sky_is_even_from_any_distance) {
  for (const double distance : {10.0, 1e3, 1e5}) {
    const auto [scene, settings] = ball_from(distance);
    const Film film = film_of(scene, settings);
    int inside = 0;
    for (std::uint32_t y = 0; y < 40; ++y)
      for (std::uint32_t x = 0; x < 40; ++x) {
        const double from_middle = std::hypot(x + 0.5 - 20, y + 0.5 - 20) * 2.2 / 40;
        if (from_middle < 0.94) {
          ++inside;
          const double sigma = std::sqrt(film.variance_of_mean(x, y, 0));
          ASSERT_NEAR(film.mean(x, y, 0), 0.5, 4 * sigma + 1e-5) << distance << " m: " << x << "," << y;
        }
        if (from_middle > 1.06) {
          ASSERT_EQ(film.mean(x, y, 0), 1) << distance << " m: " << x << "," << y;
        }
      }
    EXPECT_GT(inside, 800);
  }
}

TEST(Camera, an_orthographic_picture_does_not_depend_on_the_distance) {
  auto [scene, settings] = ball_from(10);
  settings.aovs = {"depth"};
  const Film near = film_of(scene, settings);
  const Film far = film_of(scene, ball_from(1e5).second);
  double difference = 0;
  for (std::uint32_t y = 0; y < 40; ++y)
    for (std::uint32_t x = 0; x < 40; ++x) difference += std::abs(near.mean(x, y, 0) - far.mean(x, y, 0)) / 1600;
  EXPECT_LT(difference, 1e-4);
  // Depth counts from the camera, though rays begin near the scene: 10 m to the middle, less the
  // radius.
  const std::uint32_t sum = near.channel_index("depth.Z").value();
  EXPECT_NEAR(near.mean(20, 20, sum), 9, 0.02);
}

/// A wall at z = -distance whose left half shines, seen by a lens in focus elsewhere: 32 pixels to
/// the metre at 1 m.
std::pair<Scene, Settings> lit_half(double distance, const Lens& lens) {
  Scene scene;
  Primitive half;
  const float far = 100, z = -static_cast<float>(distance);
  add_quad(half, {-far, -far, z}, {far, 0, 0}, {0, 2 * far, 0});
  add_mesh(scene, "half", std::move(half), lambert(glm::vec3(0), glm::vec3(1)));
  Settings settings = settings_for(32, 8, 1024);
  settings.light_sampling = LightSampling::bsdf;
  settings.camera = look_at_camera({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 2 * std::atan(0.5 * 8 / 32));
  settings.camera.lens = lens;
  return {std::move(scene), settings};
}

/// Share of a disc about 0 that lies left of x, both in the disc's radii.
double disc_left_of(double x) {
  if (x <= -1) return 0;
  if (x >= 1) return 1;
  return 0.5 + (std::asin(x) + x * std::sqrt(1 - x * x)) / std::numbers::pi;
}

// What a lens of radius R, in focus at f, makes of a point at d is a disc of radius R |1/f - 1/d|
// at 1 m.
TEST(Camera, a_lens_blurs_an_edge_by_its_circle_of_confusion) {
  for (const auto& [distance, focus] : {std::pair{4.0, 2.0}, std::pair{1.0, 2.0}, std::pair{3.0, 1e6}}) {
    const auto [scene, settings] = lit_half(distance, {.radius_m = 0.7, .focus_distance_m = focus});
    const Film film = film_of(scene, settings);
    const double blur = 0.7 * std::abs(1 / focus - 1 / distance);
    for (std::uint32_t x = 0; x < 32; ++x) {
      double expected = 0, mean = 0, variance = 0;
      for (int i = 0; i < 64; ++i) expected += disc_left_of(-((x + (i + 0.5) / 64) - 16) / 32 / blur) / 64;
      for (std::uint32_t y = 0; y < 8; ++y)
        mean += film.mean(x, y, 0) / 8, variance += film.variance_of_mean(x, y, 0) / 64;
      EXPECT_NEAR(mean, expected, 4.5 * std::sqrt(variance) + 1e-3)
          << distance << " m, focus " << focus << " m, x " << x;
    }
  }
}

TEST(Camera, a_lens_leaves_what_is_in_focus_sharp) {
  const auto [scene, settings] = lit_half(2, {.radius_m = 0.7, .focus_distance_m = 2});
  const Film film = film_of(scene, settings);
  for (std::uint32_t y = 0; y < 8; ++y)
    for (std::uint32_t x = 0; x < 32; ++x) {
      const double expected = x < 16 ? 1 : 0;
      // Roundings at the edge itself.
      EXPECT_NEAR(film.mean(x, y, 0), expected, x == 15 || x == 16 ? 1e-2 : 0) << x << "," << y;
    }
}

TEST(Camera, a_lens_by_its_f_number_opens_as_wide_as_its_focal_length_says) {
  Camera camera;
  EXPECT_EQ(lens_radius_m(camera), 0);
  camera.yfov_rad = 2 * std::atan(12.0 / 50);  // of a lens of 50 mm
  camera.lens = Lens{.f_number = 2};
  EXPECT_NEAR(lens_radius_m(camera), 0.0125, 1e-15);
  camera.lens->sensor_height_m *= 2;
  EXPECT_NEAR(lens_radius_m(camera), 0.025, 1e-15);
  camera.projection = Projection::panorama;
  EXPECT_EQ(lens_radius_m(camera), 0);
}

// A sky as it is read: texel for texel, where its interpolation leaves the middles alone.
TEST(Camera, a_panorama_of_the_sky_is_the_sky) {
  Scene scene;
  Primitive speck;
  add_quad(speck, {0, 50, 0}, {1e-6F, 0, 0}, {0, 0, 1e-6F});
  add_mesh(scene, "speck", std::move(speck), lambert(0.5F));
  auto map = std::make_shared<EnvironmentMap>();
  map->width = 16, map->height = 8;
  for (std::uint32_t y = 0; y < 8; ++y)
    for (std::uint32_t x = 0; x < 16; ++x) {
      // Linear in each direction about most texels, so that the mean over one is its middle's; and
      // told apart everywhere.
      const float along = static_cast<float>(x < 8 ? x : 15 - x);
      map->radiance.emplace_back(1 + along, 1 + static_cast<float>(y), x < 8 ? 2 : 1);
    }
  Settings settings = settings_for(16, 8, 256);
  settings.camera = look_at_camera({1, 2, 3}, {1, 2, 2}, {0, 1, 0}, 1);
  settings.camera.projection = Projection::panorama;
  settings.environment.map = map;
  const Film film = film_of(scene, settings);
  for (std::uint32_t y = 1; y < 7; ++y)
    for (const std::uint32_t x : {1U, 3U, 5U, 6U, 9U, 11U, 14U})
      for (std::uint32_t c = 0; c < 3; ++c)
        EXPECT_NEAR(film.mean(x, y, c), map->radiance[y * 16 + x][int(c)], 2e-2) << x << "," << y << "," << c;
  // Turned by a quarter to the left, the picture moves a quarter to the right.
  settings.camera = look_at_camera({1, 2, 3}, {0, 2, 3}, {0, 1, 0}, 1);
  settings.camera.projection = Projection::panorama;
  const Film turned = film_of(scene, settings);
  for (std::uint32_t y = 0; y < 8; ++y)
    for (std::uint32_t x = 0; x < 16; ++x)
      EXPECT_NEAR(turned.mean((x + 4) % 16, y, 0), film.mean(x, y, 0), 5e-2) << x << "," << y;
}

}  // namespace
}  // namespace eikon::test
