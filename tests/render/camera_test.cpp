// SPDX-License-Identifier: Apache-2.0
// Orthographic cameras, from near and far.
#include "render/scene_builder.h"

namespace eikon::testing {
namespace {

std::pair<Scene, Settings> ball_from(double distance) {
  Scene scene;
  add_mesh(scene, "ball", sphere({0, 0, 0}, 1, 32, false), lambert(0.5F));
  Settings settings = settings_for(40, 40, 64);
  settings.camera = look_at_camera(glm::normalize(glm::dvec3(3, 2, 5)) * distance, {0, 0, 0}, {0, 1, 0}, 1);
  settings.camera.orthographic = true;
  settings.camera.ymag_m = 1.1;
  settings.environment.radiance = glm::vec3(1);
  return {std::move(scene), settings};
}

// A convex body of albedo 1/2 under an even sky has radiance 1/2 everywhere; whatever is amiss near the surface shows as rings.
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
  // Depth counts from the camera, though rays begin near the scene: 10 m to the middle, less the radius.
  const std::uint32_t sum = near.channel_index("depth.sum").value();
  EXPECT_NEAR(near.mean(20, 20, sum), 9, 0.02);
}

}  // namespace
}  // namespace eikon::testing
