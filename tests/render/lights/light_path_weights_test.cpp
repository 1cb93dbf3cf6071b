// SPDX-License-Identifier: Apache-2.0
// Camera paths and light paths that find the same light share it: camera paths have 1 / (1 + R) of
// it, and light paths R / (1 + R). weight_ratio() (light_path_weights.h) gives R of a path by
// closed forms from its vertices, in double. The first test measures the share that the renderer
// leaves to camera paths, on random paths, and compares it with 1 / (1 + R). The second one
// measures what the renderer gives to light paths, in random scenes, and compares it with R / (1 +
// R). R is the same function of the path both times. So both weights add up to one on each path,
// whatever R is: a factor that one side alone had, or lacked, would make it disagree with
// weight_ratio().
#include <algorithm>
#include <bit>
#include <random>

#include "render/lights/light_path_weights.h"
#include "shared/splat.h"

namespace eikon::test {
namespace {

/// How many paths had a ratio well below one, near it and well above it.
struct RatioCounts {
  int below = 0, near = 0, above = 0;
  void add(double ratio) { ++(ratio < 0.4 ? below : ratio < 2.5 ? near : above); }
  void expect_at_least(int least) const {
    EXPECT_GE(below, least);
    EXPECT_GE(near, least);
    EXPECT_GE(above, least);
  }
};

// ---- camera paths -------------------------------------------------------------------------------

/// A floor before a mirror and under a pane of glass. One lamp is seen from it in the mirror, the
/// other one through the pane, and both directly, too.
LampScene mirror_and_pane() {
  LampScene made;
  add_matte_floor(made.scene, 0.6F);
  Primitive mirror;
  add_quad(mirror, {-1, 0, -0.7F}, {2, 0, 0}, {0, 1.5F, 0.1F});
  add_mesh(made.scene, "mirror", std::move(mirror), perfect_mirror());
  add_block(made.scene, "pane", {-0.7F, 1, -0.5F}, {0.7F, 1.1F, 0.7F}, glass(1.5F, 0, true));
  add_triangle_lamp(made, {{-2.5, 0.2, 1.7}, {0, 4.5, 1.6}, {2.5, 0.3, 1.6}});
  add_triangle_lamp(made, {{-1, 1.6, -1}, {1.2, 1.7, -0.9}, {0.1, 1.65, 1.2}});
  return made;
}

/// The share of the light at the end of a path that a camera path keeps if there are light paths,
/// by closed forms.
/// edges  from the camera on; the last one ends at the lamp
double expected_share(const LampWavefront& shared, const std::vector<PathVertex>& edges, const TriangleLamp& lamp,
                      double* ratio) {
  *ratio = 0;
  const PathVertex &first = edges.front(), &last = edges.back();
  const bool is_front = glm::dot(glm::dvec3(last.dir), lamp.normal()) < 0;
  if (edges.size() < 3 || !is_front) return 1;
  const auto is_specular = [&](const PathVertex& edge) {
    const Material& m = shared.material_of(edge.triangle);
    return m.metallic == 1 || m.transmission > 0;
  };
  // Light paths start towards mirrors and glass, and are joined to the camera at the floor.
  if (is_specular(first) || !is_specular(edges[edges.size() - 2])) return 1;
  const PathEnds ends = {first.origin + double(first.t) * glm::dvec3(first.dir),
                         {0, 1, 0},
                         -glm::dvec3(last.dir),
                         lamp.normal(),
                         lamp.start_m2,
                         lamp.aim_sr};
  *ratio = weight_ratio(shared.settings(), ends);
  return 1 / (1 + *ratio);
}

/// The paths that were compared are counted, so that the test knows that it saw enough.
struct CameraPaths {
  RatioCounts ratios;
  int in_mirror = 0, through_pane = 0, unshared = 0;
};

/// Traces one path with and without light paths, which have the same random numbers, and compares
/// what the lamp at its end brings.
void compare_camera_path(LampWavefront& shared, LampWavefront& alone, const PixelSample& of, CameraPaths& seen) {
  std::vector<PathVertex> edges, edges_alone;
  const auto into = [](std::vector<PathVertex>& to) { return [&](const PathVertex& edge) { to.push_back(edge); }; };
  const glm::dvec3 with = shared->replay(of.x, of.y, of.sample, into(edges)).radiance,
                   without = alone->replay(of.x, of.y, of.sample, into(edges_alone)).radiance;
  ASSERT_EQ(edges.size(), edges_alone.size());
  ASSERT_EQ(edges.back().beta, edges_alone.back().beta) << "the same path";
  const std::uint32_t end = edges.back().triangle;
  const TriangleLamp* const lamp = end == EK_NO_HIT ? nullptr : shared.lamp_of(end);
  double ratio = 0;
  const double expected = lamp == nullptr ? 1 : expected_share(shared, edges, *lamp, &ratio);
  if (ratio == 0) {
    EXPECT_EQ(with, without) << "light that only camera paths find";
    if (lamp != nullptr) ++seen.unshared;
    return;
  }
  // Lamps are black, so the path ends there, and what it sampled before is the same by both ways.
  const int c = shared.channel_of(*lamp);
  const double share = 1 - (without[c] - with[c]) / (double(edges.back().beta[c]) * kRadiance);
  EXPECT_NEAR(share, expected, 2e-5 * expected + 1e-6) << "R " << ratio;
  seen.ratios.add(ratio);
  ++(c == 0 ? seen.in_mirror : seen.through_pane);
}

TEST(LightPathWeights, of_camera_paths_are_one_over_one_plus_the_ratio_of_densities) {
  Settings settings = settings_for(32, 24, 1U << 16);
  settings.max_depth = 6;
  settings.roulette_depth = 1000;
  LampWavefront alone(mirror_and_pane(), settings);
  settings.light_path_count = 1;
  LampWavefront shared(mirror_and_pane(), settings);
  shared->trace_light_paths(false);  // what camera paths leave to them is enough
  std::mt19937 random(11);
  const auto number = [&](double lo, double hi) { return lo + (hi - lo) * double(random()) * 0x1p-32; };
  CameraPaths seen;
  for (const std::uint64_t paths : {100, 1000, 5000, 20'000, 400'000}) {
    settings.light_path_count = paths;
    const double x = number(-0.5, 0.5), y = number(0.5, 0.8), z = number(1, 1.3);
    settings.camera = look_at_camera({x, y, z}, {0, 0, 0}, {0, 1, 0}, 0.5);
    alone.restart(settings), shared.restart(settings);
    for (int i = 0; i < 500; ++i) {
      PixelSample of;
      of.x = std::uint32_t(number(0, 32)), of.y = std::uint32_t(number(0, 24));
      of.sample = std::uint64_t(number(0, 0x1p16));
      compare_camera_path(shared, alone, of, seen);
    }
  }
  seen.ratios.expect_at_least(100);
  EXPECT_GE(std::min({seen.in_mirror, seen.through_pane, seen.unshared}), 100);
}

// ---- light paths --------------------------------------------------------------------------------

/// Two small lamps, a mirror of one triangle, and a floor. The mirror sends light of the lamps to
/// `lit` and around it, which a camera looks at.
struct Placement {
  LampScene made;
  glm::dvec3 mirror{0.0}, mirror_normal{0.0}, lit{0.0}, eye{0.0}, axis{0.0};
};

double distance_to_segment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 way = b - a;
  const double t = std::clamp(glm::dot(p - a, way) / glm::dot(way, way), 0.0, 1.0);
  return glm::length(a + t * way - p);
}

/// An equilateral triangle around a point. radius: of its corners
TriangleLamp triangle_around(const glm::dvec3& middle, const glm::dvec3& normal, double radius) {
  const glm::dvec3 x = glm::normalize(glm::cross(normal, glm::dvec3(0.3, 0.5, 0.81))), y = glm::cross(normal, x);
  const auto corner = [&](double turn) { return middle + radius * (std::cos(turn) * x + std::sin(turn) * y); };
  return {corner(0), corner(2 * kPi / 3), corner(4 * kPi / 3)};
}

Placement random_placement(std::mt19937& random) {
  const auto number = [&](double lo, double hi) { return lo + (hi - lo) * double(random()) * 0x1p-32; };
  const auto place = [&](double half, double low, double high) {
    return glm::dvec3{number(-half, half), number(low, high), number(-half, half)};  // in this order
  };
  for (;;) {
    Placement placed;
    placed.lit = place(0.3, 0, 0), placed.mirror = place(0.9, 0.5, 1.1), placed.eye = place(0.9, 0.6, 1.3);
    const glm::dvec3 lamp = place(0.9, 0.4, 1.3);
    const glm::dvec3 from_lamp = glm::normalize(placed.mirror - lamp),
                     to_lit = glm::normalize(placed.lit - placed.mirror);
    placed.mirror_normal = glm::normalize(to_lit - from_lamp);
    placed.axis = placed.lit + place(0.25, 0, 0);
    const glm::dvec3 lamp_normal = glm::normalize(from_lamp + 0.9 * place(1, -1, 1));
    if (glm::length(placed.mirror - lamp) < 0.7 || glm::length(placed.mirror - placed.lit) < 0.7) continue;
    if (glm::dot(placed.mirror_normal, to_lit) < 0.3 || glm::dot(lamp_normal, from_lamp) < 0.6) continue;
    if (glm::dot(glm::normalize(placed.axis - placed.eye), glm::normalize(placed.lit - placed.eye)) < 0.97) continue;
    // Nothing else is in the light's way.
    if (distance_to_segment(placed.mirror, placed.eye, placed.lit) < 0.3) continue;
    if (distance_to_segment(lamp, placed.eye, placed.lit) < 0.2) continue;
    if (distance_to_segment(lamp, placed.mirror, placed.lit) < 0.2) continue;
    add_matte_floor(placed.made.scene, 3);
    const TriangleLamp pane = triangle_around(placed.mirror, placed.mirror_normal, 0.25);
    Primitive mirror;
    add_triangle(mirror, pane.a, pane.b, pane.c);
    add_mesh(placed.made.scene, "mirror", std::move(mirror), perfect_mirror());
    const double radius = number(0.007, 0.014);
    const glm::dvec3 aside = glm::normalize(glm::cross(from_lamp, glm::dvec3(0.2, 0.9, 0.4)));
    add_triangle_lamp(placed.made, triangle_around(lamp, lamp_normal, radius));
    add_triangle_lamp(placed.made, triangle_around(lamp + 0.07 * aside, from_lamp, 1.2 * radius));
    return placed;
  }
}

/// The pixel that shows a point.
glm::dvec2 pixel_of(const Settings& settings, const glm::dvec3& point) {
  const glm::dvec3 seen(glm::inverse(settings.camera.world_from_camera) * glm::dvec4(point, 1));
  const double half = std::tan(0.5 * settings.camera.yfov_rad), pixels = 0.5 * settings.height / half;
  return {0.5 * settings.width + pixels * seen.x / -seen.z, 0.5 * settings.height - pixels * seen.y / -seen.z};
}

/// The point of the floor that the middle of a pixel shows.
glm::dvec3 floor_of_pixel(const Settings& settings, std::uint32_t x, std::uint32_t y) {
  const glm::dmat4& camera = settings.camera.world_from_camera;
  const double side = 2 * std::tan(0.5 * settings.camera.yfov_rad) / settings.height;
  const glm::dvec4 ray(side * (x + 0.5 - 0.5 * settings.width), -side * (y + 0.5 - 0.5 * settings.height), -1, 0);
  const glm::dvec3 eye(camera[3]), dir(camera * ray);
  return eye + dir * (eye.y / -dir.y);
}

/// The path from the middle of a lamp by the mirror to a point of the floor.
PathEnds path_by_mirror(const Placement& placed, const TriangleLamp& lamp, const glm::dvec3& lit) {
  const glm::dvec3 n = placed.mirror_normal;
  const glm::dvec3 image = lamp.middle() - 2 * glm::dot(lamp.middle() - placed.mirror, n) * n;
  return {lit, {0, 1, 0}, glm::reflect(glm::normalize(lit - image), n), lamp.normal(), lamp.start_m2, lamp.aim_sr};
}

/// The light that a light path brings to the film by that way, before it has its share.
double unshared_splat(const LampWavefront& wavefront, const PathEnds& path, const TriangleLamp& lamp) {
  // Directions are chosen evenly in the cone of a ball around the mirror.
  const float4& ball = wavefront.packed().light_targets.at(0);
  const double sine = double(ball.w) / glm::length(glm::dvec3(ball.x, ball.y, ball.z) - lamp.middle());
  const double pdf_sr = 1 / (2 * kPi * (1 - std::sqrt(1 - sine * sine)));
  const double throughput = kRadiance * glm::dot(path.lamp_normal, path.from_lamp) / (lamp.start_m2 * pdf_sr);
  const Settings& settings = wavefront.settings();
  const glm::dvec3 to_eye = glm::normalize(glm::dvec3(settings.camera.world_from_camera[3]) - path.first);
  return throughput * kFloorAlbedo / kPi * to_eye.y * film_density(settings, path.first);
}

struct SplatsSeen {
  RatioCounts ratios;
  double deviations = 0;  // sum over all splats, relative
  int count = 0;
};

/// Compares the splats of a unit.
void compare_splats(const LampWavefront& wavefront, const Placement& placed, const UnitSums& sums, SplatsSeen& seen) {
  for (std::size_t at = 0; at < sums.splats.size(); at += SPLAT_WORDS, ++seen.count) {
    const std::uint32_t* const splat = &sums.splats[at];
    const auto value = [&](int channel) { return double(std::bit_cast<float>(splat[SPLAT_r + channel])); };
    const int c = value(0) > 0 ? 0 : 1;
    const TriangleLamp& lamp = wavefront.lamps().at(std::size_t(c));
    const glm::dvec3 lit = floor_of_pixel(wavefront.settings(), splat[SPLAT_pixel] & 0xffffU, splat[SPLAT_pixel] >> 16);
    const PathEnds path = path_by_mirror(placed, lamp, lit);
    const double ratio = weight_ratio(wavefront.settings(), path), expected = ratio / (1 + ratio);
    // The path starts up to 17 mm from the lamp's middle, and ends up to half a pixel from that of
    // the pixel.
    const double weight = value(c) / unshared_splat(wavefront, path, lamp);
    EXPECT_NEAR(weight, expected, 0.02 * expected) << "R " << ratio;
    seen.deviations += weight / expected - 1;
    // The splat also says R itself, to a power of two.
    const int exponent = int(EK_SPLAT_RATIO(splat[SPLAT_info])) - 127;
    EXPECT_NEAR(std::log2(ratio), exponent + 0.5, 0.5 + 0.03);
    seen.ratios.add(ratio);
  }
}

/// Looks at what the mirror lights through a window of 16 x 16 pixels, with so many light paths
/// that R is about `ratio`.
void compare_placement(const Placement& placed, double ratio, SplatsSeen& seen) {
  Settings settings = settings_for(512, 400, 1U << 20);
  settings.max_depth = 3;
  settings.roulette_depth = 1000;
  settings.light_path_count = 1;
  settings.camera = look_at_camera(placed.eye, placed.axis, {0.1, 1, 0.2}, 0.6);
  const glm::dvec2 middle = pixel_of(settings, placed.lit);
  const auto x = std::uint32_t(middle.x) - 8, y = std::uint32_t(middle.y) - 8;
  settings.crop = {x, y, x + 16, y + 16};
  LampWavefront wavefront(placed.made, settings);
  ASSERT_EQ(wavefront.packed().light_targets.size(), 1U);
  const double of_one = weight_ratio(settings, path_by_mirror(placed, wavefront.lamps()[0], placed.lit));
  settings.light_path_count = std::max<std::uint64_t>(1, std::uint64_t(std::llround(ratio / of_one)));
  wavefront.restart(settings);
  const int before = seen.count;
  const std::uint64_t samples = std::max<std::uint32_t>(wavefront->config().capacity() / 256, 1), most = 12'000;
  for (std::uint64_t begin = 0; seen.count < before + 8 && begin < most; begin += samples) {
    wavefront->begin({settings.crop, begin, begin + samples});
    const UnitResult unit = wavefront->finish();
    EXPECT_EQ(unit.sums.light_paths, settings.light_path_count);
    compare_splats(wavefront, placed, unit.sums, seen);
  }
  EXPECT_GE(seen.count, before + 1) << "R " << ratio;
}

TEST(LightPathWeights, of_light_paths_are_the_ratio_of_densities_over_one_plus_it) {
  std::mt19937 random(6);
  SplatsSeen seen;
  constexpr int kPlacements = 20;
  for (int i = 0; i < kPlacements; ++i)
    compare_placement(random_placement(random), 0.1 * std::pow(200, i / (kPlacements - 1.0)), seen);
  seen.ratios.expect_at_least(40);
  // Places on lamp and pixel cancel in the mean: of some 390 splats it has a standard error of 0.02
  // %.
  EXPECT_NEAR(seen.deviations / seen.count, 0, 1e-3);
}

}  // namespace
}  // namespace eikon::test
