// SPDX-License-Identifier: Apache-2.0
// Pictures of materials by tables that were measured from known materials, beside those materials.
#include <algorithm>
#include <random>

#include "render/scene_builder.h"
#include "scene/measured_table.h"
#include "support/measured_material.h"

namespace eikon::test {
namespace {

constexpr int kH = EK_MEASURED_THETA_H, kD = EK_MEASURED_THETA_D, kP = EK_MEASURED_PHI_D;

Material by_table(const std::vector<float>& rgb) {
  Material measured;
  measured.metallic = measured.roughness = measured.specular = 0;
  measured.lobe = Lobe::measured;
  measured.measured = std::make_shared<const MeasuredTable>(make_measured_table(rgb));
  return measured;
}

const glm::dvec3 kEye(0, 0.8, 4);
constexpr double kView = 0.5;
constexpr std::uint32_t kSide = 16;
// The lamp, which faces down.
const glm::dvec3 kLampCorner(-1, 3, -1);
constexpr double kLampSide = 1.5;

/// A ball under a white sky, which shows what it reflects of all light; or under a lamp alone, over
/// a floor.
std::pair<Scene, Settings> ball_of(const Material& material, bool lamp_lit) {
  Scene scene;
  if (lamp_lit) {
    Primitive floor, lamp;
    add_quad(floor, {-3, -1, 3}, {6, 0, 0}, {0, 0, -6});
    add_quad(lamp, glm::vec3(kLampCorner), {kLampSide, 0, 0}, {0, 0, kLampSide});
    add_mesh(scene, "floor", std::move(floor), lambert(0.4F));
    add_mesh(scene, "lamp", std::move(lamp), lambert(0, 12));
  }
  Shape ball;
  ball.kind = ShapeKind::sphere;
  ball.size[0] = 1;
  ball.material = std::uint32_t(scene.materials.size());
  scene.materials.push_back(material);
  scene.shapes.push_back(ball);
  Settings settings = settings_for(kSide, kSide, 2560);
  settings.camera = look_at_camera(kEye, {0, 0, 0}, {0, 1, 0}, kView);
  if (lamp_lit)
    settings.max_depth = 2;
  else
    settings.environment.radiance = glm::vec3(1);
  return {std::move(scene), settings};
}

/// How far a table may be from its material in one pair of directions, and about what it is there.
struct Remainder {
  std::array<double, 3> error{}, value{};
};

/// Interpolation between samples at unit distance is off by at most an eighth of the second
/// derivative, for each of three coordinates [the remainder of linear interpolation]; the second
/// differences of the entries around give that derivative, with a factor of 2 for its change
/// between neighbours (tests/kernels/bsdf/bsdf_measured_test.cpp holds every direction to that). At
/// the ends of the table, and next to entries that no directions have, all of the largest value
/// around counts.
Remainder remainder_of(const std::vector<float>& rgb, const glm::dvec3& wo, const glm::dvec3& wi) {
  const glm::dvec3 half = glm::normalize(wo + wi);
  const double sine = std::hypot(half.x, half.y);
  const double c = sine > 0 ? half.x / sine : 1, s = sine > 0 ? half.y / sine : 0;
  const glm::dvec3 along(c * wi.x + s * wi.y, c * wi.y - s * wi.x, wi.z);
  const double x = half.z * along.x - sine * along.z, pi = std::numbers::pi;
  double phi = std::atan2(along.y, x);
  if (phi < 0) phi += pi;
  const double h = kH * std::sqrt(std::atan2(sine, half.z) / (pi / 2)) - 0.5,
               d = kD * std::acos(std::min(1.0, glm::dot(wi, half))) / (pi / 2) - 0.5, p = kP * phi / pi - 0.5;
  const int h0 = std::clamp(int(std::floor(h)), 0, kH - 2), d0 = std::clamp(int(std::floor(d)), 0, kD - 2),
            p0 = int(std::floor(p));
  const auto entry = [&](int i, int j, int k, std::size_t channel) {
    i = std::clamp(i, 0, kH - 1), j = std::clamp(j, 0, kD - 1), k = (k + kP) % kP;
    return double(rgb[std::size_t(3 * ((i * kD + j) * kP + k)) + channel]);
  };
  Remainder r;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    std::array<double, 3> second{};
    double largest = 0, sum = 0;
    int known = 0;
    bool inside = h >= 1 && d >= 1 && h0 + 2 < kH && d0 + 2 < kD;
    for (int corner = 0; corner < 8; ++corner) {
      const int i = h0 + (corner & 1), j = d0 + (corner >> 1 & 1), k = p0 + (corner >> 2);
      const double middle = entry(i, j, k, channel);
      for (const auto& [di, dj, dk, axis] : {std::array{1, 0, 0, 0}, {0, 1, 0, 1}, {0, 0, 1, 2}}) {
        const double before = entry(i - di, j - dj, k - dk, channel), after = entry(i + di, j + dj, k + dk, channel);
        inside = inside && std::min({before, middle, after}) >= 0;
        second[std::size_t(axis)] = std::max(second[std::size_t(axis)], std::abs(before - 2 * middle + after));
      }
      largest = std::max(largest, middle);
      if (middle >= 0) sum += middle, ++known;
    }
    r.value[channel] = known > 0 ? sum / known : 0;
    r.error[channel] = inside ? (second[0] + second[1] + second[2]) / 4 + 1e-4 * r.value[channel] : largest;
  }
  return r;
}

/// Of the lamp's light on what a window of pixels shows of the ball, the share that the table may
/// misplace: the mean of the remainder over that of f, by the cosines and distances, over points of
/// the ball and of the lamp. The ball is convex, and what the floor shows has met no table.
std::array<double, 3> lamp_resolution(const std::vector<float>& rgb, const Crop& window) {
  const glm::dvec3 back = glm::normalize(kEye), right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), back)),
                   up = glm::cross(back, right);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit;
  std::array<double, 3> error{}, all{};
  for (int i = 0; i < 6000; ++i) {
    const double px = window.x0 + unit(random) * (window.x1 - window.x0),
                 py = window.y0 + unit(random) * (window.y1 - window.y0), scale = std::tan(kView / 2);
    const glm::dvec3 dir =
        glm::normalize((2 * px / kSide - 1) * scale * right + (1 - 2 * py / kSide) * scale * up - back);
    const glm::dvec3 lamp = kLampCorner + kLampSide * glm::dvec3(unit(random), 0, unit(random));
    const double b = glm::dot(kEye, dir), c = glm::dot(kEye, kEye) - 1;
    if (b * b < c) continue;  // beside the ball
    const glm::dvec3 n = kEye + (-b - std::sqrt(b * b - c)) * dir, to = lamp - n;
    const glm::dvec3 wi_world = glm::normalize(to);
    if (glm::dot(wi_world, n) <= 0) continue;
    const glm::dvec3 t = glm::normalize(glm::cross(std::abs(n.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0), n)),
                     u = glm::cross(n, t);
    const auto local = [&](const glm::dvec3& w) { return glm::dvec3(glm::dot(w, t), glm::dot(w, u), glm::dot(w, n)); };
    const Remainder r = remainder_of(rgb, local(-dir), local(wi_world));
    const double geometry = glm::dot(wi_world, n) * wi_world.y / glm::dot(to, to);
    for (std::size_t k = 0; k < 3; ++k) error[k] += r.error[k] * geometry, all[k] += r.value[k] * geometry;
  }
  for (std::size_t k = 0; k < 3; ++k) error[k] = all[k] > 0 ? error[k] / all[k] : 0;
  return error;
}

