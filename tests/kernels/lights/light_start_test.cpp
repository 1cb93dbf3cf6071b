// SPDX-License-Identifier: Apache-2.0
// Light paths that start from shapes: points come as densely as a path from the camera that meets
// them is told, directions as densely as the cones of the targets lie there, and throughputs are
// what the light is over both. The scene has two lamps of each kind of shape, one of them sheared,
// and targets that overlap.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>
#include <optional>
#include <random>
#include <stdexcept>

#include "kernels/lights/shape_lamps.h"
#include "kernels/probe.h"
#include "kernels/statistics.h"
#include "pack/frame.h"
#include "pack/pack.h"

namespace eikon::test {
namespace {

constexpr std::size_t kStartCount = 1 << 20;
constexpr double kTurn = 2 * std::numbers::pi;
/// Radiances of the lamps, by which about as many light paths start from each.
constexpr float kRadiances[] = {0.1F, 1.5F, 1, 1, 8, 4, 1, 1, 0.5F, 1};
constexpr std::size_t kLampCount = std::size(kRadiances);
enum : std::uint32_t { kGlass = kLampCount };  // index of its material, behind those of the lamps

bool is_sheared(std::size_t lamp) { return lamp % 2 == 1; }

/// Two lamps of each kind: one as it is, which shines outwards alone, and one stretched and
/// sheared, which shines inwards, too.
std::vector<Shape> lamps() {
  std::vector<Shape> all;
  for (const ShapeKindInfo& kind : shape_kinds()) {
    if (kind.kind == ShapeKind::implicit) continue;  // no light path starts from these
    Shape shape;
    shape.kind = kind.kind;
    shape.size = {0.9, 0.5, 0.7};
    if (kind.kind == ShapeKind::sphere) shape.size = {0.5};
    if (kind.kind == ShapeKind::cylinder || kind.kind == ShapeKind::capsule) shape.size = {1.1, 0.25, 0.5};
    for (const bool sheared : {false, true}) {
      // Around the targets, by the golden angle.
      const double y = 1.7 - 0.35 * double(all.size()), phi = 2.4 * double(all.size());
      glm::dmat4 m = glm::translate(glm::dmat4(1), {2.3 * std::cos(phi), y, 2.3 * std::sin(phi)}) *
                     glm::rotate(glm::dmat4(1), 0.7 + phi, glm::dvec3(0.3, 1, 0.2));
      if (sheared)
        m *= glm::scale(glm::dmat4(1), {1.0, 0.4, 0.7}) * glm::rotate(glm::dmat4(1), 1.1, glm::dvec3(1, 0.4, 0.1));
      shape.world_from_object = m;
      shape.material = std::uint32_t(all.size());
      all.push_back(shape);
    }
  }
  if (all.size() != kLampCount) throw std::logic_error("kRadiances has not two lamps of each kind of shape");
  return all;
}

/// Balls of glass. Targets hold their boxes: those of the first three overlap, and that of the last
/// one holds a part of a lamp.
std::vector<Shape> glass_balls() {
  std::vector<Shape> all;
  for (const auto& [center, radius] :
       {std::pair(glm::dvec3(0, 0, 0), 0.5), std::pair(glm::dvec3(0.9, 0.3, 0.2), 0.4),
        std::pair(glm::dvec3(-0.4, 0.6, -0.5), 0.3), std::pair(glm::dvec3(0.2, -1.2, 0.4), 0.1),
        std::pair(glm::dvec3(4, 2, 0), 1.0)}) {
    Shape shape;
    shape.kind = ShapeKind::sphere;
    shape.size = {radius};
    shape.material = kGlass;
    shape.world_from_object = glm::translate(glm::dmat4(1), center);
    all.push_back(shape);
  }
  return all;
}

Scene scene_of_lamps() {
  Scene scene;
  for (std::size_t lamp = 0; lamp < kLampCount; ++lamp) {
    scene.materials.push_back(lamp_material());
    scene.materials.back().emission = glm::vec3(kRadiances[lamp]);
    scene.materials.back().double_sided = is_sheared(lamp);
  }
  scene.materials.emplace_back();
  scene.materials[kGlass].metallic = 0;
  scene.materials[kGlass].roughness = 0;
  scene.materials[kGlass].transmission = 1;
  scene.shapes = lamps();
  for (const Shape& ball : glass_balls()) scene.shapes.push_back(ball);
  return scene;
}

class StartProbe {
 public:
  StartProbe() : scene_(scene_of_lamps()), settings_(with_paths()), features_(scene_, settings_) {
    packed_ = pack_in_world(scene_, features_, settings_);
    probe_.emplace(lamp_probe("light_start", features_));
    probe_->append_file("lights/light_start_probes.cl")
        .buffer("frame", std::vector<Frame>{pack_frame(packed_, settings_)})
        .buffer("triangles", packed_.triangles)
        .buffer("shapes", packed_.shapes)
        .buffer("materials", packed_.materials)
        .buffer("lights", packed_.lights)
        .buffer("emission_alias_table", packed_.emission_alias_table)
        .buffer("emission_pdf", packed_.emission_pdf)
        .buffer("emission_aim", packed_.emission_aim)
        .buffer("light_targets", packed_.light_targets)
        .buffer("light_aim", Words(1));
    for (const char* name :
         {"triangle_normals", "triangle_tangents", "triangle_colors", "material_extensions", "material_details",
          "textures", "texels", "light_alias_table", "light_nodes", "environment_texels", "environment_alias_table"})
      probe_->buffer(name, std::vector<std::uint32_t>(64));
  }
  std::vector<Words> run(const std::string& kernel, const std::vector<Words>& in, unsigned outputs) const {
    return probe_->run(kernel, in, outputs);
  }
  [[nodiscard]] const std::vector<float4>& targets() const { return packed_.light_targets; }
  /// The record of a lamp's surface, of which there are no triangles.
  [[nodiscard]] std::uint32_t record(std::size_t lamp) const { return std::uint32_t(lamp); }

