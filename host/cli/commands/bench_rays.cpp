// SPDX-License-Identifier: Apache-2.0
// `bench rays`: rays per second by layout and kind of ray, beside Embree in the same run. Every surface counts as opaque.
// --json: an array of {accel, layout, default, rays: camera|shadow|diffuse, mrays_per_s, embree_mrays_per_s, build_s,
// embree_build_s, bytes}; `default`: what a render on this device would use; bytes: tree and geometry on the device. With --accel all
// instead a table of accelerators: bench_accels.h.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/arguments.h"
#include "cli/commands/bench.h"
#include "cli/commands/bench_accels.h"
#include "cli/commands/bench_embree.h"
#include "cli/execution_options.h"
#include "job/report.h"
#include "cli/scene_options.h"
#include "device/device.h"
#include "pack/pack.h"
#include "pack/geometry/placed_meshes.h"
#include "wavefront/layout/ray_bench.h"
#include "wavefront/wavefront.h"

namespace eikon {
namespace {

struct BenchOptions {
  SceneOptions scene;
  Execution execution;
  std::string versus, json;
  std::uint32_t rays = 1U << 20, rounds = 5;
};

ExitCode bench_rays_command(BenchOptions options) {
  read_execution_environment(options.execution);
  if (!options.versus.empty() && options.versus != "embree") {
    throw UsageError(fmt::format("--versus {}: takes embree", options.versus));
  }
  require_writable({options.json}, options.scene.scene);
  Prepared prepared = prepare(options.scene, say_on_stderr(true));
  const Features features = features_of(*prepared.scene, prepared.settings, options.execution);
  PackedScene scene = pack_and_release(*prepared.scene, features, prepared.settings);
  if (scene.triangles.empty()) throw InputError(options.scene.scene + ": there is no triangle to trace rays against");

  if (!options.versus.empty() && !scene.shapes.empty())
    throw UsageError(
        fmt::format("--versus embree compares triangles alone, and {} has {} shapes by their equations; leave it out, "
                    "or use a scene of meshes",
                    options.scene.scene, scene.shapes.size()));

  nlohmann::json results = nlohmann::json::array();
  if (options.execution.accel == kEveryAccelerator) {
    if (!options.versus.empty()) throw UsageError("--accel all has no column for --versus; leave out one of them");
    if (!options.execution.layout.empty()) throw UsageError("--accel all shows layouts of its own; leave out --layout");
    for (const DeviceInfo& info : select_devices(options.execution.devices)) {
      Device device(info);
      bench_accels(device, scene, {features, prepared.settings, options.execution, options.rays, options.rounds},
                   results);
    }
    if (!options.json.empty()) write_text(options.json, results.dump(2) + "\n");
    return ExitCode::done;
  }
  fmt::print("{:<24} {:<6} {:<8} {:>9} {:>9} {:>7} {:>9} {:>9} {:>12}\n", "device", "layout", "rays", "Mrays/s",
             "Embree", "ratio", "build s", "Embree s", "bytes");
  for (const DeviceInfo& info : select_devices(options.execution.devices, options.execution.threads)) {
    Device device(info);
    const std::string chosen = configure(info, options.execution).layout;
    Execution plain = options.execution;
    plain.accel = "bvh";
    plain.layout.clear();
    const std::string usual = configure(info, plain).layout;
    const bool all = options.execution.layout.empty() && options.execution.accel == "bvh";
    std::optional<EmbreeYardstick> embree;
    if (!options.versus.empty()) embree.emplace(scene.triangles, std::max(info.compute_units, 1U));
    std::vector<std::string> layouts = all ? tree_layouts() : std::vector<std::string>{chosen};
    for (const std::string& layout : layouts) {
      if (features.has(Feature::instance) && !has_two_levels(layout)) continue;
      add_accel(scene, options.execution.accel, layout, options.execution.threads, expected_rays(prepared.settings));
      RayBench bench(device, scene, features, prepared.settings, options.execution, {layout, {}});
      for (const RayKind& kind : bench.make_rays(prepared.settings, options.rays)) {
        double seconds = 1e300, embree_seconds = 1e300;  // of the best round
        bench.load(kind);
        bench.trace(kind);  // compiles
        for (std::uint32_t round = 0; round < options.rounds; ++round) {
          seconds = std::min(seconds, bench.trace(kind));
          if (embree) embree_seconds = std::min(embree_seconds, embree->trace(kind.rays, kind.any_hit));
        }
        const double millions = 1e-6 * double(kind.rays.count);
        const Accel& accel = scene.accels.at(layout);
        nlohmann::json row = {
            {"device", info.name},           {"accel", accel.name},      {"layout", layout},
            {"default", layout == usual},    {"rays", kind.name},        {"mrays_per_s", millions / seconds},
            {"embree_mrays_per_s", nullptr}, {"build_s", accel.build_s}, {"embree_build_s", nullptr},
            {"bytes", scene.bytes(layout)}};
        if (embree) {
          row["embree_mrays_per_s"] = millions / embree_seconds;
          row["embree_build_s"] = embree->build_s();
        }
        const auto number = [&](const char* key, int digits) {
          return row[key].is_null() ? std::string("-") : fmt::format("{:.{}f}", row[key].get<double>(), digits);
        };
        fmt::print("{:<24.24} {:<6} {:<8} {:>9} {:>9} {:>7} {:>9} {:>9} {:>12}\n", info.name, layout, kind.name,
                   number("mrays_per_s", 2), number("embree_mrays_per_s", 2),
                   embree ? fmt::format("{:.2f}", embree_seconds / seconds) : "-", number("build_s", 3),
                   number("embree_build_s", 3), scene.bytes(layout));
        results.push_back(std::move(row));
      }
    }
  }
  if (!options.json.empty()) write_text(options.json, results.dump(2) + "\n");
  return ExitCode::done;
}

}  // namespace

void add_bench_rays(CLI::App& bench, Command& chosen) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* rays = bench.add_subcommand(
      "rays", "camera, shadow and diffuse-bounce rays per second, by layout of the tree; surfaces as opaque");
  options->scene.add_to(*rays);
  add_execution_options(*rays, options->execution, false, true);
  rays->add_option("--versus", options->versus,
                   "embree: its rtcIntersect1 and rtcOccluded1 on the same rays, as many threads");
  rays->add_option("--json", options->json, "write the results to a file");
  rays->add_option("--rays", options->rays, "of each kind")->check(between(16U, 1U << 26))->capture_default_str();
  rays->add_option("--rounds", options->rounds, "the best of which counts")
      ->check(between(1U, 1000U))
      ->capture_default_str();
  rays->footer(
      "Example:\n  eikon bench rays scenes/cornell.gltf --versus embree --json rays.json\n  eikon bench rays "
      "scenes/cornell.gltf --accel all");
  rays->callback([options, &chosen] { chosen = [options] { return bench_rays_command(*options); }; });
}

}  // namespace eikon
