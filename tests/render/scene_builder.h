// SPDX-License-Identifier: Apache-2.0
// Scenes in code, films of them, and the statistics that judge them.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "accel/accel.h"
#include "instruments/analytic_scenes.h"
#include "render/render.h"
#include "support/paths.h"

namespace eikon::test {

inline constexpr double kPi = std::numbers::pi;

// ---- shapes -------------------------------------------------------------------------------------

inline void add_triangle(Primitive& primitive, glm::vec3 a, glm::vec3 b, glm::vec3 c) {
  for (const glm::vec3& corner : {a, b, c}) {
    primitive.indices.push_back(static_cast<std::uint32_t>(primitive.positions_object.size()));
    primitive.positions_object.push_back(corner);
  }
}

/// Closed sphere of rings x 2 rings quads, fronts outside or inside; with normals of its own if
/// `smooth`.
inline Primitive sphere(glm::vec3 center, float radius, std::uint32_t rings, bool inwards, bool smooth = false) {
  Primitive primitive;
  const std::uint32_t columns = 2 * rings;
  for (std::uint32_t i = 0; i <= rings; ++i)
    for (std::uint32_t j = 0; j < columns; ++j) {
      const double theta = std::numbers::pi * i / rings, phi = 2 * std::numbers::pi * j / columns;
      const bool pole = i == 0 || i == rings;  // exactly one point, or the sphere would have two holes
      const glm::vec3 n(pole ? 0.0 : std::sin(theta) * std::cos(phi), pole ? (i == 0 ? 1.0 : -1.0) : std::cos(theta),
                        pole ? 0.0 : std::sin(theta) * std::sin(phi));
      primitive.positions_object.push_back(center + radius * n);
      if (smooth) primitive.normals_object.push_back(inwards ? -n : n);
    }
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    for (std::uint32_t k : {a, inwards ? c : b, inwards ? b : c}) primitive.indices.push_back(k);
  };
  for (std::uint32_t i = 0; i < rings; ++i)
    for (std::uint32_t j = 0; j < columns; ++j) {
      const std::uint32_t next = (j + 1) % columns;
      const std::uint32_t a = i * columns + j, b = i * columns + next, c = (i + 1) * columns + next,
                          d = (i + 1) * columns + j;
      if (i != 0) add(a, b, c);
      if (i + 1 != rings) add(a, c, d);
    }
  return primitive;
}

// ---- scenes -------------------------------------------------------------------------------------

/// An open room with an area light, a sky, a smooth ball, a turned and stretched box and coloured
/// walls. In places most of its light is indirect.
inline std::pair<Scene, Settings> room(std::uint32_t width, std::uint32_t height, std::uint64_t spp) {
  Scene scene;
  Primitive white, red, block, lamp;
  add_quad(white, {-1, -1, 1}, {2, 0, 0}, {0, 0, -2});  // floor
  add_quad(white, {-1, 1, -1}, {2, 0, 0}, {0, 0, 2});   // ceiling
  add_quad(white, {-1, -1, -1}, {2, 0, 0}, {0, 2, 0});  // back
  add_quad(red, {-1, -1, 1}, {0, 0, -2}, {0, 2, 0});    // left; the right side and the front are open
  add_quad(lamp, {-0.3F, 0.95F, -0.2F}, {0.5F, 0, 0}, {0, 0, 0.6F});
  add_box(block, glm::vec3(-0.3F), glm::vec3(0.3F), false);
  add_mesh(scene, "white", std::move(white), lambert(0.75F));
  add_mesh(scene, "red", std::move(red), lambert({0.6F, 0.1F, 0.05F}));
  add_mesh(scene, "lamp", std::move(lamp), lambert({0.2F, 0.3F, 0.4F}, {9, 7, 4}));
  add_mesh(scene, "ball", sphere({0.4F, -0.6F, 0.2F}, 0.35F, 8, false, true), lambert({0.3F, 0.5F, 0.8F}));
  Node& turned = add_mesh(scene, "block", std::move(block), lambert({0.7F, 0.6F, 0.2F}));
  turned.world_from_object =
      glm::rotate(glm::translate(glm::dmat4(1), {-0.4, -0.5, -0.3}), 0.5, glm::dvec3(0.1, 1, 0.05)) *
      glm::scale(glm::dmat4(1), {1.0, 1.6, 0.8});
  Settings settings = settings_for(width, height, spp);
  settings.camera = look_at_camera({0.3, 0.1, 2.6}, {0, -0.1, 0}, {0, 1, 0}, 0.85);
  settings.environment.radiance = {0.3F, 0.4F, 0.6F};
  return {std::move(scene), settings};
}

