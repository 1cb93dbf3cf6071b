// SPDX-License-Identifier: Apache-2.0
// What pixels weigh, against the integrals of the filters, and what a transparent picture leaves
// out.
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

constexpr const char* kPositive[] = {"box", "box:2.5", "triangle", "gaussian", "blackman-harris"};

/// Share of the filter at distances below `x` from the pixel's middle, signed: 0 to the left of it,
/// 1 to the right.
double share_below(const PixelFilter& filter, double x) {
  const double r = filter.width / 2, end = std::clamp(x, -r, r);
  constexpr int kSteps = 20000;
  double below = 0, all = 0;
  for (int i = 0; i < kSteps; ++i) {
    below += filter(-r + (end + r) * (i + 0.5) / kSteps) * (end + r);
    all += filter(-r + 2 * r * (i + 0.5) / kSteps) * 2 * r;
  }
  return below / all;
}

/// An orthographic camera that sees pixels of 1 m; the film's upper left corner lies at the origin,
/// and y goes down.
Settings flat_settings(std::uint32_t width, std::uint32_t height, std::uint64_t spp) {
  Settings settings = settings_for(width, height, spp);
  settings.camera.projection = Projection::orthographic;
  settings.camera.ymag_m = 0.5 * height;
  settings.camera.world_from_camera[3] = glm::dvec4(0.5 * width, -0.5 * height, 5, 1);
  return settings;
}

// A corner of a lamp that covers all to the left of x and above y, which lie at no special place.
TEST(PixelFilter, a_corner_of_light_is_the_integral_of_the_filter) {
  constexpr double x_edge = 4.3, y_edge = 3.85;
  Scene scene;
  Primitive lamp;
  add_quad(lamp, {-100, float(-y_edge), 0}, {100 + float(x_edge), 0, 0}, {0, 100, 0});
  add_mesh(scene, "lamp", std::move(lamp), lambert(0, 1));
  for (const char* name : {"box", "box:2.5", "triangle", "gaussian", "mitchell", "blackman-harris"}) {
    Settings settings = flat_settings(9, 8, 1 << 14);
    settings.filter = parse_filter(name);
    settings.replicate_bits = 6;  // 63 degrees of freedom for each pixel's error
    const Film film = film_of(scene, settings);
    for (std::uint32_t y = 0; y < 8; ++y)
      for (std::uint32_t x = 0; x < 9; ++x) {
        const double expected =
            share_below(settings.filter, x_edge - (x + 0.5)) * share_below(settings.filter, y_edge - (y + 0.5));
        const double sigma = std::sqrt(film.variance_of_mean(x, y, 0));
        // Student's quantile with 63 degrees of freedom exceeds the normal one by a tenth this far
        // out. The 256 points of a replicate are a net: a share much smaller than one of them may
        // be in none, and then the spread says 0.
        EXPECT_NEAR(film.mean(x, y, 0), expected, 1.1 * z_bound(6 * 72) * sigma + 5e-4) << name << " " << x << "," << y;
        EXPECT_LT(sigma, 2e-3);
      }
  }
}

TEST(PixelFilter, N11_a_constant_scene_is_constant) {
  const std::pair<std::uint32_t, std::uint32_t> sizes[] = {{1, 1}, {1, 16384}, {16384, 1}, {13, 7}};
  for (const auto& [width, height] : sizes) {
    Settings settings = settings_for(width, height, 4);
    settings.environment.radiance = glm::vec3(1);
    for (const char* name : kPositive) {
      settings.filter = parse_filter(name);
      const Film film = film_of(Scene{}, settings);
      for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) ASSERT_NEAR(film.mean(x, y, 1), 1, 1e-6) << name;
    }
  }
  // With negative weights it is so in the mean alone.
  Settings settings = settings_for(64, 64, 256);
  settings.environment.radiance = glm::vec3(1);
  settings.filter = parse_filter("mitchell");
  EXPECT_TRUE(agrees(mean_of(film_of(Scene{}, settings)), 1, 1));
}

TEST(Transparent, a_is_the_share_that_hits_and_the_rest_is_the_environment) {
  auto [scene, settings] = room(33, 27, 16);
  for (const char* filter : {"box", "gaussian"}) {
    settings.filter = parse_filter(filter);
    settings.transparent = false;
    const Film opaque = film_of(scene, settings);
    settings.transparent = true;
    const Film cut_out = film_of(scene, settings);
    const std::uint32_t alpha = cut_out.channel_index("A").value();
    int edges = 0, holes = 0;
    for (std::uint32_t y = 0; y < 27; ++y)
      for (std::uint32_t x = 0; x < 33; ++x) {
        const double a = cut_out.mean(x, y, alpha);
        edges += a > 0 && a < 1 ? 1 : 0;
        holes += a == 0 ? 1 : 0;
        for (std::uint32_t c = 0; c < 3; ++c) {
          // The same samples: to the bit, but for the float that holds the radiance of the sky.
          const double sky = double(settings.environment.radiance[int(c)]);
          ASSERT_NEAR(opaque.mean(x, y, c), cut_out.mean(x, y, c) + (1 - a) * sky, 1e-12) << x << "," << y;
          if (a == 0) {
            ASSERT_EQ(cut_out.mean(x, y, c), 0);
          }
        }
      }
    EXPECT_GT(edges, 20);
    EXPECT_GT(holes, 50);
  }
}

// Its weights are those of the radiance: a lamp of radiance 1 on nothing has R = A to the bit.
TEST(Transparent, a_is_weighted_by_the_filter_as_radiance_is) {
  Scene scene;
  Primitive lamp;
  add_quad(lamp, {2.4F, -5.3F, 0}, {3, 0, 0}, {0, 3, 0});
  add_mesh(scene, "lamp", std::move(lamp), lambert(0, 1));
  Settings settings = flat_settings(8, 8, 32);
  settings.filter = parse_filter("mitchell");
  settings.transparent = true;
  const Film film = film_of(scene, settings);
  const std::uint32_t alpha = film.channel_index("A").value();
  bool beyond = false;
  for (std::uint32_t y = 0; y < 8; ++y)
    for (std::uint32_t x = 0; x < 8; ++x) {
      EXPECT_EQ(film.total(x, y, alpha), film.total(x, y, 0)) << x << "," << y;
      beyond |= film.mean(x, y, alpha) < 0;
    }
  EXPECT_TRUE(beyond) << "no pixel saw the negative rim";
}

}  // namespace
}  // namespace eikon::test