 private:
  static Settings with_paths() {
    Settings settings;
    settings.light_path_count = 1;
    return settings;
  }

  Scene scene_;
  Settings settings_;
  Features features_;
  PackedScene packed_;
  std::optional<Probe> probe_;
};

void put(std::vector<Words>& in, std::size_t first, const glm::dvec3& a) {
  for (int k = 0; k < 3; ++k) in[first + std::size_t(k)].push_back(as_word(float(a[k])));
}

struct Start {
  std::size_t lamp;
  glm::dvec3 p, dir;
  double throughput;
};

std::vector<Start> starts_of(const StartProbe& probe) {
  std::mt19937 random(17);
  std::vector<Words> in(5);
  for (std::size_t i = 0; i < kStartCount; ++i) {
    for (std::size_t k = 0; k < 2; ++k) in[k].push_back(std::uint32_t(random()));
    for (std::size_t k = 2; k < 5; ++k) in[k].push_back(as_word(uniform(random)));
  }
  const std::vector<Words> out = probe.run("probe_emitted_path", in, 8);
  std::vector<Start> starts;
  for (std::size_t i = 0; i < kStartCount; ++i)
    starts.push_back({out[0][i], vector_at(out, 1, i), vector_at(out, 4, i), double(as_float(out[7][i]))});
  return starts;
}

struct Stated {
  bool met;
  glm::dvec3 p, n;
  double start_m2;
};

/// The answers to rays that meet lamps. Each ray has the record of its lamp, its origin and its
/// direction.
std::vector<Stated> stated_for(const StartProbe& probe, const std::vector<Words>& rays) {
  const std::vector<Words> out = probe.run("probe_start_density", rays, 8);
  std::vector<Stated> all;
  for (std::size_t i = 0; i < out[0].size(); ++i)
    all.push_back({out[0][i] != 0, vector_at(out, 1, i), vector_at(out, 4, i), double(as_float(out[7][i]))});
  return all;
}

/// The answers to rays that meet these points of a lamp from outside, along the normals.
std::vector<Stated> stated_at(const StartProbe& probe, std::size_t lamp, const ShapePoints& points) {
  std::vector<Words> rays(7);
  for (std::size_t i = 0; i < points.p.size(); ++i) {
    const glm::dvec3 n = glm::normalize(points.area[i]);
    rays[0].push_back(probe.record(lamp));
    put(rays, 1, points.p[i] + 0.5 * n);
    put(rays, 4, -n);
  }
  return stated_for(probe, rays);
}

/// Density of directions: the cones that one lies in, over the sum of their solid angles. All
/// around within a ball.
class Aim {
 public:
  Aim(const std::vector<float4>& targets, const glm::dvec3& from) {
    for (const float4& ball : targets) {
      const glm::dvec3 way = glm::dvec3(ball.x, ball.y, ball.z) - from;
      const double sine = double(ball.w) / glm::length(way);
      cones_.push_back({glm::normalize(way), sine < 1 ? std::sqrt(1 - sine * sine) : -2});
      solid_angle_ += kTurn * (1 - std::max(cones_.back().cosine, -1.0));
    }
  }
  [[nodiscard]] double pdf_sr(const glm::dvec3& dir) const {
    int met = 0;
    for (const Cone& cone : cones_) met += glm::dot(dir, cone.axis) >= cone.cosine ? 1 : 0;
    return met / solid_angle_;
  }
  /// The density of a direction that lies in one cone alone.
  [[nodiscard]] double least_pdf_sr() const { return 1 / solid_angle_; }

