// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "accel/accel.h"
#include "cli/commands/bench.h"

namespace eikon {
namespace {

constexpr std::size_t kMaxByBruteForce = 4096;  // triangles

struct Row {
  std::string accel, layout, test;  // test: "" is the watertight one
  std::map<std::string, std::string> defines;
};

std::vector<Row> rows(const std::string& usual, std::size_t triangles) {
  std::vector<Row> all;
  for (const Accelerator& each : accelerators()) {
    const std::string name = each.name;
    if (name == "none" && triangles > kMaxByBruteForce) continue;
    if (name == "bvh" && usual != "bvh2") all.push_back({name, usual, "", {}});
    all.push_back({name, each.layout == nullptr ? "bvh2" : each.layout, "", {}});
  }
  // All scalar layouts share one function for the triangle test, so it is enough to vary it in
  // bvh2.
  all.push_back({"bvh", "bvh2", "Moller-Trumbore", {{"EK_TRIANGLE_TEST", "1"}}});
  all.push_back({"bvh", "bvh2", "plane, 3 crosses", {{"EK_TRIANGLE_TEST", "2"}}});
  return all;
}

bool counts(const std::string& layout) { return layout != "bvh16" && layout != "bvh8"; }

void print_title() {
  fmt::print("{:<14} {:<7} {:<16} {:>8} {:>9} {:>12}", "accel", "layout", "triangle test", "build s", "nodes", "bytes");
  for (const char* kind : {"camera", "shadow", "diffuse"}) fmt::print(" | {:>8} {:>6} {:>6}", kind, "tests", "steps");
  fmt::print("\n{:<71}", "");
  for (int kind = 0; kind < 3; ++kind) fmt::print(" | {:>8} {:>6} {:>6}", "Mrays/s", "a ray", "a ray");
  fmt::print("\n");
}

}  // namespace

void bench_accels(Device& device, PackedScene& scene, const AccelBench& bench, nlohmann::json& results) {
  Execution plain = bench.execution;
  plain.accel = "bvh";
  plain.layout.clear();
  const std::string usual = configure(device.info(), plain).layout;
  fmt::print("{}: {} triangles\n", device.info().name, scene.triangles.size());
  print_title();
  std::vector<RayKind> kinds;  // made once: all accelerators find the same hits
  for (const Row& row : rows(usual, scene.triangles.size())) {
    scene.accels.clear();
    add_accel(scene, row.accel, row.layout, bench.execution.threads, expected_rays(bench.settings));
    const Accel& accel = scene.accels.at(row.layout);
    RayBench timed(device, scene, bench.features, bench.settings, plain, {row.layout, row.defines});
    if (kinds.empty()) kinds = timed.make_rays(bench.settings, bench.rays);
    fmt::print("{:<14} {:<7} {:<16} {:>8.3f} {:>9} {:>12}", row.accel, row.layout,
               row.test.empty() ? "watertight" : row.test, accel.build_s, accel.node_count, accel.bytes());
    std::optional<RayBench> counting;
    if (counts(row.layout)) {
      std::map<std::string, std::string> defines = row.defines;
      defines["EK_COUNT"] = "1";
      counting.emplace(device, scene, bench.features, bench.settings, plain, RayProgram{row.layout, defines});
    }
    for (const RayKind& kind : kinds) {
      timed.load(kind);
      timed.trace(kind);  // compiles
      double seconds = 1e300;
      for (std::uint32_t round = 0; round < bench.rounds; ++round) seconds = std::min(seconds, timed.trace(kind));
      nlohmann::json line = {{"device", device.info().name},
                             {"accel", row.accel},
                             {"layout", row.layout},
                             {"test", row.test.empty() ? "watertight" : row.test},
                             {"build_s", accel.build_s},
                             {"nodes", accel.node_count},
                             {"bytes", accel.bytes()},
                             {"rays", kind.name},
                             {"mrays_per_s", 1e-6 * double(kind.rays.count) / seconds},
                             {"tests_per_ray", nullptr},
                             {"steps_per_ray", nullptr}};
      fmt::print(" | {:>8.2f}", line["mrays_per_s"].get<double>());
      if (counting) {
        counting->load(kind);
        const RayBench::Counts found = counting->count(kind);
        line["tests_per_ray"] = found.tests;
        line["steps_per_ray"] = found.steps;
        fmt::print(" {:>6.1f} {:>6.1f}", found.tests, found.steps);
      } else {
        fmt::print(" {:>6} {:>6}", "-", "-");
      }
      results.push_back(std::move(line));
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
  if (scene.triangles.size() > kMaxByBruteForce)
    fmt::print("none is left out: every ray against {} triangles\n", scene.triangles.size());
  scene.accels.clear();
}

}  // namespace eikon
