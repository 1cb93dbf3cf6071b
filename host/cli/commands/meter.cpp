// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "cli/commands/meter.h"
#include "cli/flags.h"
#include "job/prepare.h"
#include "io/atomic_file.h"
#include "job/file_identity.h"
#include "job/report/result_lines.h"
#include "job/stop_signals.h"
#include "instruments/meter.h"
#include "pack/lights/pack_light_paths.h"
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

/// A reading, and the meter and the number of paths that it was taken with.
struct Measurement {
  Meter meter;
  Reading reading;
  double side_m = 0;                      // of the square over which it is a mean
  std::uint64_t paths = 0, rejected = 0;  // paths: without the rejected ones

  [[nodiscard]] bool is_irradiance() const { return meter.quantity == Meter::Quantity::irradiance; }
  [[nodiscard]] const char* quantity() const { return is_irradiance() ? "irradiance" : "radiance"; }
};

/// Returns nothing if `stop` was set before the end.
std::optional<Measurement> take_reading(const MeterOptions& options, const Log& log, const std::atomic<bool>& stop) {
  const Meter meter = meter_of(options);
  Prepared prepared = prepare(options.scene, log);
  if (only_light_paths_find_some(*prepared.scene))
    log("the reading lacks what bulbs, spots and suns send by way of mirrors or smooth glass, because a meter "
        "traces no light paths; to see that light, render a diffuse surface there with --light-paths 4");
  const double side_m = aim(meter, *prepared.scene, prepared.settings);
  const RenderOutput output = render_and_release(*prepared.scene, prepared.settings, options.execution, stop);
  if (output.report.interrupted()) return std::nullopt;
  const std::uint64_t rejected = output.report.nonfinite + output.report.saturated;
  if (rejected > 0) {
    RenderReport report = output.report;
    report.rejected.clear();  // `render` replays those of its own pictures
    const std::string line = rejected_line(report, rejected);
    if (options.scene.strict) throw InputError(fmt::format("{}: {} (--strict)", options.scene.scene, line));
    if (rejected == output.report.samples)
      throw InputError(fmt::format("{}: {}; nothing is left to be read", options.scene.scene, line));
    log(line + "; the reading is without them");
  }
  return Measurement{meter, read(meter, output.film), side_m, output.report.samples - rejected, rejected};
}

std::string to_json(const Measurement& measured) {
  const auto list = [](const glm::dvec3& v) { return nlohmann::json{v.x, v.y, v.z}; };
  const nlohmann::json out = {{"quantity", measured.quantity()},
                              {"unit", measured.is_irradiance() ? "W/m^2" : "W/(sr m^2)"},
                              {"at", list(measured.meter.at)},
                              {"direction", list(measured.meter.direction)},
                              {"value", list(measured.reading.value)},
                              {"standard_error", list(measured.reading.sigma)},
                              {"side", measured.side_m},
                              {"paths", measured.paths},
                              {"rejected", measured.rejected}};
  return out.dump() + "\n";
}

ExitCode meter_command(MeterOptions options) {
  receive_signals();
  require_writable({options.json}, {.scene = options.scene.scene, .files = {options.scene.environment.map}});
  read_execution_environment(options.execution);
  const auto measured = take_reading(options, log_unless(false), catch_stop_signals());
  if (!measured) return stop_exit_code();
  if (!options.json.empty()) {
    write_text(options.json, to_json(*measured));
    return ExitCode::done;
  }
  const Meter& meter = measured->meter;
  const Reading& reading = measured->reading;
  fmt::print("{} at ({}, {}, {}) {} ({:g}, {:g}, {:g}), {}, over {:.2g} x {:.2g} m, of {} paths\n",
             measured->quantity(), meter.at.x, meter.at.y, meter.at.z, measured->is_irradiance() ? "facing" : "from",
             meter.direction.x, meter.direction.y, meter.direction.z,
             measured->is_irradiance() ? "W/m^2 (lx)" : "W/(sr m^2) (cd/m^2)", measured->side_m, measured->side_m,
             measured->paths);
  for (int c = 0; c < 3; ++c) fmt::print("  {} {:.6g} +- {:.2g}\n", "RGB"[c], reading.value[c], reading.sigma[c]);
  return ExitCode::done;
}

void add_meter_flags(CommandFlags& flags, MeterOptions& options) {
  add_scene_flags(flags, options.scene);
  flags.text({"--at", "X,Y,Z", "where, in metres (required)"}, options.at);
  flags.text({"--facing", "X,Y,Z", "normal of the receiver: measures irradiance, W/m^2"}, options.facing);
  flags.text({"--from", "X,Y,Z", "direction that light comes from: measures radiance, W/(sr m^2)"}, options.from);
  flags.require("--at");
  options.scene.size = kGrid;
  options.scene.spp = 256;
  add_light_flags(flags, options.scene, "paths of each of the 256 pixels that measure independently [256]");
  add_execution_flags(flags, options.execution, true);
  flags.group("Output");
  flags.json(options.json, "print one line of JSON, or write it to FILE");
}

}  // namespace

std::optional<std::string> meter_json(std::vector<std::string> words, const Log& log, const std::atomic<bool>& stop) {
  MeterOptions options;
  (void)parse_words(words, [&](CommandFlags flags) { add_meter_flags(flags, options); });
  if (!options.json.empty()) throw UsageError("--json: the figures are what eikon.meter returns; leave it out");
  read_execution_environment(options.execution);
  const auto measured = take_reading(options, log, stop);
  return measured ? std::optional(to_json(*measured)) : std::nullopt;
}

void add_meter(CommandFlags& root, Command& chosen) {
  auto options = std::make_shared<MeterOptions>();
  CommandFlags flags = root.command(
      "meter", "measure irradiance at a point, or radiance along a ray, with its standard error",
      "Example:\n  eikon meter scenes/cornell.gltf --at 0.278,0.001,0.28 --facing 0,1,0\n\n" + environment_help());
  add_meter_flags(flags, *options);
  flags.run(chosen, [options] { return meter_command(*options); });
}

}  // namespace eikon