// Radiance is linear in f. Under the sky each pixel is off by what bsdf_measured_test.cpp bounds
// for views from 2 degrees above it, |f - f'| over the cosine-weighted hemisphere: 1 % of f. What
// the lamp alone lights is off by lamp_resolution, of which 6000 points know the mean to a tenth.
constexpr double kSkyResolution = 0.01;

TEST(MeasuredPictures, are_those_of_the_measured_materials_within_the_tables_resolution) {
  Material copper, plastic;
  copper.roughness = 0.35F;
  copper.lobe = Lobe::conductor;
  copper.conductor_eta = {0.216561F, 0.958162F, 1.165808F};
  copper.conductor_k = {3.637741F, 2.577065F, 2.393857F};
  plastic.base_color = {0.7F, 0.3F, 0.1F};
  plastic.metallic = 0;
  plastic.roughness = 0.4F;
  constexpr std::uint32_t kWindow = 4;
  constexpr int kComparisons = 3 * 2 * 16 * 3;
  double worst = 0;
  std::vector<double> bounds;
  for (const Material& known : {copper, plastic, lambert({0.8F, 0.5F, 0.2F})}) {
    const std::vector<float> rgb = measured(known);
    const Material table = by_table(rgb);
    for (const bool lamp_lit : {false, true}) {
      const auto [analytic, settings] = ball_of(known, lamp_lit);
      const Film exact = film_of(analytic, settings), other = film_of(ball_of(table, lamp_lit).first, settings);
      for (std::uint32_t y = 0; y < kSide; y += kWindow)
        for (std::uint32_t x = 0; x < kSide; x += kWindow) {
          const Crop window{x, y, x + kWindow, y + kWindow};
          const auto of_lamp = lamp_resolution(rgb, window);
          for (std::uint32_t c = 0; c < 3; ++c) {
            const MeanAndError a = mean_of(exact, c, window), b = mean_of(other, c, window);
            const double resolution = lamp_lit ? 1.1 * of_lamp[c] : kSkyResolution;
            EXPECT_NEAR(b.mean, a.mean, z_bound(kComparisons) * std::hypot(a.sigma, b.sigma) + resolution * a.mean)
                << (lamp_lit ? "lamp, " : "sky, ") << x << "," << y << " channel " << c;
            if (a.mean > 1e-3) {  // else in the dark
              EXPECT_LT(std::hypot(a.sigma, b.sigma), 0.01 * a.mean) << "too few samples to tell";
              worst = std::max(worst, std::abs(a.mean - b.mean) / a.mean);
              if (lamp_lit) bounds.push_back(resolution);
              // Found, and less than what is derived where light comes or goes at grazing angles:
              // it tells when something changes.
              EXPECT_NEAR(b.mean, a.mean, z_bound(kComparisons) * std::hypot(a.sigma, b.sigma) + 0.01 * a.mean);
            }
          }
        }
    }
  }
  std::ranges::sort(bounds);
  std::printf(
      "windows differ by %.2g at most, noise included; the lamp's bounds are %.2g, %.2g for half of them, and %.2g\n",
      worst, bounds.front(), bounds[bounds.size() / 2], bounds.back());
}

}  // namespace
}  // namespace eikon::test
