// SPDX-License-Identifier: Apache-2.0
// Sampling of emissive shapes: each density integrates to one over what is seen of the shape,
// points come as it says, and a ray that meets the point that was chosen is told the same.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>
#include <random>

#include "kernels/lights/shape_lamps.h"
#include "kernels/probe.h"
#include "kernels/statistics.h"
#include "kernels/traverse/traverse_probe.h"
#include "support/random.h"

namespace eikon::test {
namespace {

using std::numbers::pi;

struct View {
  std::string name;
  Shape shape;
  glm::dvec3 from{0};
  bool inside = false;
  double seen = 1;  // share of the samples that nothing of the shape itself hides, at least
};

Scene scene_of(const Shape& shape) {
  Scene scene;
  scene.materials.push_back(lamp_material());
  scene.shapes.push_back(shape);
  return scene;
}

class Lamp {
 public:
  explicit Lamp(const Shape& shape) : scene_(scene_of(shape)), settings_{}, features_(scene_, settings_) {
    packed_ = pack_in_world(scene_, features_, settings_);
    probe_.emplace(lamp_probe("light_shape", features_));
    const glm::dvec3 center = 0.5 * (packed_.bounds.lo + packed_.bounds.hi), half = packed_.bounds.hi - center;
    Frame frame{};
    frame.scene_center = {float(center.x), float(center.y), float(center.z), 0};
    frame.scene_half = {float(half.x), float(half.y), float(half.z), 0};
    probe_->buffer("frame", std::vector<Frame>{frame})
        .buffer("triangles", packed_.triangles)
        .buffer("shapes", packed_.shapes);
    for (const char* name : {"triangle_normals", "triangle_tangents", "triangle_colors", "materials",
                             "material_extensions", "material_details", "textures", "texels"})
      probe_->buffer(name, std::vector<std::uint32_t>(64));
  }
  std::vector<Words> run(const std::string& kernel, const std::vector<Words>& in, unsigned outputs) const {
    return probe_->run(kernel, in, outputs);
  }

 private:
  Scene scene_;
  Settings settings_;
  Features features_;
  PackedScene packed_;
  std::optional<Probe> probe_;
};

std::vector<View> views() {
  std::vector<View> all;
  const glm::dmat4 turned =
      glm::translate(glm::dmat4(1), {0.3, -0.2, 0.5}) * glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(0.3, 1, 0.2));
  const glm::dmat4 stretched =
      turned * glm::scale(glm::dmat4(1), {1.0, 0.4, 0.7}) * glm::rotate(glm::dmat4(1), 1.1, glm::dvec3(1, 0.4, 0.1));
  for (const ShapeKindInfo& kind : shape_kinds()) {
    Shape shape;
    shape.kind = kind.kind;
    shape.size = kind.kind == ShapeKind::sphere ? std::array<double, 3>{0.5} : std::array<double, 3>{0.9, 0.5, 0.7};
    if (kind.kind == ShapeKind::cylinder || kind.kind == ShapeKind::capsule) shape.size = {1.1, 0.25, 0.5};
    for (const glm::dmat4& place : {turned, stretched}) {
      shape.world_from_object = place;
      const glm::dmat4 m = place;
      const auto world = [&](glm::dvec3 p) { return glm::dvec3(m * glm::dvec4(p, 1)); };
      const std::string name = std::string(kind.name) + (place == turned ? "" : ", stretched");
      const double least = kind.kind == ShapeKind::capsule ? 0.3 : 1;
      all.push_back({name + ", from beside", shape, world({2, 0.1, 0.4}), false, least});
      all.push_back({name + ", from above", shape, world({0.2, 1.7, 0.1}), false, least});
      all.push_back({name + ", from below and far", shape, world({3, -9, 4}), false, least});
      all.push_back({name + ", from near", shape, world({0.55, 0.4, 0.05}), false, least});
      if (kind.kind == ShapeKind::plane) continue;
      all.push_back({name + ", from inside", shape, world({0.05, -0.1, 0.02}), true});
    }
  }
  return all;
}

/// Cells of directions about the middle of what is seen.
struct Cells {
  static constexpr int kRings = 8, kSectors = 24;
  glm::dvec3 axis, x, y;
  double versine = 1e-30;  // 1 - cos of the half angle of the cone that holds all