 private:
  struct Cone {
    glm::dvec3 axis;
    double cosine;
  };
  std::vector<Cone> cones_;
  double solid_angle_ = 0;
};

std::string name_of(const std::vector<Shape>& all, std::size_t lamp) {
  return std::string(shape_kind(all[lamp].kind).name) + (is_sheared(lamp) ? ", sheared" : "");
}

TEST(LightPathStarts, M1_points_of_shapes_come_as_densely_as_they_say) {
  const StartProbe probe;
  const std::vector<Shape> all = lamps();
  std::vector<std::vector<double>> observed(all.size(), std::vector<double>(SurfaceCells::kCount + 1, 0.0));
  std::vector<SurfaceCells> cells(all.begin(), all.end());
  for (const Start& start : starts_of(probe)) {
    ASSERT_LT(start.lamp, all.size());
    for (std::size_t lamp = 0; lamp < all.size(); ++lamp)
      ++observed[lamp][start.lamp == lamp ? cells[lamp].of(start.p) : SurfaceCells::kCount];
  }
  double probability = 0;
  for (std::size_t lamp = 0; lamp < all.size(); ++lamp) {
    const ShapePoints points(all[lamp], 4);
    const std::vector<Stated> stated = stated_at(probe, lamp, points);
    std::vector<double> expected(SurfaceCells::kCount + 1, 0.0);
    double of_lamp = 0, area_m2 = 0, least = INFINITY, most = 0;
    for (std::size_t i = 0; i < points.p.size(); ++i) {
      ASSERT_TRUE(stated[i].met && glm::length(stated[i].p - points.p[i]) < 1e-5) << name_of(all, lamp);
      const double share = stated[i].start_m2 * glm::length(points.area[i]);
      expected[cells[lamp].of(points.p[i])] += share * double(kStartCount);
      of_lamp += share;
      area_m2 += glm::length(points.area[i]);
      least = std::min(least, stated[i].start_m2), most = std::max(most, stated[i].start_m2);
    }
    // A shear makes area of round surfaces uneven; all others are chosen evenly.
    const bool is_flat = all[lamp].kind == ShapeKind::box || all[lamp].kind == ShapeKind::plane;
    if (is_flat || !is_sheared(lamp)) {
      EXPECT_NEAR(least * area_m2, of_lamp, 1e-4 * of_lamp) << name_of(all, lamp);
      EXPECT_NEAR(most * area_m2, of_lamp, 1e-4 * of_lamp) << name_of(all, lamp);
    } else {
      EXPECT_GT(most, 1.2 * least) << name_of(all, lamp) << " is not sheared enough to tell";
    }
    expected.back() = double(kStartCount) * (1 - of_lamp);
    probability += of_lamp;
    const ChiSquare test = chi_square(observed[lamp], expected);
    EXPECT_GT(test.p_value, sidak(all.size()))
        << name_of(all, lamp) << ": " << test.statistic << " of " << test.degrees;
  }
  EXPECT_NEAR(probability, 1, 1e-4);
}

/// Cells of starts: by the quarter about the own Y axis of the shape in which a start lies, and by
/// its direction.
struct JointCells {
  static constexpr std::size_t kRows = 12, kColumns = 24, kCount = 4 * kRows * kColumns;