/// The scene and its camera times `factor`.
inline std::pair<Scene, Settings> times(std::pair<Scene, Settings> original, double factor) {
  for (Node& node : original.first.nodes)
    node.world_from_object = glm::scale(glm::dmat4(1), glm::dvec3(factor)) * node.world_from_object;
  for (Shape& shape : original.first.shapes)
    shape.world_from_object = glm::scale(glm::dmat4(1), glm::dvec3(factor)) * shape.world_from_object;
  glm::dmat4& camera = original.second.camera.world_from_camera;
  camera[3] = glm::dvec4(glm::dvec3(camera[3]) * factor, 1);
  return original;
}

// ---- films --------------------------------------------------------------------------------------

/// Of Execution::extra_flags: kernels as devices are given them, every function inlined.
inline const std::string kAsShipped = " ";

/// With kernels of which functions stay functions, as far as the compiler likes, unless flags are
/// asked for: the same sources and optimisation, and the same arithmetic, since nothing is
/// contracted across functions, and a scene compiles in half the time. That the bits are those of
/// kAsShipped is for the tests of SameBits and ImageVersion, and for those of the command line.
inline Execution as_tested(Execution execution) {
  if (execution.extra_flags.empty() && execution.optimise) execution.extra_flags = "-DEK_OUT_OF_LINE";
  return execution;
}

/// Devices stay open for the renders of a process, with the last programs that they compiled: to
/// look a program up takes the driver half a second. Closed before main returns: drivers do not
/// outlive it.
struct OpenDevices : testing::Environment {
  DevicePool pool;
  void TearDown() override { pool.close_idle(); }
};
inline OpenDevices* const open_devices = static_cast<OpenDevices*>(testing::AddGlobalTestEnvironment(new OpenDevices));

inline RenderOutput output_of(const Scene& scene, const Settings& settings, const Execution& execution = {}) {
  static const std::atomic<bool> never{false};
  return render(scene, settings, as_tested(execution), never, {.devices = &open_devices->pool});
}

/// The film; the test fails if a sample was rejected or the render is not complete.
inline Film film_of(const Scene& scene, const Settings& settings, const Execution& execution = {}) {
  RenderOutput output = output_of(scene, settings, execution);
  EXPECT_EQ(output.report.nonfinite + output.report.saturated, 0U);
  EXPECT_FALSE(output.report.interrupted());
  return std::move(output.film);
}

/// Every layout, and none, at lane widths and with paths in chunks and in queues: what may change
/// no bit of a film.
inline std::vector<Execution> ways_to_trace() {
  std::vector<Execution> ways;
  const auto add = [&](std::uint32_t lanes, bool chunked, const std::string& accel, const std::string& layout) {
    Execution execution;
    execution.lanes = lanes, execution.chunked = chunked;
    execution.accel = accel, execution.layout = layout;
    ways.push_back(execution);
  };
  for (const std::string& layout : tree_layouts()) {
    add(16, true, "bvh", layout);
    add(1, false, "bvh", layout);
  }
  add(8, true, "bvh", "bvh8");
  add(1, true, "bvh", "bvh8");
  add(1, true, "bvh", "bvh2");
  for (const std::string& name : accelerator_names()) {
    if (name == "bvh") continue;
    add(name == "none" ? 8 : 16, true, name, "");
    add(1, false, name, "");
  }
  for (std::uint32_t lanes : {16U, 8U, 1U}) {  // chunks again, with a launch for each stage
    add(lanes, true, "bvh", "bvh8");
    ways.back().fused = false;
  }
  return ways;
}
/// Every accelerator and layout once: wide trees in chunks of 16 lanes, the others in queues of one
/// lane; and a launch for each stage. The tests of hits (tests/kernels) and SameBits have them at
/// all widths.
inline std::vector<Execution> each_way_to_trace() {
  std::vector<Execution> ways = ways_to_trace();
  std::erase_if(ways, [](const Execution& way) {
    const bool wide = way.layout == "bvh16" || way.layout == "bvh8";
    return way.lanes != (wide ? 16U : 1U) || way.chunked != wide;
  });
  return ways;
}
inline std::string describe(const Execution& execution) {
  return std::to_string(execution.lanes.value_or(0)) + " lanes, " + (*execution.chunked ? "chunks, " : "queues, ") +
         (execution.fused.value_or(*execution.chunked) ? "fused, " : "") + execution.accel + " " + execution.layout;
}

