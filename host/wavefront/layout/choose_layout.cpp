// SPDX-License-Identifier: Apache-2.0
#include "wavefront/layout/choose_layout.h"

#include <fmt/format.h>

#include <algorithm>

#include "accel/accel.h"
#include "core/error.h"
#include "pack/geometry/instanced_meshes.h"
#include "wavefront/layout/ray_bench.h"

namespace eikon {
namespace {

constexpr double kMinGain = 1.03;          // runs of the same kernel differ by about this
constexpr double kGpuRaysPerSecond = 3e8;  // of a medium GPU; a guess, as none could be measured
constexpr double kMinSeconds = 20;         // of a render that is probed
constexpr double kMinShare = 10;           // of a render that is probed, in lengths of the probe
constexpr double kCompileSeconds = 1, kTrianglesPerSecond = 1e6;          // of one more program, and of one more tree
constexpr std::uint32_t kChunkedRays = 1U << 16, kQueuedRays = 1U << 18;  // of each kind: milliseconds of work
constexpr int kRounds = 3;

/// Measures rays of all kinds through `layout`, and takes the best of some rounds.
LayoutRate measure(Device& device, const PackedScene& packed, const Features& features, const Settings& settings,
                   const Execution& execution, const std::string& layout) {
  RayBench bench(device, packed, features, settings, execution, {layout, {}});
  const std::uint32_t ray_count = configure(device.info(), execution).chunked ? kChunkedRays : kQueuedRays;
  double seconds = 0, rays = 0;
  for (const RayKind& kind : bench.make_rays(settings, ray_count)) {
    if (kind.rays.count == 0) continue;
    bench.load(kind);
    bench.trace(kind);  // compiles
    double best = bench.trace(kind);
    for (int round = 1; round < kRounds; ++round) best = std::min(best, bench.trace(kind));
    seconds += best;
    rays += double(kind.rays.count);
  }
  return {layout, seconds > 0 ? 1e-6 * rays / seconds : 0};
}

/// The layouts to measure on a device with that many lanes. Nodes in whole vectors are for devices
/// that have vectors.
std::vector<std::string> candidates_for(std::uint32_t lanes) {
  std::vector<std::string> candidates;
  for (const std::string& layout : tree_layouts()) {
    const bool vectors = layout == "bvh8" || layout == "bvh16";
    if (vectors == (lanes > 1)) candidates.push_back(layout);
  }
  return candidates;
}

/// True if measuring that many layouts takes a small part of the render's time.
bool probe_pays(std::size_t candidates, std::size_t triangles, double rays) {
  const double seconds = rays / kGpuRaysPerSecond;
  const double cost = double(candidates) * (kCompileSeconds + double(triangles) / kTrianglesPerSecond);
  return seconds >= kMinSeconds && seconds >= kMinShare * cost;
}

}  // namespace

Execution without_probe(const Execution& execution) {
  Execution plain = execution;
  if (plain.layout == kProbeLayouts) plain.layout.clear();
  return plain;
}

LayoutPlan plan_layout(const WavefrontConfig& config, const Execution& execution, std::size_t triangles, double rays,
                       bool two_level) {
  LayoutPlan plan{config.layout, "asked for", {}};
  const bool asked_to_probe = execution.layout == kProbeLayouts;
  if (!own_layout(execution.accel).empty() || (!execution.layout.empty() && !asked_to_probe)) return plan;
  plan.why = config.lanes > 1 ? fmt::format("usual for {} lanes", config.lanes) : "usual for one lane";
  std::vector<std::string> candidates = candidates_for(config.lanes);
  if (two_level) std::erase_if(candidates, [](const std::string& layout) { return !has_two_levels(layout); });
  const bool pays = !config.chunked && probe_pays(candidates.size(), triangles, rays);
  if (triangles > 0 && candidates.size() > 1 && (asked_to_probe || pays)) plan.measure = candidates;
  return plan;
}

LayoutChoice fastest_layout(std::vector<LayoutRate> rates, const std::string& usual) {
  LayoutChoice choice{usual, "usual; nothing could be measured", {}};
  if (rates.empty()) return choice;
  const auto fastest = std::ranges::max_element(rates, {}, &LayoutRate::mrays_per_s);
  const auto known = std::ranges::find(rates, usual, &LayoutRate::layout);
  const bool gains = known == rates.end() || fastest->mrays_per_s > kMinGain * known->mrays_per_s;
  if (gains) choice.layout = fastest->layout;
  choice.why = "measured, Mrays/s:";
  for (const LayoutRate& rate : rates) choice.why += fmt::format(" {} {:.1f}", rate.layout, rate.mrays_per_s);
  choice.rates = std::move(rates);
  return choice;
}

LayoutChoice choose_layout(const DeviceInfo& info, PackedScene& packed, const Features& features,
                           const Settings& settings, const Execution& execution) {
  const Execution plain = without_probe(execution);
  const WavefrontConfig config = configure(info, plain);
  const LayoutPlan plan =
      plan_layout(config, execution, packed.triangles.size(), expected_rays(settings), features.has(Feature::instance));
  const auto add = [&](const std::string& layout) {
    add_accel(packed, execution.accel, layout, execution.threads, expected_rays(settings));
  };
  LayoutChoice choice{plan.layout, plan.why, {}};
  if (!plan.measure.empty()) {
    std::vector<std::string> only_measured;
    std::vector<LayoutRate> rates;
    Device device(info);
    for (const std::string& layout : plan.measure) {
      if (packed.accels.count(layout) == 0) only_measured.push_back(layout);
      add(layout);
      try {
        rates.push_back(measure(device, packed, features, settings, plain, layout));
      } catch (const DeviceError&) {
        // The layout does not fit, or does not compile here. The render goes on with another one.
      }
    }
    choice = fastest_layout(std::move(rates), plan.layout);
    for (const std::string& layout : only_measured)
      if (layout != choice.layout) packed.accels.erase(layout);
  }
  add(choice.layout);
  return choice;
}

}  // namespace eikon
