// SPDX-License-Identifier: Apache-2.0
#include "job/report/stats.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/json_dump.h"
#include "job/report/metadata.h"
#include "job/report/result_lines.h"
#include "job/report/stage_table.h"
#include "pack/geometry/instanced_meshes.h"
#include "wavefront/memory_need.h"

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
  return {{"paths", pilot.guiding_paths},
          {"cells", pilot.guiding_cells},
          {"seconds", pilot.seconds},
          {"loaded", pilot.loaded},
          {"gain", pilot.guiding_gain},
          {"roulette_depth", pilot.roulette_depth},
          {"light_trial_paths", pilot.light_trial_paths},
          {"light_path_count", pilot.light_path_count},
          {"light_path_gain", pilot.light_path_gain},
          {"light_aim_gain", pilot.light_aim_gain}};
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

json feature_list_json(const std::vector<FeatureEntry>& features) {
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

RenderFacts facts_of(const Prepared& prepared, const std::string& command) {
  const Scene& scene = *prepared.scene;
  std::map<std::string, std::uint64_t> contents = {
      {"nodes", scene.nodes.size()},         {"meshes", scene.meshes.size()},         {"shapes", scene.shapes.size()},
      {"materials", scene.materials.size()}, {"images", scene.images.size()},         {"lights", scene.lights.size()},
      {"cameras", scene.cameras.size()},     {"animations", scene.animations.size()}, {"skins", scene.skins.size()}};
  return {command, std::move(contents)};
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
      {"ledger", feature_list_json(report.feature_entries)},  // this name is part of schema version 2
      {"scene", scene_json(*prepared.scene, facts)},
      {"size", {settings.width, settings.height}},
      {"sample_range", {settings.sample_begin, settings.sample_end}},
      {"seed", settings.seed},
      {"features", report.features},
      {"triangles", report.triangles},
      {"geometry_bytes", report.geometry_bytes},
      {"film_bytes", film_bytes(done.film.layout())},
      {"tree", report.reinserted ? "reinserted" : "sah"},
      {"interrupted", report.interrupted()},
      {"ended_by", name_of(report.end)},
      {"samples", report.samples},
      {"samples_before", report.samples_before},
      {"samples_per_second", per_second(double(report.samples), report.render_s)},
      {"rejected_samples", report.nonfinite + report.saturated},
      {"rays", rays_json(report.rays)},
      {"rays_per_second", per_second(double(report.rays.total()), report.render_s)},
      {"implicit_search_failures", report.search_failures},
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

void write_stats(const std::filesystem::path& path, const json& stats) { write_text(path, dump_json(stats, 2) + "\n"); }

}  // namespace eikon
