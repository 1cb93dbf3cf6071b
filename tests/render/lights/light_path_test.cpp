// SPDX-License-Identifier: Apache-2.0
// Light that passed glass or left a mirror: by light paths it is what closed forms say, and what
// paths from the camera find where they can.
#include <functional>

#include "render/lights/light_path_scenes.h"

namespace eikon::test {
namespace {

void add_floor(Scene& scene, float half, float albedo) {
  Primitive floor;
  add_quad(floor, {-half, 0, half}, {2 * half, 0, 0}, {0, 0, -2 * half});
  add_mesh(scene, "floor", std::move(floor), lambert(albedo));
}

double fresnel(double cos_i, double eta) {
  const double cos_t = std::sqrt(1 - (1 - cos_i * cos_i) / (eta * eta));
  const double s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t), p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  return 0.5 * (s * s + p * p);
}

/// Irradiance of a floor at distance x from the foot of a lamp of 1 W / sr that is `height` above
/// it, all told, behind a plane slab: flux is conserved, so E = T sin(theta) dtheta / (x dx). Light
/// that is reflected within the slab is left out.
double irradiance_behind_slab(double x, double height, double thickness, double eta) {
  const auto reach = [&](double theta) {
    const double sin_t = std::sin(theta) / eta;
    return (height - thickness) * std::tan(theta) + thickness * sin_t / std::sqrt(1 - sin_t * sin_t);
  };
  double lo = 0, hi = 1.5;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (lo + hi);
    (reach(middle) < x ? lo : hi) = middle;
  }
  const double step = 1e-6, theta = 0.5 * (lo + hi);
  const double slope = (reach(theta + step) - reach(theta - step)) / (2 * step);
  const double passed = 1 - fresnel(std::cos(theta), eta);
  return passed * passed * std::sin(theta) / (x * slope);
}

// ---- closed forms -------------------------------------------------------------------------------

/// A floor under a slab of glass, and a point lamp of 1 W / sr above it.
constexpr double kLampHeight = 2, kThickness = 0.2, kIor = 1.5;
Scene floor_under_a_slab(float half) {
  Scene scene;
  add_floor(scene, 3, 0.5F);
  add_block(scene, "slab", {-half, 1, -half}, {half, 1.2F, half}, glass(float(kIor), 0, true));
  scene.lights.push_back(small_lamp({0, kLampHeight, 0}, 1));
  return scene;
}
/// The radiance of that floor where a ray from below the slab meets it.
double radiance_of_floor(glm::dvec3 origin, glm::dvec3 dir) {
  const glm::dvec3 at = origin + dir * (origin.y / -dir.y);
  return 0.5 / kPi * irradiance_behind_slab(std::hypot(at.x, at.z), kLampHeight, kThickness, kIor);
}

struct CameraKind {
  const char* name;
  std::function<void(Camera&)> change;
};
/// Cameras that see a piece of the floor around (0.6, 0, 0) from below the slab.
constexpr double kFieldOfView = 0.3, kOrthographicHeight = 0.13, kLensRadius = 0.05, kFocus = 0.7;
const CameraKind kCameras[] = {
    {"pinhole", [](Camera&) {}},
    {"lens", [](Camera& camera) { camera.lens = Lens{.radius_m = kLensRadius, .focus_distance_m = kFocus}; }},
    {"orthographic",
     [](Camera& camera) { camera.projection = Projection::orthographic, camera.ymag_m = kOrthographicHeight; }},
};

