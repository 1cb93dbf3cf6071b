// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "job/report/result_lines.h"
#include "job/report/stage_table.h"

namespace eikon {
namespace {

constexpr std::size_t kBounces = 8;  // have a column of their own

double percent(double part, double whole) { return whole > 0 ? 100 * part / whole : 0; }

std::string bytes_text(std::uint64_t bytes) {
  if (bytes < 10'000) return fmt::format("{} B", bytes);
  if (bytes < 10'000'000) return fmt::format("{:.1f} kB", 1e-3 * double(bytes));
  return fmt::format("{:.1f} MB", 1e-6 * double(bytes));
}

/// The width of the column of names.
std::size_t name_width(const DeviceReport& device) {
  std::size_t width = 10;
  for (const auto& [name, totals] : device.stages) width = std::max(width, name.size());
  return width;
}

void print_stage(const DeviceReport& device, const std::string& name) {
  const StageTotals& s = device.stages.at(name);
  const double launched_s = launched_seconds(device.stages, name), seconds = std::max(0.0, s.seconds);
  const std::string launches = s.launches > 0 ? std::to_string(s.launches) : "in paths";
  fmt::print("  {:<{}} {:>8} {:>13} {:>10.1f} {:>6.1f} {:>9.3f} {:>9.3f} {:>9.3f} {:>9} {:>10}\n", name,
             name_width(device), launches, s.items > 0 ? std::to_string(s.items) : "", 1e3 * seconds,
             percent(seconds, device.busy_s), 1e3 * s.seconds_min,
             1e3 * per_second(launched_s, double(s.launches + s.pieces)), 1e3 * s.seconds_max,
             s.items > 0 ? fmt::format("{:.1f}", 1e-6 * per_second(double(s.items), launched_s)) : "",
             s.bytes > 0 ? bytes_text(s.bytes) : "");
}

void print_stages(const DeviceReport& device) {
  const std::size_t width = name_width(device);
  fmt::print("  {:<{}} {:>8} {:>13} {:>10} {:>6} {:>9} {:>9} {:>9} {:>9} {:>10}\n", "stage", width, "launches", "items",
             "ms", "%", "ms min", "ms mean", "ms max", "Mitems/s", "bytes");
  double in_stages = 0;
  for (const std::string& name : stage_order(device.stages)) {
    in_stages += device.stages.at(name).seconds;
    print_stage(device, name);
  }
  // The rest of the time, which no launch or transfer accounts for, goes into launching and into
  // waiting for the host.
  const double gaps_s = std::max(0.0, device.busy_s - in_stages);
  const StageTotals& gaps = device.gaps;
  fmt::print("  {:<{}} {:>8} {:>13} {:>10.1f} {:>6.1f} {:>9.3f} {:>9.3f} {:>9.3f}\n", "gaps", width, gaps.launches, "",
             1e3 * gaps_s, percent(gaps_s, device.busy_s), 1e3 * gaps.seconds_min, 1e3 * gaps.seconds_mean(),
             1e3 * gaps.seconds_max);
  fmt::print("  {:<{}} {:>8} {:>13} {:>10.1f} {:>6.1f}\n", "all", width, "", "", 1e3 * device.busy_s, 100.0);
}

/// A column for each of the first bounces, and one for all the rest.
std::vector<Bounce> bounce_columns(const Bounces& bounces) {
  std::vector<Bounce> columns;
  for (std::size_t i = 0; i < bounces.size() && bounces[i].slots > 0; ++i) {
    if (i <= kBounces) columns.emplace_back();
    columns.back() += bounces[i];
  }
  return columns;
}

void print_bounces(const DeviceReport& device) {
  const std::vector<Bounce> columns = bounce_columns(device.bounces);
  if (columns.empty()) return;
  fmt::print("  {:<17}", "bounce");
  for (std::size_t i = 0; i < columns.size(); ++i)
    fmt::print("{:>8}", i < kBounces ? std::to_string(i + 1) : fmt::format("{} on", i + 1));
  const double camera = double(columns.front().paths);
  const auto row = [&](const char* what, const auto& value) {
    fmt::print("\n  {:<17}", what);
    for (const Bounce& b : columns) fmt::print("{:>8.1f}", value(b));
  };
  row("paths, %", [&](const Bounce& b) { return percent(double(b.paths), camera); });
  row("shadow rays, %", [&](const Bounce& b) { return percent(double(b.shadow_rays), camera); });
  row("lanes full, %", [](const Bounce& b) { return percent(double(b.paths), double(b.lanes)); });
  row(device.config.chunked ? "chunks full, %" : "queue full, %",
      [](const Bounce& b) { return percent(double(b.paths), double(b.slots)); });
  fmt::print("\n");
}

void print_device(const DeviceReport& device, bool reinserted) {
  if (device.units == 0) {
    fmt::print("device {} {}: got no unit of work\n", device.info.selector, device.info.name);
    return;
  }
  fmt::print("device {} {}: layout {}{} ({}), {} lanes, {} samples in {} units, {:.2f} s\n", device.info.selector,
             device.info.name, device.config.layout, reinserted ? " of a tree improved by reinsertion" : "",
             device.layout.why, device.config.lanes, device.samples, device.units, device.busy_s);
  print_stages(device);
  print_bounces(device);
  fmt::print("  setup: open {:.3f} s, compile {:.3f} s, upload {} in {:.3f} s\n", device.open_s,
             device.compile_s, bytes_text(device.upload_bytes), device.upload_s);
}

void print_devices(const RenderReport& report) {
  fmt::print("{:<32} {:>13} {:>8} {:>11} {:>9} {:>7} {:>8} {:>12}\n", "device", "samples", "share %", "Msamples/s",
             "Mrays/s", "units", "busy, s", "idle at end");
  for (const DeviceReport& device : report.devices)
    fmt::print("{:<32} {:>13} {:>8.1f} {:>11.2f} {:>9.1f} {:>7} {:>8.2f} {:>10.0f}ms\n",
               fmt::format("{} {}", device.info.selector, device.info.name).substr(0, 32), device.samples,
               percent(double(device.samples), double(report.samples)),
               1e-6 * per_second(double(device.samples), device.busy_s),
               1e-6 * per_second(double(device.rays.total()), device.busy_s), device.units, device.busy_s,
               1e3 * idle_at_end_s(report, device));
}

}  // namespace

std::vector<std::string> stage_order(const std::map<std::string, StageTotals>& stages) {
  std::vector<std::string> order;
#define EK_STAGE(name) \
  if (stages.count(#name) != 0) order.push_back(#name);
#include "shared/stages.def"
  const std::vector<std::string> kernels = order;
  for (const auto& [name, totals] : stages)
    if (std::ranges::find(kernels, name) == kernels.end()) order.push_back(name);
  return order;
}

double launched_seconds(const std::map<std::string, StageTotals>& stages, const std::string& name) {
  double seconds = stages.at(name).seconds;
  if (name != "paths") return seconds;
  for (const auto& [other, totals] : stages)
    if (totals.launches == 0) seconds += totals.seconds;
  return seconds;
}

double idle_at_end_s(const RenderReport& report, const DeviceReport& device) {
  double end_s = 0;
  for (const DeviceReport& other : report.devices) end_s = std::max(end_s, other.end_s);
  return device.units > 0 ? end_s - device.end_s : 0;
}

void print_stage_table(const RenderReport& report) {
  for (const DeviceReport& device : report.devices) print_device(device, report.reinserted);
  if (report.devices.size() > 1) print_devices(report);
}

void print_times(const RenderReport& report, const CommandTimes& times) {
  fmt::print(
      "seconds: load {:.3f}, pack {:.3f}, build {:.3f}, compile {:.3f}, upload {:.3f}, render {:.3f}, write {:.3f}; "
      "{:.3f} from the command's start\n",
      times.load_s, report.pack_s, report.build_s, report.compile_s, report.upload_s, report.render_s, times.write_s,
      times.total_s);
}

}  // namespace eikon
