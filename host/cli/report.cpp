// SPDX-License-Identifier: Apache-2.0
#include "cli/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "image/atomic_file.h"

namespace eikon {
namespace {

using nlohmann::json;

// Kernels in the order of the wavefront; the rest (transfers) in the order of names.
std::vector<std::string> stage_order(const std::map<std::string, StageTotals>& stages) {
  std::vector<std::string> order;
#define EK_STAGE(name) \
  if (stages.count(#name) != 0) order.push_back(#name);
#include "shared/stages.def"
  const std::size_t kernels = order.size();
  for (const auto& [name, totals] : stages)
    if (std::find(order.begin(), order.begin() + std::ptrdiff_t(kernels), name) ==
        order.begin() + std::ptrdiff_t(kernels))
      order.push_back(name);
  return order;
}

double total_seconds(const DeviceReport& device) {
  double seconds = 0;
  for (const auto& [name, totals] : device.stages) seconds += totals.seconds;
  return seconds;
}

double rate(double count, double seconds) { return seconds > 0 ? count / seconds : 0; }

}  // namespace

void print_stage_table(const RenderReport& report) {
  for (const DeviceReport& device : report.devices) {
    if (device.units == 0) {
      fmt::print("device {} {}: no unit of work reached it\n", device.info.index, device.info.name);
      continue;
    }
    fmt::print("device {} {}: layout {}{} ({}), {} lanes, {} samples, {:.2f} s\n", device.info.index, device.info.name,
               device.config.layout, report.reinserted ? " of a tree improved by reinsertion" : "", device.layout.why,
               device.config.lanes, device.samples, device.busy_s);
    fmt::print("  {:<10} {:>8} {:>13} {:>10} {:>6} {:>9} {:>9} {:>9}\n", "stage", "launches", "items", "ms", "%",
               "ms min", "ms max", "Mitems/s");
    const double wall = device.busy_s;
    for (const std::string& name : stage_order(device.stages)) {
      const StageTotals& s = device.stages.at(name);
      fmt::print("  {:<10} {:>8} {:>13} {:>10.1f} {:>6.1f} {:>9.3f} {:>9.3f} {:>9.1f}\n", name, s.launches,
                 s.bytes > 0 ? fmt::format("{} B", s.bytes) : std::to_string(s.items), 1e3 * s.seconds,
                 100 * rate(s.seconds, wall), 1e3 * s.seconds_min, 1e3 * s.seconds_max,
                 s.bytes > 0 ? 0.0 : 1e-6 * rate(double(s.items), s.seconds));
    }
    // What no launch or transfer accounts for: launch cost, waiting, adding to the film.
    const double gap = std::max(0.0, wall - total_seconds(device));
    fmt::print("  {:<10} {:>8} {:>13} {:>10.1f} {:>6.1f}\n", "between", "", "", 1e3 * gap, 100 * rate(gap, wall));
  }
}

// {
//   "samples": n (of this run), "samples_before": n (in the checkpoint that it began with), "samples_per_second": x,
//   "rays": {"camera", "scattered", "shadow", "total"}, "rays_per_second": x,
//   "relmse_predicted": x | null, "relmse_interval": [lo, hi] | null,
//   "rejected_samples": n, "interrupted": bool, "features": "..", "triangles": n, "geometry_bytes": n,
//   "tree": "sah" | "reinserted",
//   "seconds": {"load", "build", "compile", "upload", "render", "write", "first_sample", "total"},
//   "scene": {"path", "hash"}, "size": [w, h], "sample_range": [a, b], "seed": n,
//   "devices": [{"index", "name", "driver", "arithmetic", "layout", "layout_why", "layout_mrays_per_s": {layout: x},
//                "lanes", "samples", "units", "device_bytes", "seconds", "compile_seconds", "upload_seconds"}],
//   "stages": [{"device", "stage", "launches", "items", "bytes", "seconds", "seconds_min", "seconds_max"}]
//             stages that ran within the launches of "paths" have no launches; "paths" then has the time that is none of theirs
// }
void write_stats(const std::filesystem::path& path, const RenderReport& report, const PredictedError& error,
                 const Prepared& prepared, const CommandTimes& times) {
  json stats;
  stats["samples"] = report.samples;
  stats["samples_before"] = report.samples_before;
  stats["samples_per_second"] = rate(double(report.samples), report.render_s);
  stats["rays"] = {{"camera", report.rays.camera},
                   {"scattered", report.rays.scattered},
                   {"shadow", report.rays.shadow},
                   {"total", report.rays.total()}};
  stats["rays_per_second"] = rate(double(report.rays.total()), report.render_s);
  stats["relmse_predicted"] = error.known ? json(error.relmse) : json(nullptr);
  stats["relmse_interval"] = error.known ? json({error.lo, error.hi}) : json(nullptr);
  stats["rejected_samples"] = report.nonfinite + report.saturated;
  stats["interrupted"] = report.interrupted;
  stats["features"] = report.features;
  stats["triangles"] = report.triangles;
  stats["geometry_bytes"] = report.geometry_bytes;
  stats["tree"] = report.reinserted ? "reinserted" : "sah";
  stats["seconds"] = {{"load", times.load_s},
                      {"build", report.pack_s + report.build_s},
                      {"compile", report.compile_s},
                      {"upload", report.upload_s},
                      {"render", report.render_s},
                      {"write", times.write_s},
                      {"first_sample", report.first_sample_s},
                      {"total", times.total_s}};
  const Settings& settings = prepared.settings;
  stats["scene"] = {{"path", prepared.scene->path.string()}, {"hash", prepared.scene->hash}};
  stats["size"] = {settings.width, settings.height};
  stats["sample_range"] = {settings.sample_begin, settings.sample_end};
  stats["seed"] = settings.seed;
  stats["devices"] = json::array();
  stats["stages"] = json::array();
  for (const DeviceReport& device : report.devices) {
    json measured = json::object();
    for (const LayoutRate& rate : device.layout.rates) measured[rate.layout] = rate.mrays_per_s;
    stats["devices"].push_back({{"index", device.info.index},
                                {"name", device.info.name},
                                {"driver", device.info.driver},
                                {"arithmetic", device.arithmetic.name()},
                                {"layout", device.config.layout},
                                {"layout_why", device.layout.why},
                                {"layout_mrays_per_s", measured},
                                {"lanes", device.config.lanes},
                                {"samples", device.samples},
                                {"units", device.units},
                                {"device_bytes", device.device_bytes},
                                {"seconds", device.busy_s},
                                {"compile_seconds", device.compile_s},
                                {"upload_seconds", device.upload_s}});
    for (const std::string& name : stage_order(device.stages)) {
      const StageTotals& s = device.stages.at(name);
      stats["stages"].push_back({{"device", device.info.index},
                                 {"stage", name},
                                 {"launches", s.launches},
                                 {"items", s.items},
                                 {"bytes", s.bytes},
                                 {"seconds", s.seconds},
                                 {"seconds_min", s.seconds_min},
                                 {"seconds_max", s.seconds_max}});
    }
  }
  // Paths on disk need not be UTF-8.
  write_text(path, stats.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

void write_profile(const std::filesystem::path& path, const RenderReport& report) {
  json events = json::array();
  for (const DeviceReport& device : report.devices) {
    const int track = int(device.info.index) + 1;
    events.push_back({{"ph", "M"},
                      {"pid", 1},
                      {"tid", track},
                      {"name", "thread_name"},
                      {"args", {{"name", fmt::format("device {} {}", device.info.index, device.info.name)}}}});
    for (const Span& span : device.spans)
      events.push_back({{"ph", "X"},
                        {"pid", 1},
                        {"tid", track},
                        {"name", span.name},
                        {"cat", "device"},
                        {"ts", 1e6 * span.begin_s},
                        {"dur", 1e6 * (span.end_s - span.begin_s)}});
  }
  write_text(path, json{{"traceEvents", events}, {"displayTimeUnit", "ms"}}.dump(-1, ' ', false,
                                                                                 json::error_handler_t::replace) +
                       "\n");
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  AtomicFile file(path);
  file.write(text.data(), text.size());
  file.commit();
}

void require_writable(const std::vector<std::filesystem::path>& outputs, const std::filesystem::path& input) {
  // Of a relative path that does not exist yet, weakly_canonical alone makes no absolute one.
  const auto place = [](const std::filesystem::path& path) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path));
  };
  std::vector<std::filesystem::path> seen = {place(input)};
  for (const std::filesystem::path& path : outputs) {
    if (path.empty()) continue;
    const AtomicFile asked(path);  // made under its temporary name, and removed again
    const std::filesystem::path real = place(path);
    if (real == seen.front())
      throw UsageError(fmt::format("cannot write {}: it is the input; choose another name", path.string()));
    if (std::find(seen.begin(), seen.end(), real) != seen.end())
      throw UsageError(
          fmt::format("cannot write {}: two outputs have that name; choose another for one of them", path.string()));
    seen.push_back(real);
  }
}

}  // namespace eikon