/// The mean of a square picture by such a camera, by the closed form on a grid over its pixels and
/// its lens.
double expected_mean(const Camera& camera) {
  constexpr int kPixels = 24, kRings = 3, kSpokes = 8;
  const glm::dvec3 right(camera.world_from_camera[0]), up(camera.world_from_camera[1]),
      back(camera.world_from_camera[2]), eye(camera.world_from_camera[3]);
  const bool orthographic = camera.projection == Projection::orthographic;
  const double half = orthographic ? kOrthographicHeight : std::tan(0.5 * kFieldOfView);
  double sum = 0;
  int count = 0;
  for (int y = 0; y < kPixels; ++y)
    for (int x = 0; x < kPixels; ++x) {
      const glm::dvec3 across = half * (((2 * x + 1.0) / kPixels - 1) * right + (1 - (2 * y + 1.0) / kPixels) * up);
      for (int i = 0; i < (camera.lens ? kRings * kSpokes : 1); ++i, ++count) {
        if (orthographic) {
          sum += radiance_of_floor(eye + across, -back);
        } else if (!camera.lens) {
          sum += radiance_of_floor(eye, across - back);
        } else {
          const double radius = kLensRadius * std::sqrt((i / kSpokes + 0.5) / kRings), turn = 2 * kPi * i / kSpokes;
          const glm::dvec3 aside = radius * (std::cos(turn) * right + std::sin(turn) * up);
          sum += radiance_of_floor(eye + aside, kFocus * (across - back) - aside);
        }
      }
    }
  return sum / count;
}

TEST(LightPaths, a_point_lamp_behind_a_slab_lights_a_floor_as_the_closed_form_says) {
  const Scene scene = floor_under_a_slab(1);
  for (const CameraKind& kind : kCameras) {
    Settings settings = settings_for(16, 16, 256);
    settings.max_depth = 4;  // without reflections within the slab
    // The floor is seen at an angle, under the slab.
    settings.camera = look_at_camera({0.6, 0.6, 0.6}, {0.6, 0, 0}, {0, 1, 0}, kFieldOfView);
    kind.change(settings.camera);
    const double expected = expected_mean(settings.camera);
    EXPECT_TRUE(agrees(mean_of(film_of(scene, with_light_paths(settings, 64))), expected, 3, 2e-3)) << kind.name;
    EXPECT_LT(mean_of(film_of(scene, settings)).mean, 1e-4 * expected)
        << "no path from the camera finds a lamp without extent; some light comes past the slab and by the floor";
  }
}

TEST(LightPaths, a_panorama_sees_the_same_floor) {
  const Scene scene = floor_under_a_slab(4);
  Settings settings = settings_for(64, 32, 256);
  settings.max_depth = 4;
  settings.camera.projection = Projection::panorama;
  settings.camera.world_from_camera = glm::translate(glm::dmat4(1), {0.6, 0.5, 0});
  settings.crop = {20, 24, 44, 30};  // from 45 to 79 degrees below the horizon, and 68 to either side
  double expected = 0;
  constexpr int kGrid = 4;
  for (int column = 20 * kGrid; column < 44 * kGrid; ++column)
    for (int row = 24 * kGrid; row < 30 * kGrid; ++row) {
      const double azimuth = 2 * kPi * ((column + 0.5) / kGrid / 64 - 0.5), polar = kPi * (row + 0.5) / kGrid / 32;
      const glm::dvec3 dir(std::sin(azimuth) * std::sin(polar), std::cos(polar), -std::cos(azimuth) * std::sin(polar));
      expected += radiance_of_floor({0.6, 0.5, 0}, dir);
    }
  expected /= double(settings.crop.pixel_count()) * kGrid * kGrid;
  EXPECT_TRUE(agrees(mean_of(film_of(scene, with_light_paths(settings, 16))), expected, 1, 1e-3));
}

TEST(LightPaths, of_two_seeds_have_nothing_in_common) {
  Scene scene;
  add_floor(scene, 3, 0.5F);
  add_block(scene, "slab", {-1, 1, -1}, {1, 1.2F, 1}, glass(float(kIor), 0, true));
  scene.lights.push_back(sunshine({0, -1, 0}, 1));
  Settings settings = settings_for(64, 64, 64);
  settings.max_depth = 4;
  settings.camera = look_at_camera({0, 0.9, 0}, {0, 0, 0}, {0, 0, -1}, kFieldOfView);  // a floor that is evenly lit
  const auto of_seed = [&](std::uint32_t seed) {
    settings.seed = seed;
    return film_of(scene, with_light_paths(settings, 16));
  };
  const Film a = of_seed(0), b = of_seed(1);
  const double mean_a = mean_of(a).mean, mean_b = mean_of(b).mean;
  double ab = 0, aa = 0, bb = 0;
  for (std::uint32_t y = 0; y < 64; ++y)
    for (std::uint32_t x = 0; x < 64; ++x) {
      const double of_a = a.mean(x, y, 1) - mean_a, of_b = b.mean(x, y, 1) - mean_b;
      ab += of_a * of_b, aa += of_a * of_a, bb += of_b * of_b;
    }
  EXPECT_LT(std::abs(ab / std::sqrt(aa * bb)), 4.0 / 64) << "the standard error of 4096 pixels is 1 / 64";
}