  Cells(const View& view, const ShapePoints& points) {
    const glm::dvec3 center(view.shape.world_from_object[3]);
    axis = glm::normalize(center - view.from);
    x = glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    y = glm::cross(axis, x);
    for (const glm::dvec3& p : points.p)
      versine = std::max(versine, 1.0001 * (1 - glm::dot(axis, glm::normalize(p - view.from))));
  }
  [[nodiscard]] std::size_t cell_of(const glm::dvec3& d) const {
    const double phi = std::atan2(glm::dot(d, y), glm::dot(d, x)) / (2 * pi);
    const int ring = std::clamp(int((1 - glm::dot(d, axis)) / versine * kRings), 0, kRings - 1);
    return std::size_t(ring * kSectors + std::min(int((phi < 0 ? phi + 1 : phi) * kSectors), kSectors - 1));
  }
};

TEST(LightShapes, M1_densities_integrate_to_one_and_points_come_as_they_say) {
  constexpr int kSamples = 1 << 16;
  const std::vector<View> all = views();
  for (const View& view : all) {
    const Lamp lamp(view.shape);
    const ShapePoints points(view.shape);
    const Cells cells(view, points);
    const bool plane = view.shape.kind == ShapeKind::plane;
    const auto is_seen = [&](double across) { return plane || (view.inside ? across > 0 : across < 0); };
    // The density of a ray towards each point, over the surface that is seen.
    std::vector<Words> in(6);
    std::vector<std::size_t> of;
    for (std::size_t i = 0; i < points.p.size(); ++i) {
      if (!is_seen(glm::dot(points.area[i], points.p[i] - view.from))) continue;
      of.push_back(i);
      append(in, 0, view.from);
      append(in, 3, glm::normalize(points.p[i] - view.from));
    }
    const auto densities = lamp.run("probe_shape_pdf", in, 2);
    std::vector<double> expected(Cells::kRings * Cells::kSectors + 1, 0.0);
    double integral = 0, missed = 0;
    for (std::size_t i = 0; i < of.size(); ++i) {
      const glm::dvec3 d = points.p[of[i]] - view.from;
      const double sr = std::abs(glm::dot(points.area[of[i]], d)) / std::pow(glm::length(d), 3);
      const double pdf = double(as_float(densities[1][i]));
      ASSERT_TRUE(pdf >= 0 && std::isfinite(pdf)) << view.name;
      expected[cells.cell_of(glm::normalize(d))] += pdf * sr * kSamples;
      integral += pdf * sr;
      missed += densities[0][i] == 0 ? pdf * sr : 0;
    }
    EXPECT_LT(missed, 1e-4) << view.name << ": rays at the surface that do not meet it";
    // The seen part of a round side ends within a column of points, and rays that graze it meet it
    // elsewhere than meant: with 3072 columns the sum is up to 7e-4 too small, with 4096 4e-4.
    const bool flat = view.shape.kind == ShapeKind::box || plane, ball = view.shape.kind == ShapeKind::sphere;
    if (view.seen == 1)
      EXPECT_NEAR(integral, 1, flat || ball ? 1e-4 : 1e-3) << view.name;
    else
      EXPECT_TRUE(integral > view.seen && integral < 1.0001) << view.name << ": " << integral;
    expected.back() = kSamples * (1 - integral);

    std::mt19937 random(1);
    std::vector<Words> places(5);
    for (int i = 0; i < kSamples; ++i) {
      places[0].push_back(as_word(float(random() >> 8) * 0x1p-24F));
      places[1].push_back(as_word(float(random() >> 8) * 0x1p-24F));
      append(places, 2, view.from);
    }
    const auto out = lamp.run("probe_shape_light", places, 15);
    std::vector<double> observed(expected.size(), 0.0);
    int differ = 0, facing = 0;
    for (std::size_t i = 0; i < std::size_t(kSamples); ++i) {
      const glm::dvec3 wi = vector_at(out, 7, i);
      const double across = glm::dot(wi, vector_at(out, 3, i));
      ++observed[is_seen(across) ? cells.cell_of(wi) : expected.size() - 1];
      if (!is_seen(across) || std::abs(across) < 0.05) continue;
      // Rounding of the direction moves the point by so much over the cosine, which turns the
      // normal of a round shape.
      const double tolerance = 1e-4 * std::max(1.0, 0.1 / (across * across));
      ++facing;
      const double pdf = double(as_float(out[6][i])), asked = double(as_float(out[14][i]));
      if (out[10][i] == 0 || std::abs(pdf - asked) > tolerance * pdf ||
          glm::length(vector_at(out, 0, i) - vector_at(out, 11, i)) > 1e-4)
        ++differ;
    }
    // A point at an edge may be met on the face beside it.
    EXPECT_LE(differ, facing / 1000) << view.name << ": rays that meet a sample are told otherwise";
    if (view.seen == 1) expected.pop_back(), observed.pop_back();
    const ChiSquare test = chi_square(observed, expected);
    EXPECT_GT(test.p_value, sidak(all.size())) << view.name << ": " << test.statistic << " of " << test.degrees;
  }
}

TEST(LightShapes, L5_L6_from_anywhere_samples_are_finite_and_on_the_shape) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const View& view : views()) {
    if (view.name.find("beside") == std::string::npos) continue;
    const Lamp lamp(view.shape);
    const glm::dmat4& m = view.shape.world_from_object;
    std::vector<Words> in(5);
    for (int i = 0; i < 1 << 14; ++i) {
      const bool corner = i % 5 == 0;
      in[0].push_back(as_word(corner ? (i % 2 == 0 ? 0.0F : 1 - 0x1p-24F) : float(unit(random))));
      in[1].push_back(as_word(corner ? (i % 3 == 0 ? 0.0F : 1 - 0x1p-24F) : float(unit(random) * (1 - 0x1p-24))));
      // From everywhere, the middle, the surface of a sphere, and a million radii away.
      const glm::dvec3 d = random_direction(random);
      const double reach = i % 7 == 0   ? 0
                           : i % 7 == 1 ? 0.5
                           : i % 7 == 2 ? 5e5
                           : i % 7 == 3 ? 0.5000001
                                        : 2 * unit(random);
      append(in, 2, glm::dvec3(m * glm::dvec4(reach * d, 1)));
    }
    const auto out = lamp.run("probe_shape_light", in, 15);
    const glm::dmat4 inverse = glm::inverse(m);
    for (std::size_t i = 0; i < in[0].size(); ++i) {
      const glm::dvec3 p(inverse * glm::dvec4(vector_at(out, 0, i), 1)), n = vector_at(out, 3, i);
      const double pdf = double(as_float(out[6][i]));
      ASSERT_TRUE(std::isfinite(pdf) && pdf >= 0) << view.name << ", sample " << i << ": " << pdf;
      ASSERT_NEAR(glm::length(n), 1, 1e-5) << view.name << ", sample " << i;
      ASSERT_TRUE(glm::length(p) < 1.2 && std::isfinite(p.x)) << view.name << ", sample " << i;
      if (view.shape.kind == ShapeKind::sphere) {
        ASSERT_NEAR(glm::length(p), 0.5, 1e-5) << view.name << ", sample " << i;
      }
    }
  }
}

}  // namespace
}  // namespace eikon::test