  static std::size_t of(const glm::dvec3& own, const glm::dvec3& dir) {
    const std::size_t quarter = (own.x > 0 ? 1 : 0) + (own.z > 0 ? 2 : 0);
    return (quarter * kRows + cell_of_unit(0.5 - 0.5 * dir.z, kRows)) * kColumns + cell_of_turn(dir.y, dir.x, kColumns);
  }
};

/// Number of starts that are expected in each of JointCells: an integral over a lamp, and over
/// directions. Each point has a grid of its own, shifted at random, so that the rims of cones are
/// met evenly.
std::vector<double> expected_directions(const StartProbe& probe, std::size_t lamp, const Shape& shape,
                                        std::mt19937& random) {
  constexpr std::size_t kRows = 2 * JointCells::kRows, kColumns = 2 * JointCells::kColumns;
  const ShapePoints points(shape, 8);
  const SurfaceCells cells(shape);
  const std::vector<Stated> stated = stated_at(probe, lamp, points);
  std::vector<double> expected(JointCells::kCount, 1e-9);  // cells that a rim grazes are pooled with others
  for (std::size_t i = 0; i < points.p.size(); ++i) {
    const Aim aim(probe.targets(), points.p[i]);
    const glm::dvec3 own = cells.own(points.p[i]);
    const double per_cell =
        double(kStartCount) * stated[i].start_m2 * glm::length(points.area[i]) * 2 * kTurn / double(kRows * kColumns);
    const double down = double(uniform(random)), along = double(uniform(random));
    for (std::size_t row = 0; row < kRows; ++row)
      for (std::size_t column = 0; column < kColumns; ++column) {
        const double z = 1 - 2 * (double(row) + down) / kRows, phi = kTurn * (double(column) + along) / kColumns;
        const double r = std::sqrt(1 - z * z);
        const glm::dvec3 dir(r * std::cos(phi), r * std::sin(phi), z);
        if (const double pdf_sr = aim.pdf_sr(dir); pdf_sr > 0) expected[JointCells::of(own, dir)] += pdf_sr * per_cell;
      }
  }
  return expected;
}

TEST(LightPathStarts, M1_directions_from_shapes_come_as_densely_as_the_cones_of_targets_lie) {
  const StartProbe probe;
  ASSERT_EQ(probe.targets().size(), glass_balls().size());
  const std::vector<Shape> all = lamps();
  const std::vector<SurfaceCells> cells(all.begin(), all.end());
  std::vector<std::vector<double>> observed(all.size(), std::vector<double>(JointCells::kCount, 0.0));
  for (const Start& start : starts_of(probe)) {
    ASSERT_NEAR(glm::length(start.dir), 1, 1e-6);
    ++observed[start.lamp][JointCells::of(cells[start.lamp].own(start.p), start.dir)];
  }
  std::mt19937 random(29);
  for (std::size_t lamp = 0; lamp < all.size(); ++lamp) {
    const std::vector<double> expected = expected_directions(probe, lamp, all[lamp], random);
    const ChiSquare test = chi_square(observed[lamp], expected);
    EXPECT_GT(test.p_value, sidak(all.size()))
        << name_of(all, lamp) << ": " << test.statistic << " of " << test.degrees;
  }
}

TEST(LightPathStarts, M1_throughputs_are_the_light_over_the_density_that_is_told_where_they_are_met) {
  const StartProbe probe;
  const std::vector<Shape> all = lamps();
  const std::vector<Start> starts = starts_of(probe);
  // Rays that come back along the light paths, from a little way off.
  std::vector<Words> rays(7);
  for (const Start& start : starts) {
    rays[0].push_back(probe.record(start.lamp));
    put(rays, 1, start.p + 1e-3 * start.dir);
    put(rays, 4, -start.dir);
  }
  const std::vector<Stated> stated = stated_for(probe, rays);
  std::vector<std::size_t> asked(all.size()), differ(all.size());
  std::size_t overlapping = 0, dark = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const Start& start = starts[i];
    const double cosine = glm::dot(stated[i].n, start.dir);
    if (std::abs(cosine) < 0.05) continue;  // a direction's rounding moves the point by so much more
    ++asked[start.lamp];
    const bool is_dark = !is_sheared(start.lamp) && cosine < 0;
    const Aim aim(probe.targets(), start.p);
    const double pdf_sr = aim.pdf_sr(start.dir);
    const double expected =
        is_dark ? 0 : double(kRadiances[start.lamp]) * std::abs(cosine) / (stated[i].start_m2 * pdf_sr);
    overlapping += pdf_sr > 1.5 * aim.least_pdf_sr() ? 1 : 0;
    dark += is_dark ? 1 : 0;
    const bool is_there = stated[i].met && glm::length(stated[i].p - start.p) < 1e-4;
    const double tolerance = 1e-3 * std::max(1.0, 0.05 / (cosine * cosine));
    if (!is_there || !(std::abs(start.throughput - expected) <= tolerance * expected)) ++differ[start.lamp];
  }
  EXPECT_GT(dark, starts.size() / 10) << "too few leave lamps on the side that does not shine";
  EXPECT_GT(overlapping, starts.size() / 10) << "too few directions lie in several cones";
  for (std::size_t lamp = 0; lamp < all.size(); ++lamp) {
    EXPECT_GT(asked[lamp], std::size_t(10000)) << name_of(all, lamp);
    // Points next to an edge may be met on the face beside it, and a rim of a cone is a matter of
    // rounding.
    EXPECT_LE(differ[lamp], asked[lamp] / 200) << name_of(all, lamp) << ": throughputs other than stated";
  }
}

}  // namespace
}  // namespace eikon::test
