// SPDX-License-Identifier: Apache-2.0
#include "job/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "job/file_identity.h"
#include "job/report/metadata.h"
#include "core/error.h"
#include "io/atomic_file.h"
#include "io/text.h"
#include "pack/geometry/placed_meshes.h"
#include "shared/records.h"

namespace eikon {
namespace {

using nlohmann::json;

json rays_json(const RayCounts& rays) {
  return {{"camera", rays.camera}, {"scattered", rays.scattered}, {"shadow", rays.shadow}, {"total", rays.total()}};
}

json bounces_json(const Bounces& bounces) {
  json list = json::array();
  for (std::size_t i = 0; i < bounces.size() && bounces[i].slots > 0; ++i)
    list.push_back({{"depth", i + 1},
                    {"paths", bounces[i].paths},
                    {"shadow_rays", bounces[i].shadow_rays},
                    {"lanes", bounces[i].lanes},
                    {"slots", bounces[i].slots}});
  return list;
}

json gaps_json(const StageTotals& gaps) {
  return {{"count", gaps.launches},
          {"seconds", gaps.seconds},
          {"seconds_min", gaps.seconds_min},
          {"seconds_max", gaps.seconds_max}};
}

json stage_json(std::size_t device, const std::map<std::string, StageTotals>& stages, const std::string& name) {
  const StageTotals& s = stages.at(name);
  const std::uint64_t launches = s.launches + s.pieces;
  return {{"device", device},
          {"stage", name},
          {"launches", s.launches},
          {"pieces", s.pieces},
          {"items", s.items},
          {"bytes", s.bytes},
          {"seconds", std::max(0.0, s.seconds)},
          {"seconds_min", s.seconds_min},
          {"seconds_mean", launches > 0 ? launched_seconds(stages, name) / double(launches) : 0},
          {"seconds_max", s.seconds_max}};
}

json layout_rates_json(const std::vector<LayoutRate>& rates) {
  json measured = json::object();
  for (const LayoutRate& one : rates) measured[one.layout] = one.mrays_per_s;
  return measured;
}

json device_json(const RenderReport& report, const DeviceReport& device) {
  return {{"index", device.info.index},
          {"selector", device.info.selector},
          {"name", device.info.name},
          {"driver", device.info.driver},
          {"arithmetic", device.arithmetic.name()},
          {"layout", device.config.layout},
          {"layout_reason", device.layout.why},
          {"layout_mrays_per_s", layout_rates_json(device.layout.rates)},
          {"lanes", device.config.lanes},
          {"samples", device.samples},
          {"repeated_samples", device.repeated_rays.camera},
          {"samples_per_second", per_second(double(device.samples), device.busy_s)},
          {"rays", rays_json(device.rays)},
          {"units", device.units},
          {"device_bytes", device.device_bytes},
          {"upload_bytes", device.upload_bytes},
          {"seconds", device.busy_s},
          {"open_seconds", device.open_s},
          {"compile_seconds", device.compile_s},
          {"upload_seconds", device.upload_s},
          {"idle_at_end_seconds", idle_at_end_s(report, device)},
          {"gaps", gaps_json(device.gaps)},
          {"bounces", bounces_json(device.bounces)}};
}

json events_json(const std::vector<DeviceEvent>& events) {
  json list = json::array();
  for (const DeviceEvent& event : events)
    list.push_back(
        {{"seconds", event.at_s}, {"device", event.device}, {"kind", name_of(event.kind)}, {"text", event.text}});
  return list;
}

json pilot_json(const PilotReport& pilot) {
  if (!pilot.exists()) return nullptr;
  return {{"paths", pilot.paths},
          {"cells", pilot.cells},
          {"seconds", pilot.seconds},
          {"loaded", pilot.loaded},
          {"gain", pilot.gain},
          {"roulette_depth", pilot.roulette_depth},
          {"light_trial_paths", pilot.light_trial_paths},
          {"light_path_count", pilot.light_path_count},
          {"light_path_gain", pilot.light_path_gain}};
}

json seconds_json(const RenderReport& report, const CommandTimes& times) {
  return {{"load", times.load_s},        {"build", report.pack_s + report.build_s},
          {"compile", report.compile_s}, {"upload", report.upload_s},
          {"render", report.render_s},   {"write", times.write_s},
          {"total", times.total_s},      {"first_sample", report.first_sample_s}};
}

/// The settings that the image's header states.
json settings_json(const Prepared& prepared) {
  const Metadata metadata = describe_image(prepared);
  json settings = json::object();
  for (const auto& [name, text] : metadata.strings)
    if (name != "objectNames" && name != "materialNames") settings[name] = text;
  for (const auto& [name, number] : metadata.numbers) settings[name] = number;
  return settings;
}

json ledger_json(const std::vector<FeatureEntry>& features) {
  json list = json::array();
  for (const FeatureEntry& feature : features)
    list.push_back({{"kind", feature.kind}, {"name", feature.name}, {"on", feature.on}, {"reason", feature.reason}});
  return list;
}

json scene_json(const Scene& scene, const RenderFacts& facts) {
  return {{"path", scene.path.string()},
          {"hash", scene.hash},
          {"bytes", scene.file_bytes},
          {"contents", facts.contents},
          {"warnings", scene.warnings}};
}

}  // namespace

std::string in_words(const PredictedError& error) {
  if (!error.known) return "predicted relMSE unknown: it takes two samples per pixel";
  if (std::isfinite(error.hi))
    return fmt::format("predicted relMSE {:.3e} (95 %: {:.3e} to {:.3e})", error.relmse, error.lo, error.hi);
  return error.relmse > 0 ? fmt::format("predicted relMSE at least {:.3e}: no upper end can be stated", error.lo)
                          : "predicted relMSE unknown: no sample has found any light";
}

std::string in_words(const PilotReport& pilot) {
  const auto times = [](double gain) {
    return fmt::format("{:.2f} times less error for as many rays, it predicts", gain);
  };
  std::string text = fmt::format("pilot: {} paths{}", pilot.paths + pilot.light_trial_paths,
                                 pilot.loaded ? ", made before" : fmt::format(" in {:.2f} s", pilot.seconds));
  if (pilot.light_trial_paths > 0 && pilot.light_path_count == 0) text += "; no light paths, as they would not pay";
  if (pilot.light_trial_paths > 0 && pilot.light_path_count > 0)
    text += fmt::format("; {} light paths of each sample ({})", pilot.light_path_count,
                        pilot.light_path_gain > 0 ? times(pilot.light_path_gain) : "only they find some of the light");
  if (pilot.paths > 0)
    text += fmt::format("; {} ({})", pilot.roulette_depth == 0 ? "paths are not guided" : "paths are guided",
                        times(pilot.gain));
  return text;
}

std::string rejected_line(const RenderReport& report, std::uint64_t all) {
  const std::uint64_t now = report.nonfinite + report.saturated;
  std::string line = fmt::format("{} samples were rejected ({} not finite, {} beyond the film's range", all,
                                 report.nonfinite, report.saturated);
  line += all > now ? fmt::format(", {} before this run)", all - now) : ")";
  if (!report.rejected.empty()) {
    const PixelSample& first = report.rejected.front();
    line += fmt::format("; replay the first with --pixel {},{} --sample {}", first.x, first.y, first.sample);
  }
  return line;
}

std::string given_up_line(const Scene& scene, const RenderReport& report) {
  std::string names;
  for (std::size_t i = 0; i < std::min<std::size_t>(scene.shapes.size(), 31); ++i)
    if ((report.given_up_surfaces >> i & 1U) != 0)
      names += (names.empty() ? "" : ", ") + in_quotes(scene.shapes[i].name);
  if ((report.given_up_surfaces >> 31U) != 0) names += names.empty() ? "by formula" : " and others";
  return fmt::format(
      "{} rays gave up the search for surface {} after {} steps, and went on as if it were not there; tighten its "
      "bounds, or "
      "write its formula with fewer occurrences of x, y and z",
      report.given_up, names, EK_IMPLICIT_STEPS);
}

double per_second(double count, double seconds) { return seconds > 0 ? count / seconds : 0; }

RenderFacts facts_of(const Prepared& prepared, const Execution& execution, const std::string& command) {
  const Scene& scene = *prepared.scene;
  std::map<std::string, std::uint64_t> contents = {
      {"nodes", scene.nodes.size()},         {"meshes", scene.meshes.size()},         {"shapes", scene.shapes.size()},
      {"materials", scene.materials.size()}, {"images", scene.images.size()},         {"lights", scene.lights.size()},
      {"cameras", scene.cameras.size()},     {"animations", scene.animations.size()}, {"skins", scene.skins.size()}};
  return {command, std::move(contents), features_of(scene, prepared.settings, execution).ledger()};
}

// stats_schema.json documents each field; a test holds the two together.
json stats_json(const RenderOutput& done, const PredictedError& error, const Prepared& prepared,
                const CommandTimes& times, const RenderFacts& facts) {
  const RenderReport& report = done.report;
  const MeanRadiance mean = done.film.mean_radiance();
  const Settings& settings = prepared.settings;
  json stats = {
      {"schema_version", kStatsSchemaVersion},
      {"version", "eikon " EIKON_VERSION},
      {"command", facts.command},
      {"settings", settings_json(prepared)},
      {"ledger", ledger_json(facts.features)},
      {"scene", scene_json(*prepared.scene, facts)},
      {"size", {settings.width, settings.height}},
      {"sample_range", {settings.sample_begin, settings.sample_end}},
      {"seed", settings.seed},
      {"features", report.features},
      {"triangles", report.triangles},
      {"geometry_bytes", report.geometry_bytes},
      {"tree", report.reinserted ? "reinserted" : "sah"},
      {"interrupted", report.interrupted()},
      {"ended_by", name_of(report.end)},
      {"samples", report.samples},
      {"samples_before", report.samples_before},
      {"samples_per_second", per_second(double(report.samples), report.render_s)},
      {"rejected_samples", report.nonfinite + report.saturated},
      {"rays", rays_json(report.rays)},
      {"rays_per_second", per_second(double(report.rays.total()), report.render_s)},
      {"implicit_search_failures", report.given_up},
      {"relmse_predicted", error.known ? json(error.relmse) : json(nullptr)},
      {"relmse_interval",
       error.known ? json({error.lo, std::isfinite(error.hi) ? json(error.hi) : json(nullptr)}) : json(nullptr)},
      {"mean_radiance", mean.value},
      {"mean_radiance_error", mean.standard_error ? json(*mean.standard_error) : json(nullptr)},
      {"pilot", pilot_json(report.pilot)},
      {"seconds", seconds_json(report, times)},
      {"events", events_json(report.events)},
      {"devices", json::array()},
      {"stages", json::array()}};
  for (std::size_t i = 0; i < report.devices.size(); ++i) {
    const DeviceReport& device = report.devices[i];
    stats["devices"].push_back(device_json(report, device));
    for (const std::string& name : stage_order(device.stages))
      stats["stages"].push_back(stage_json(i, device.stages, name));
  }
  return stats;
}

void write_stats(const std::filesystem::path& path, const json& stats) {
  // Paths on disk need not be UTF-8.
  write_text(path, stats.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  AtomicFile file(path);
  file.write(text.data(), text.size());
  file.commit();
}

void require_writable(const std::vector<std::filesystem::path>& outputs, const std::filesystem::path& input) {
  std::vector<std::filesystem::path> seen;
  for (const std::filesystem::path& path : outputs) {
    if (path.empty()) continue;
    const AtomicFile probe(path);  // made under its temporary name, and removed again
    const std::filesystem::path real = place_of(path);
    if (is_same_file(path, input))
      throw UsageError(fmt::format("cannot write {}: it is the input; choose another name", path.string()));
    if (std::find(seen.begin(), seen.end(), real) != seen.end())
      throw UsageError(
          fmt::format("cannot write {}: two outputs have that name; choose another for one of them", path.string()));
    seen.push_back(real);
  }
}

}  // namespace eikon
