// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "cli/execution_options.h"
#include "cli/scene_options.h"
#include "job/stop_signals.h"
#include "instruments/meter.h"
#include "render/render.h"

namespace eikon {
namespace {

constexpr const char* kGrid = "16x16";  // pixels that measure apart

struct MeterOptions {
  SceneOptions scene;
  Execution execution;
  std::string at, facing, from;
  bool json = false;
};

Meter meter_of(const MeterOptions& options) {
  if (options.facing.empty() == options.from.empty())
    throw UsageError("eikon meter: give --facing NORMAL for irradiance, or --from DIRECTION for radiance");
  const auto vector_of = [](const char* flag, const std::string& text) {
    const std::vector<double> n = parse_numbers(flag, text, 3);
    return glm::dvec3(n[0], n[1], n[2]);
  };
  Meter meter;
  meter.at = vector_of("--at", options.at);
  const bool is_irradiance = !options.facing.empty();
  meter.quantity = is_irradiance ? Meter::Quantity::irradiance : Meter::Quantity::radiance;
  const char* const flag = is_irradiance ? "--facing" : "--from";
  const std::string& text = is_irradiance ? options.facing : options.from;
  const glm::dvec3 direction = vector_of(flag, text);
  const double length = glm::length(direction);
  if (!(length > 0 && std::isfinite(length))) throw UsageError(fmt::format("{} {}: is no direction", flag, text));
  meter.direction = direction / length;
  return meter;
}

ExitCode meter_command(MeterOptions options) {
  receive_signals();
  read_execution_environment(options.execution);
  const Meter meter = meter_of(options);
  Prepared prepared = prepare(options.scene, say_on_stderr(options.json));
  aim(meter, *prepared.scene, prepared.settings);
  const RenderOutput output =
      render_and_release(*prepared.scene, prepared.settings, options.execution, catch_stop_signals());
  if (output.report.interrupted) return stop_exit_code();
  const Reading reading = read(meter, output.film);
  const bool is_irradiance = meter.quantity == Meter::Quantity::irradiance;
  const char* const quantity = is_irradiance ? "irradiance" : "radiance";
  if (options.json) {
    const auto list = [](const glm::dvec3& v) { return nlohmann::json{v.x, v.y, v.z}; };
    const nlohmann::json out = {{"quantity", quantity},          {"unit", is_irradiance ? "W/m^2" : "W/(sr m^2)"},
                                {"at", list(meter.at)},          {"direction", list(meter.direction)},
                                {"value", list(reading.value)},  {"standard_error", list(reading.sigma)},
                                {"paths", output.report.samples}};
    fmt::print("{}\n", out.dump());
    return ExitCode::done;
  }
  fmt::print("{} at ({:g}, {:g}, {:g}) {} ({:g}, {:g}, {:g}), {}, of {} paths\n", quantity, meter.at.x, meter.at.y,
             meter.at.z, is_irradiance ? "facing" : "from", meter.direction.x, meter.direction.y, meter.direction.z,
             is_irradiance ? "W/m^2 (lx)" : "W/(sr m^2) (cd/m^2)", output.report.samples);
  for (int c = 0; c < 3; ++c) fmt::print("  {} {:.6g} +- {:.2g}\n", "RGB"[c], reading.value[c], reading.sigma[c]);
  return ExitCode::done;
}

}  // namespace

void add_meter(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<MeterOptions>();
  CLI::App* command =
      app.add_subcommand("meter", "irradiance at a point of a scene, or radiance along a ray, with its standard error");
  options->scene.add_scene_to(*command);
  command->add_option("--at", options->at, "X,Y,Z: where, in metres")->required();
  command->add_option("--facing", options->facing, "X,Y,Z: normal of the receiver: irradiance, W/m^2");
  command->add_option("--from", options->from, "X,Y,Z: direction that light comes from: radiance, W/(sr m^2)");
  options->scene.add_environment_to(*command);
  options->scene.spp = 256;
  options->scene.add_sampling_to(*command, "paths of each of the 256 pixels that measure apart");
  add_execution_options(*command, options->execution, true);
  command->add_flag("--json", options->json, "one line of JSON");
  options->scene.size = kGrid;
  command->footer("Example:\n  eikon meter scenes/cornell.gltf --at 0,0.01,0 --facing 0,1,0");
  command->callback([options, &chosen] { chosen = [options] { return meter_command(*options); }; });
}

}  // namespace eikon
