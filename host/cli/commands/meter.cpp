// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "cli/flags.h"
#include "job/prepare.h"
#include "job/report/report.h"
#include "job/stop_signals.h"
#include "instruments/meter.h"
#include "render/render.h"

namespace eikon {
namespace {

constexpr ImageSize kGrid{16, 16};  // pixels that measure independently

struct MeterOptions {
  SceneOptions scene;
  Execution execution;
  std::string at, facing, from, json;
};

Meter meter_of(const MeterOptions& options) {
  if (options.facing.empty() == options.from.empty())
    throw UsageError("eikon meter: give --facing NORMAL for irradiance, or --from DIRECTION for radiance");
  Meter meter;
  meter.at = parse_vector("--at", options.at);
  const bool is_irradiance = !options.facing.empty();
  meter.quantity = is_irradiance ? Meter::Quantity::irradiance : Meter::Quantity::radiance;
  const char* const flag = is_irradiance ? "--facing" : "--from";
  const std::string& text = is_irradiance ? options.facing : options.from;
  const glm::dvec3 direction = parse_vector(flag, text);
  const double length = glm::length(direction);
  if (!(length > 0 && std::isfinite(length))) throw UsageError(fmt::format("{} {}: is no direction", flag, text));
  meter.direction = direction / length;
  return meter;
}

ExitCode meter_command(MeterOptions options) {
  receive_signals();
  require_writable({options.json}, options.scene.scene);
  read_execution_environment(options.execution);
  const Meter meter = meter_of(options);
  Prepared prepared = prepare(options.scene, log_unless(!options.json.empty()));
  aim(meter, *prepared.scene, prepared.settings);
  const RenderOutput output =
      render_and_release(*prepared.scene, prepared.settings, options.execution, catch_stop_signals());
  if (output.report.interrupted()) return stop_exit_code();
  const Reading reading = read(meter, output.film);
  const bool is_irradiance = meter.quantity == Meter::Quantity::irradiance;
  const char* const quantity = is_irradiance ? "irradiance" : "radiance";
  if (!options.json.empty()) {
    const auto list = [](const glm::dvec3& v) { return nlohmann::json{v.x, v.y, v.z}; };
    const nlohmann::json out = {{"quantity", quantity},          {"unit", is_irradiance ? "W/m^2" : "W/(sr m^2)"},
                                {"at", list(meter.at)},          {"direction", list(meter.direction)},
                                {"value", list(reading.value)},  {"standard_error", list(reading.sigma)},
                                {"paths", output.report.samples}};
    write_text(options.json, out.dump() + "\n");
    return ExitCode::done;
  }
  fmt::print("{} at ({:g}, {:g}, {:g}) {} ({:g}, {:g}, {:g}), {}, of {} paths\n", quantity, meter.at.x, meter.at.y,
             meter.at.z, is_irradiance ? "facing" : "from", meter.direction.x, meter.direction.y, meter.direction.z,
             is_irradiance ? "W/m^2 (lx)" : "W/(sr m^2) (cd/m^2)", output.report.samples);
  for (int c = 0; c < 3; ++c) fmt::print("  {} {:.6g} +- {:.2g}\n", "RGB"[c], reading.value[c], reading.sigma[c]);
  return ExitCode::done;
}

}  // namespace

void add_meter(CommandFlags& root, Command& chosen) {
  auto options = std::make_shared<MeterOptions>();
  CommandFlags flags =
      root.command("meter", "measure irradiance at a point, or radiance along a ray, with its standard error",
                   "Example:\n  eikon meter scenes/cornell.gltf --at 0.278,0.001,0.28 --facing 0,1,0\n\n" +
                       environment_help());
  add_scene_flags(flags, options->scene);
  flags.text({"--at", "X,Y,Z", "where, in metres (required)"}, options->at);
  flags.text({"--facing", "X,Y,Z", "normal of the receiver: measures irradiance, W/m^2"}, options->facing);
  flags.text({"--from", "X,Y,Z", "direction that light comes from: measures radiance, W/(sr m^2)"}, options->from);
  flags.require("--at");
  options->scene.size = kGrid;
  options->scene.spp = 256;
  add_light_flags(flags, options->scene, "paths of each of the 256 pixels that measure independently [256]");
  add_execution_flags(flags, options->execution, true);
  flags.group("Output");
  flags.json(options->json, "print one line of JSON, or write it to FILE");
  flags.run(chosen, [options] { return meter_command(*options); });
}

}  // namespace eikon