TEST(LightPaths, a_mirror_sends_the_flux_of_a_sun_onto_the_floor) {
  Scene mirror;
  add_floor(mirror, 40, 0.5F);
  Material metal;
  metal.roughness = 0;
  metal.metallic = 1;
  metal.base_color = glm::vec3(0.8F);
  // A mirror of 1 m^2 that stands upright sends the light of a sun at 45 degrees onto the floor
  // before it.
  Primitive pane;
  add_quad(pane, {-0.5F, 2, 0}, {1, 0, 0}, {0, 1, 0});
  add_mesh(mirror, "mirror", std::move(pane), metal);
  mirror.lights.push_back(sunshine({0, -1, -1}, 2));
  Settings above = settings_for(40, 40, 64);
  above.camera = look_at_camera({0, 20, 2.5}, {0, 0, 2.5}, {0, 0, -1}, 1);
  above.camera.projection = Projection::orthographic;
  above.camera.ymag_m = 1;
  above.max_depth = 3;
  const MeanAndError with = mean_of(film_of(mirror, with_light_paths(above, 4))),
                     without = mean_of(film_of(mirror, above));
  // Where it falls, as much arrives as comes directly: the mirror's light covers x in -0.5 .. 0.5
  // and z in 2 .. 3 of 2 m x 2 m.
  const double direct = 2 * std::cos(kPi / 4) * 0.5 / kPi;
  EXPECT_TRUE(agrees({with.mean - without.mean, with.sigma}, 0.8 * direct * 0.25, 1, 1e-3));
}

/// Share of a sun's light from above that passes a ball of glass of radius 1 without a reflection,
/// in the mean over a square hole of that half side above its middle: both surfaces are met under
/// the same angles.
double passed_by_ball(double half, double eta) {
  constexpr int kSteps = 400;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double x = half * (i + 0.5) / kSteps, z = half * (j + 0.5) / kSteps;  // a quarter has the same mean
      const double passed = 1 - fresnel(std::sqrt(1 - x * x - z * z), eta);
      sum += passed * passed;
    }
  return sum / (kSteps * kSteps);
}

TEST(LightPaths, bring_all_the_flux_that_passes_a_lens_and_no_more) {
  constexpr double kRadius = 0.2, kHole = 0.08, kIrradiance = 3, kAlbedo = 0.5, kElevation = 0.7, kHalfPicture = 0.45;
  for (const double eta : {1.2, 1.5}) {
    Scene scene;
    add_floor(scene, 3, float(kAlbedo));
    // An exact ball of glass, 1 m above the floor, under a square hole in a black screen.
    Shape& ball = scene.shapes.emplace_back();
    ball.name = "lens", ball.kind = ShapeKind::sphere, ball.size = {kRadius};
    ball.world_from_object = glm::translate(glm::dmat4(1), {0, 1, 0});
    scene.materials.push_back(glass(float(eta), 0, true));
    ball.material = std::uint32_t(scene.materials.size() - 1);
    Primitive screen;
    const float hole = float(kHole), wide = 0.5F;
    for (const float side : {-1.0F, 1.0F}) {
      add_quad(screen, {-wide, 1.25F, side < 0 ? -wide : hole}, {2 * wide, 0, 0}, {0, 0, wide - hole});
      add_quad(screen, {side < 0 ? -wide : hole, 1.25F, -hole}, {wide - hole, 0, 0}, {0, 0, 2 * hole});
    }
    add_mesh(scene, "screen", std::move(screen), lambert(0));
    scene.lights.push_back(sunshine({0, -1, 0}, float(kIrradiance)));
    // The camera looks under the screen. The light of both balls that comes without a reflection
    // lands within its picture.
    Settings settings = settings_for(32, 32, 256);
    settings.camera = look_at_camera({0, 4 * std::sin(kElevation), 4 * std::cos(kElevation)}, {0, 0, 0}, {0, 1, 0}, 1);
    settings.camera.projection = Projection::orthographic;
    settings.camera.ymag_m = kHalfPicture;
    settings.max_depth = 4;  // camera, floor, two refractions, sun
    const MeanAndError with = mean_of(film_of(scene, with_light_paths(settings, 8))),
                       without = mean_of(film_of(scene, settings));
    const double passed = 4 * kHole * kHole * kIrradiance * passed_by_ball(kHole / kRadius, eta),
                 floor_m2 = 4 * kHalfPicture * kHalfPicture / std::sin(kElevation);
    // Light that comes beside the screen is the same by both ways.
    EXPECT_TRUE(agrees({with.mean - without.mean, with.sigma}, passed * kAlbedo / kPi / floor_m2, 2, 1e-4)) << eta;
  }
}

