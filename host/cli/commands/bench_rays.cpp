// SPDX-License-Identifier: Apache-2.0
// `bench rays` measures rays per second by layout and kind of ray, beside Embree in the same run.
// Every surface counts as opaque. The JSON is an array of
//   {device, accel, layout, default, rays: camera|shadow|diffuse, mrays_per_s, embree_mrays_per_s,
//    build_s, embree_build_s, bytes, tests_per_ray, steps_per_ray}
// With --count, the last two are the tests of triangles and the steps through the tree; bvh16 and
// bvh8 do not count. `default` says whether a render on this device would use that layout; `bytes`
// counts tree and geometry on the device. With --accel all it is a table of accelerators: see
// bench.h.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/commands.h"
#include "cli/commands/bench.h"
#include "cli/flags.h"
#include "device/device.h"
#include "job/prepare.h"
#include "io/atomic_file.h"
#include "io/json_dump.h"
#include "job/file_identity.h"
#include "pack/geometry/instanced_meshes.h"
#include "pack/pack.h"
#include "wavefront/layout/ray_bench.h"

namespace eikon {
namespace {

struct BenchRaysOptions {
  SceneOptions scene;
  Execution execution;
  std::string versus, json;
  std::uint32_t rays = 1U << 20, rounds = 5;
  bool count = false;
};

/// A packed scene, the settings that its rays come from, and the results so far.
struct Bench {
  const BenchRaysOptions& options;
  const Settings& settings;
  const Features& features;
  PackedScene& scene;
  nlohmann::json rows = nlohmann::json::array();
};

void print_header() {
  fmt::print("{:<24} {:<6} {:<8} {:>9} {:>9} {:>7} {:>9} {:>9} {:>12} {:>6} {:>6}\n", "device", "layout", "rays",
             "Mrays/s", "Embree", "ratio", "build s", "Embree s", "bytes", "tests", "steps");
}

void print_row(const nlohmann::json& row) {
  const auto number = [&](const char* key, int digits) {
    return row[key].is_null() ? std::string("-") : fmt::format("{:.{}f}", row[key].get<double>(), digits);
  };
  const bool versus = !row["embree_mrays_per_s"].is_null();
  fmt::print(
      "{:<24.24} {:<6} {:<8} {:>9} {:>9} {:>7} {:>9} {:>9} {:>12} {:>6} {:>6}\n", row["device"].get<std::string>(),
      row["layout"].get<std::string>(), row["rays"].get<std::string>(), number("mrays_per_s", 2),
      number("embree_mrays_per_s", 2),
      versus ? fmt::format("{:.2f}", row["mrays_per_s"].get<double>() / row["embree_mrays_per_s"].get<double>()) : "-",
      number("build_s", 3), number("embree_build_s", 3), row["bytes"].get<std::uint64_t>(), number("tests_per_ray", 1),
      number("steps_per_ray", 1));
}

/// Measures all kinds of rays through one layout of the tree; the best of some rounds counts.
void bench_layout(Bench& bench, Device& device, const std::string& layout, bool is_default,
                  const EmbreeYardstick* embree) {
  const Execution& execution = bench.options.execution;
  add_accel(bench.scene, execution.accel, layout, execution.threads, expected_rays(bench.settings));
  const Accel& accel = bench.scene.accels.at(layout);
  RayBench tracer(device, bench.scene, bench.features, bench.settings, execution, {layout, {}});
  std::optional<RayBench> counting;
  if (bench.options.count && layout != "bvh16" && layout != "bvh8")
    counting.emplace(device, bench.scene, bench.features, bench.settings, execution,
                     RayProgram{layout, {{"EK_COUNT", "1"}}});
  for (const RayKind& kind : tracer.make_rays(bench.settings, bench.options.rays)) {
    double seconds = 1e300, embree_seconds = 1e300;
    tracer.load(kind);
    tracer.trace(kind);  // compiles
    for (std::uint32_t round = 0; round < bench.options.rounds; ++round) {
      seconds = std::min(seconds, tracer.trace(kind));
      if (embree != nullptr) embree_seconds = std::min(embree_seconds, embree->trace(kind.rays, kind.any_hit));
    }
    const double millions = 1e-6 * double(kind.rays.count);
    nlohmann::json row = {{"device", device.info().name},
                          {"accel", accel.name},
                          {"layout", layout},
                          {"default", is_default},
                          {"rays", kind.name},
                          {"mrays_per_s", millions / seconds},
                          {"embree_mrays_per_s", nullptr},
                          {"build_s", accel.build_s},
                          {"embree_build_s", nullptr},
                          {"bytes", bench.scene.bytes(layout)},
                          {"tests_per_ray", nullptr},
                          {"steps_per_ray", nullptr}};
    if (counting) {
      counting->load(kind);
      const RayBench::Counts found = counting->count(kind);
      row["tests_per_ray"] = found.tests;
      row["steps_per_ray"] = found.steps;
    }
    if (embree != nullptr) {
      row["embree_mrays_per_s"] = millions / embree_seconds;
      row["embree_build_s"] = embree->build_s();
    }
    print_row(row);
    bench.rows.push_back(std::move(row));
  }
}

void bench_device(Bench& bench, const DeviceInfo& info) {
  Device device(info);
  const Execution& execution = bench.options.execution;
  Execution plain = execution;
  plain.accel = "bvh";
  plain.layout.clear();
  const std::string usual = configure(info, plain).layout;
  const bool all = execution.layout.empty() && execution.accel == "bvh";
  std::optional<EmbreeYardstick> embree;
  if (!bench.options.versus.empty()) embree.emplace(bench.scene.triangles, std::max(info.compute_units, 1U));
  for (const std::string& layout : all ? tree_layouts() : std::vector{configure(info, execution).layout})
    if (!bench.features.has(Feature::instance) || has_two_levels(layout))
      bench_layout(bench, device, layout, layout == usual, embree ? &*embree : nullptr);
}

/// throws UsageError if flags do not go together or with this scene, InputError if there are no
/// triangles
void require_comparable(const BenchRaysOptions& options, const PackedScene& scene) {
  if (scene.triangles.empty()) throw InputError(options.scene.scene + ": there is no triangle to trace rays against");
  if (!options.versus.empty() && !scene.shapes.empty())
    throw UsageError(
        fmt::format("--versus embree compares triangles alone, and {} has {} shapes by their equations; leave it out, "
                    "or use a scene of meshes",
                    options.scene.scene, scene.shapes.size()));
  if (options.execution.accel != kEveryAccelerator) return;
  if (options.count) throw UsageError("--accel all counts by itself; leave out --count");
  if (!options.versus.empty()) throw UsageError("--accel all has no column for --versus; leave out one of them");
  if (!options.execution.layout.empty()) throw UsageError("--accel all shows layouts of its own; leave out --layout");
}

ExitCode bench_rays_command(BenchRaysOptions options) {
  read_execution_environment(options.execution);
  require_writable({options.json}, {.scene = options.scene.scene, .files = {options.scene.environment.map}});
  Prepared prepared = prepare(options.scene, log_unless(true));
  const Settings& settings = prepared.settings;
  const Features features = features_of(*prepared.scene, settings, options.execution);
  PackedScene scene = pack_and_release(*prepared.scene, features, settings);
  require_comparable(options, scene);
  Bench bench{options, settings, features, scene};
  if (options.execution.accel == kEveryAccelerator) {
    for (const DeviceInfo& info : select_devices(options.execution.devices)) {
      Device device(info);
      bench_accels(device, scene, {features, settings, options.execution, options.rays, options.rounds}, bench.rows);
    }
  } else {
    print_header();
    for (const DeviceInfo& info : select_devices(options.execution.devices, options.execution.threads))
      bench_device(bench, info);
  }
  if (!options.json.empty()) write_text(options.json, dump_json(bench.rows, 2) + "\n");
  return ExitCode::done;
}

}  // namespace

void add_bench_rays(CommandFlags& bench, Command& chosen) {
  auto options = std::make_shared<BenchRaysOptions>();
  CommandFlags flags = bench.command(
      "rays", "measure rays per second by layout of the tree and kind of ray; every surface counts as opaque",
      "Examples:\n  eikon bench rays scenes/cornell.gltf --versus embree --json rays.json\n"
      "  eikon bench rays scenes/cornell.gltf --accel all\n\n" +
          environment_help());
  add_all_scene_flags(flags, options->scene);
  flags.hide({"--strict", "--transparent", "--aov", "--cull", "--energy-compensation"});
  add_execution_flags(flags, options->execution, false, true);
  flags.choice({"--versus", "embree", "also trace the same rays with Embree, on as many threads"}, options->versus,
               std::vector<std::string>{"embree"});
  flags.group("Output (- is standard output)");
  flags.text({"--json", "FILE", "write the results as JSON"}, options->json);
  flags.number({"--rays", "N", "rays of each kind [1048576]"}, options->rays, 16, 1U << 26);
  flags.number({"--rounds", "N", "rounds, of which the best counts [5]"}, options->rounds, 1, 1000);
  flags.toggle("--count", "also count tests of triangles and steps through the tree, per ray", options->count);
  flags.run(chosen, [options] { return bench_rays_command(*options); });
}

}  // namespace eikon