/// Whether `part` holds what `whole` holds there.
inline ::testing::AssertionResult same_window(const Film& whole, const Film& part) {
  const Crop& crop = part.layout().crop;
  if (whole.layout().channels != part.layout().channels) return ::testing::AssertionFailure() << "other channels";
  if (whole.layout().mattes != part.layout().mattes) return ::testing::AssertionFailure() << "other mattes";
  for (std::size_t m = 0; m < part.layout().mattes.size(); ++m)
    for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
      for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
        if (whole.matte(m, x, y) != part.matte(m, x, y))
          return ::testing::AssertionFailure() << "pixel " << x << "," << y << ": other counts in matte " << m;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
      for (std::uint32_t r = 0; r < part.layout().replicates; ++r) {
        if (whole.count(x, y, r) != part.count(x, y, r))
          return ::testing::AssertionFailure() << "pixel " << x << "," << y << ": " << whole.count(x, y, r)
                                               << " samples, not " << part.count(x, y, r) << ", in replicate " << r;
        for (std::uint32_t c = 0; c < part.layout().channels.size(); ++c)
          if (whole.sum(x, y, r, c) != part.sum(x, y, r, c))
            return ::testing::AssertionFailure()
                   << "pixel " << x << "," << y << " channel " << part.layout().channels[c] << " replicate " << r
                   << ": " << to_double(whole.sum(x, y, r, c)) << " against " << to_double(part.sum(x, y, r, c));
      }
  return ::testing::AssertionSuccess();
}

/// Whether two films of the same image are equal to the bit, and not empty.
inline ::testing::AssertionResult same_film(const Film& a, const Film& b) {
  if (!(a.layout() == b.layout())) return ::testing::AssertionFailure() << "other layouts";
  const Crop& crop = a.layout().crop;
  if (a.samples(crop.x0, crop.y0) == 0) return ::testing::AssertionFailure() << "no samples";
  return same_window(a, b);
}

// ---- statistics ---------------------------------------------------------------------------------

/// Mean of a channel over a window, and its standard error from the spread between replicates,
/// pixel by pixel: right whatever the pixels expect. Each pixel gives replicates - 1 degrees of
/// freedom, so a window of many pixels knows its error well.
inline MeanAndError mean_of(const Film& film, std::uint32_t channel, Crop window) {
  double sum = 0, variance = 0;
  for (std::uint32_t y = window.y0; y < window.y1; ++y)
    for (std::uint32_t x = window.x0; x < window.x1; ++x) {
      sum += film.mean(x, y, channel);
      variance += film.variance_of_mean(x, y, channel);
    }
  const double n = static_cast<double>(window.pixel_count());
  return {sum / n, std::sqrt(variance) / n};
}
inline MeanAndError mean_of(const Film& film, std::uint32_t channel = 0) {
  return mean_of(film, channel, film.layout().crop);
}

/// |z| that a standard normal variable exceeds with probability `significance` in at least one of
/// `comparisons` [Sidak 1967].
inline double z_bound(int comparisons, double significance = 0.01) {
  const double each = 1 - std::pow(1 - significance, 1.0 / comparisons);
  double lo = 0, hi = 40;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (lo + hi);
    (std::erfc(middle / std::numbers::sqrt2) > each ? lo : hi) = middle;
  }
  return lo;
}

// What float arithmetic along a path of some ten edges may shift a mean by, relative.
inline constexpr double kRounding = 4e-6;

/// Accepts `found` as `expected` at significance 1 % over `comparisons` of the test.
inline ::testing::AssertionResult agrees(const MeanAndError& found, double expected, int comparisons,
                                         double rounding = kRounding) {
  const double tolerance = z_bound(comparisons) * found.sigma + rounding * std::abs(expected);
  // A test with an error bar as wide as the answer proves nothing.
  if (!(tolerance < 0.1 * std::abs(expected)))
    return ::testing::AssertionFailure() << "tolerance " << tolerance << " of " << expected << ": more samples";
  if (std::abs(found.mean - expected) <= tolerance) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << found.mean << " against " << expected << ": off by "
                                       << (found.mean - expected) << ", tolerance " << tolerance;
}

/// Accepts that two independent estimates have one expectation.
inline ::testing::AssertionResult agree(const MeanAndError& a, const MeanAndError& b, int comparisons) {
  return agrees({a.mean, std::hypot(a.sigma, b.sigma)}, b.mean, comparisons);
}

/// Every pixel of the crop shows `expected`: nothing shadows itself, nothing leaks.
inline void expect_constant(const Film& film, double expected, const std::string& what, double tolerance = 4e-6) {
  const Crop& crop = film.layout().crop;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
      ASSERT_NEAR(film.mean(x, y, 0), expected, tolerance * expected) << what << ", pixel " << x << "," << y;
}

/// Under an even sky of 1.
inline Settings settings_under_sky(std::uint32_t side, std::uint64_t spp) {
  Settings settings = settings_for(side, side, spp);
  settings.environment.radiance = glm::vec3(1);
  return settings;
}

inline Scene load_shipped(const std::string& name) {
  return load_scene(std::string(EIKON_SOURCE_DIR) + "/scenes/" + name);
}

/// The scene's own camera and environment.
inline Settings settings_of(const Scene& scene, std::uint32_t side, std::uint64_t spp) {
  Settings settings = settings_for(side, side, spp);
  settings.camera = scene.cameras.at(0);
  if (scene.environment) settings.environment = *scene.environment;
  return settings;
}

}  // namespace eikon::test