// ---- against paths from the camera --------------------------------------------------------------

const Change kChanges[] = {
    {"room", [](Scene&, Settings&) {}},
    {"lens", [](Scene&, Settings& s) { s.camera.lens = Lens{.radius_m = 0.1, .focus_distance_m = 1.5}; }},
    {"orthographic",
     [](Scene&, Settings& s) { s.camera.projection = Projection::orthographic, s.camera.ymag_m = 0.9; }},
    {"panorama", [](Scene&, Settings& s) { s.camera.projection = Projection::panorama, s.width *= 2, s.crop.x1 *= 2; }},
    {"wide filter",
     [](Scene&, Settings& s) {
       s.filter = {FilterKind::gaussian, 3};
     }},
    {"filter with negative lobes",
     [](Scene&, Settings& s) {
       s.filter = {FilterKind::mitchell, 4};
     }},
    {"coloured glass with dispersion",
     [](Scene& scene, Settings&) {
       for (Material& m : scene.materials)
         if (m.transmission > 0) {
           m.dispersion = 5;
           m.attenuation_color = {0.5F, 0.8F, 0.9F};
           m.attenuation_distance = 0.5F;
         }
     }},
    {"thin walls and rough glass on a rough floor",
     [](Scene& scene, Settings&) {
       for (Material& m : scene.materials)
         if (m.transmission > 0) m.solid = false;
       add_block(scene, "rough", {-0.2F, -0.99F, 0.5F}, {0.3F, -0.6F, 0.8F}, glass(1.4F, 0.4F, true));
     }},
    {"coat, sheen and plastic",
     [](Scene& scene, Settings&) {
       scene.materials[0].clearcoat = 0.7F;
       scene.materials[0].specular = 1;
       scene.materials[0].roughness = 0.5F;
       for (Material& m : scene.materials)
         if (m.metallic > 0) m.clearcoat = 0.5F, m.sheen_color = glm::vec3(0.3F);
     }},
    {"under water, the camera too",
     [](Scene& scene, Settings&) {
       add_block(scene, "water", {-1.5F, -1.5F, -1.5F}, {1.5F, 0.6F, 2}, glass(1.33F, 0, true));
     }},
    {"a lamp within coloured glass",
     [](Scene& scene, Settings&) {
       add_block(scene, "amber", {-0.5F, 0.85F, -0.5F}, {0.5F, 0.99F, 0.5F}, amber(0.05F, 1.3F));
     }},
    {"a lamp that shines both ways in a ball of glass",
     [](Scene& scene, Settings&) {
       scene.materials[1].double_sided = true;
       add_mesh(scene, "globe", sphere({0, 0.95F, 0}, 0.7F, 12, false, false), glass(1.2F, 0, false));
     }},
};

TEST(LightPaths, bring_the_mean_that_paths_from_the_camera_find) {
  constexpr int comparisons = int(std::size(kChanges)) * 4 * 3;
  for (const Change& change : kChanges) {
    auto [scene, settings] = room_of_glass(24, 1536);
    change.make(scene, settings);
    const Film with = expect_the_same_mean(change.name, scene, settings, 2048, comparisons);
    EXPECT_EQ(with.light_paths().empty(), change.name == std::string("a lamp within coloured glass")) << change.name;
  }
}

