// SPDX-License-Identifier: Apache-2.0
#include "render/selftest.h"

#include <cmath>
#include <fmt/format.h>
#include <functional>

#include "core/error.h"
#include "render/arithmetic.h"
#include "render/render.h"

namespace eikon {
namespace {

/// Two triangles p, p + a, p + a + b, p + b; the front is the side from which they turn anticlockwise.
void add_quad(Primitive& primitive, glm::vec3 p, glm::vec3 a, glm::vec3 b) {
  const auto first = std::uint32_t(primitive.positions_object.size());
  for (const glm::vec3& corner : {p, p + a, p + a + b, p + b}) primitive.positions_object.push_back(corner);
  for (std::uint32_t i : {0U, 1U, 2U, 0U, 2U, 3U}) primitive.indices.push_back(first + i);
}

void add_mesh(Scene& scene, const char* name, Primitive primitive, const Material& material) {
  primitive.material = std::uint32_t(scene.materials.size());
  scene.materials.push_back(material);
  scene.materials.back().name = name;
  Node node;
  node.name = name;
  node.mesh = std::uint32_t(scene.meshes.size());
  scene.meshes.push_back({name, {std::move(primitive)}});
  scene.nodes.push_back(node);
}

Material lambert(float albedo, float emission) {
  Material material;
  material.base_color = glm::vec3(albedo);
  material.metallic = 0;
  material.specular = 0;
  material.emission = glm::vec3(emission);
  return material;
}

/// Closed cube of side 2 around the origin, seen from inside; every point has radiance Le / (1 - albedo).
Scene furnace(float albedo, float emission) {
  Primitive cube;
  for (int axis = 0; axis < 3; ++axis) {
    glm::vec3 n(0), a(0), b(0);
    n[axis] = 1, a[(axis + 1) % 3] = 2, b[(axis + 2) % 3] = 2;
    add_quad(cube, -n - 0.5F * (a + b), a, b);  // faces inwards
    add_quad(cube, n - 0.5F * (a + b), b, a);
  }
  Scene scene;
  add_mesh(scene, "cube", std::move(cube), lambert(albedo, emission));
  return scene;
}

/// Floor y = 0 under a unit square light at height 1 that faces down; seen from above, beside the light.
Scene square_light() {
  Scene scene;
  Primitive floor, light;
  add_quad(floor, {-0.01F, 0, 0.01F}, {0.02F, 0, 0}, {0, 0, -0.02F});
  add_quad(light, {-0.5F, 1, -0.5F}, {1, 0, 0}, {0, 0, 1});
  add_mesh(scene, "floor", std::move(floor), lambert(1, 0));
  add_mesh(scene, "light", std::move(light), lambert(0, 1));
  return scene;
}

Settings settings_for(std::uint32_t side, std::uint64_t spp) {
  Settings settings;
  settings.width = settings.height = side;
  settings.crop = {0, 0, side, side};
  settings.sample_end = spp;
  return settings;
}

struct MeanAndError {
  double mean = 0, sigma = 0;
};

/// Mean of the red channel over all pixels, and the standard deviation of that mean between pixels.
MeanAndError mean_of(const Film& film) {
  const Crop& crop = film.layout().crop;
  double sum = 0, squares = 0;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x) {
      const double value = film.mean(x, y, 0);
      sum += value;
      squares += value * value;
    }
  const double n = double(crop.pixel_count());
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / n)};
}

// Within five standard deviations, and never stricter than what float radiance can hold.
Check compare(const std::string& name, const Film& film, double expected) {
  const MeanAndError found = mean_of(film);
  const double tolerance = 5 * found.sigma + 1e-5 * expected;
  return {name, std::abs(found.mean - expected) <= tolerance,
          fmt::format("{:.6f} against {:.6f} (tolerance {:.1e})", found.mean, expected, tolerance)};
}

bool same_bits(const Film& a, const Film& b) {
  const Crop& crop = a.layout().crop;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
      for (std::uint32_t r = 0; r < a.layout().replicates; ++r)
        for (std::uint32_t c = 0; c < a.layout().channels.size(); ++c)
          if (a.sum(x, y, r, c) != b.sum(x, y, r, c)) return false;
  return true;
}

}  // namespace

std::vector<Check> selftest(const DeviceInfo& info, const Execution& execution) {
  std::vector<Check> checks;
  const auto check = [&](const std::string& name, const std::function<Check()>& body) {
    try {
      checks.push_back(body());
    } catch (const std::exception& error) {
      checks.push_back({name, false, error.what()});
    }
  };
  Execution on_device = execution;
  on_device.devices = std::to_string(info.index);
  const std::atomic<bool> never{false};
  const auto film_of = [&](const Scene& scene, const Settings& settings, const Execution& how) {
    return render(scene, settings, how, never).film;
  };

  check("record layout", [&]() -> Check {
    Device device(info);
    check_record_layout(device);
    return {"record layout", true, "as on the host"};
  });
  for (std::uint32_t lanes : {1U, 8U, 16U}) {
    const std::string name = fmt::format("arithmetic, {} lanes", lanes);
    check(name, [&]() -> Check {
      Device device(info);
      const ArithmeticClass found = probe_arithmetic(device, lanes, execution.optimise);
      return {name, found.exact(), fmt::format("class {}", found.name())};
    });
  }
  check("furnace", [&] {
    Settings settings = settings_for(16, 64);
    return compare("furnace", film_of(furnace(0.5F, 0.5F), settings, on_device), 1.0);
  });
  check("square light", [&] {
    Settings settings = settings_for(16, 256);
    settings.camera = look_at_camera({0, 0.9, 0.001}, {0, 0, 0}, {0, 1, 0}, 0.01);
    // E / L = 0.752274688 for the unit square at height 1; the floor reflects E / pi.
    return compare("square light", film_of(square_light(), settings, on_device), 0.752274688 / 3.14159265358979);
  });
  check("wide and narrow", [&]() -> Check {
    const Settings settings = settings_for(24, 8);
    Execution wide = on_device, narrow = on_device;
    wide.chunked = true, wide.lanes = 16, wide.layout = "bvh8";
    narrow.chunked = false, narrow.layout = "bvh2";
    const bool same = same_bits(film_of(furnace(0.8F, 1), settings, wide), film_of(furnace(0.8F, 1), settings, narrow));
    return {"wide and narrow", same, same ? "the same bits" : "16 lanes over bvh8 and queues over bvh2 differ"};
  });
  return checks;
}

}  // namespace eikon
