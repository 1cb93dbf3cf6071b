// SPDX-License-Identifier: Apache-2.0
#include "instruments/selftest.h"

#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <numbers>

#include "device/probes.h"
#include "instruments/analytic_scenes.h"
#include "render/render.h"

namespace eikon {
namespace {

// A value passes within five standard deviations, but never stricter than the precision of float.
Check compare(const std::string& name, const Film& film, double expected) {
  const MeanAndError found = mean_between_pixels(film, 0);
  const double tolerance = 5 * found.sigma + 1e-5 * expected;
  return {name, std::abs(found.mean - expected) <= tolerance,
          fmt::format("{:.6f} against {:.6f} (tolerance {:.1e})", found.mean, expected, tolerance)};
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
  on_device.devices = info.selector;
  const std::atomic<bool> never{false};
  const auto film_of = [&](const Scene& scene, const Settings& settings, const Execution& how) {
    return render(scene, settings, how, never).film;
  };

  check("record layout", [&]() -> Check {
    Device device(info);
    check_record_layout(device, execution.optimise);
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
    Settings settings = settings_for(16, 16, 64);
    return compare("furnace", film_of(furnace(0.5F, 0.5F), settings, on_device), 1.0);
  });
  check("square light", [&] {
    Settings settings = settings_for(16, 16, 256);
    settings.camera = look_at_camera({0, 0.9, 0.001}, {0, 0, 0}, {0, 1, 0}, 0.01);
    // The floor reflects E / pi.
    return compare("square light", film_of(square_light(), settings, on_device),
                   kSquareLightIrradiance / std::numbers::pi);
  });
  check("wide and narrow", [&]() -> Check {
    const Settings settings = settings_for(24, 24, 8);
    Execution wide = on_device, narrow = on_device;
    wide.chunked = true, wide.lanes = 16, wide.layout = "bvh16";
    narrow.chunked = false, narrow.layout = "bvh2";
    const bool same = same_bits(film_of(furnace(0.8F, 1), settings, wide), film_of(furnace(0.8F, 1), settings, narrow));
    return {"wide and narrow", same, same ? "the same bits" : "16 lanes over bvh16 and queues over bvh2 differ"};
  });
  return checks;
}

}  // namespace eikon