const Change kSunny[] = {
    {"sky alone", [](Scene&, Settings&) {}},
    {"turned sky", [](Scene&, Settings& s) { s.environment.rotation_rad = 2, s.environment.scale = 0.5; }},
    {"sky and lamps",
     [](Scene& scene, Settings&) {
       Primitive lamp;
       add_quad(lamp, {-0.4F, 0.97F, -0.4F}, {0.8F, 0, 0}, {0, 0, 0.8F});
       add_mesh(scene, "lamp", std::move(lamp), lambert(0.3F, 5));
       scene.lights.push_back(sunshine({0.2, -1, -0.1}, 0.0F));
     }},
};

TEST(LightPaths, bring_the_light_of_suns_in_environment_maps) {
  constexpr int comparisons = int(std::size(kSunny)) * 4 * 3;
  for (const Change& change : kSunny) {
    auto [scene, settings] = floor_in_the_sun(24, 3072, 300);
    change.make(scene, settings);
    EXPECT_FALSE(expect_the_same_mean(change.name, scene, settings, 4096, comparisons).light_paths().empty())
        << change.name;
  }
  // A sky without a sun, which paths from the camera find well, has none.
  const auto [scene, settings] = floor_in_the_sun(8, 4, 0.2F);
  EXPECT_TRUE(film_of(scene, with_light_paths(settings, 1)).light_paths().empty());
}

TEST(LightPaths, are_none_where_no_light_can_start_them) {
  auto [scene, settings] = room_of_glass(8, 4);
  scene.materials[1].emission = glm::vec3(0);
  PunctualLight faded = small_lamp({0, 0.5, 0}, 1);
  faded.range_m = 3;
  scene.lights.push_back(faded);
  for (const bool chunked : {true, false}) {
    Execution execution;
    execution.chunked = chunked, execution.lanes = chunked ? 16 : 1, execution.fused = false;
    const Film film = film_of(scene, with_light_paths(settings, 1), execution);
    EXPECT_TRUE(film.light_paths().empty());
    EXPECT_EQ(mean_of(film).mean, mean_of(film_of(scene, settings, execution)).mean);
  }
}

TEST(LightPaths, leave_a_furnace_at_one) {
  for (const double ratio : {1.0 / 16, 2.0}) {
    Scene scene;
    Primitive walls;
    add_box(walls, glm::vec3(-1), glm::vec3(1), true);
    add_mesh(scene, "walls", std::move(walls), lambert(0.5F, 0.5F));
    add_mesh(scene, "ball", sphere({0.3F, -0.4F, 0}, 0.4F, 12, false, true), glass(1.5F, 0, true));
    Settings settings = settings_for(16, 16, 512);
    settings.camera = look_at_camera({-0.5, 0.3, 0.9}, {0, -0.2, 0}, {0, 1, 0}, 1.2);
    EXPECT_TRUE(agrees(mean_of(film_of(scene, with_light_paths(settings, ratio))), 1, 2, 1e-4)) << ratio;
  }
}

TEST(LightPaths, find_caustics_with_a_fraction_of_the_error) {
  const Scene scene = load_shipped("cornell_spheres.gltf");
  const auto [without, with] = errors_of(scene, settings_of(scene, 64, 64));
  EXPECT_LT(with, 0.35 * without) << without << " without";
}

TEST(LightPaths, find_caustics_of_a_small_sun_with_a_fraction_of_the_error) {
  auto [scene, settings] = floor_in_the_sun(32, 64, 0.1F);
  settings.camera = look_at_camera({-1, -0.1, 1.5}, {0.05, -1, 0.45}, {0, 1, 0}, 0.2);  // where the ball's caustic is
  auto map = std::make_shared<EnvironmentMap>();
  map->width = 512, map->height = 256;  // a sun of 0.7 degrees
  map->radiance.assign(512 * 256, glm::vec3(0.1F));
  map->radiance[64 * 512 + 320] = glm::vec3(20000);
  settings.environment.map = std::move(map);
  const auto [without, with] = errors_of(scene, settings);
  EXPECT_LT(with, 0.1 * without) << without << " without";
}

}  // namespace
}  // namespace eikon::test
