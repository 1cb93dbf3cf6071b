// SPDX-License-Identifier: Apache-2.0
#include "pack/geometry/instanced_meshes.h"
#include "pack/pack.h"
#include "render/pilot/pilot.h"
#include "render/ready_wavefronts.h"
#include "render/render.h"
#include "wavefront/memory_need.h"

namespace eikon {
namespace {

// The most paths of a unit: a replay has one path from the camera, but may have many light paths.
constexpr std::uint32_t kMaxReplayPaths = 1U << 14;

}  // namespace

ReplayedSample replay_path(const ReadyScene& scene, const Settings& settings, const Execution& usual,
                           const PixelSample& sample, const std::function<void(const PathVertex&)>& report) {
  Execution execution = usual;
  execution.fused = false;
  DevicePool pool = scene.devices;
  const DeviceInfo info = pool.select(execution.devices, execution.threads).front();
  PackedScene& packed = *scene.packed;
  const Execution own = without_probe(execution);  // one path is too few to measure for
  add_accel(packed, own.accel, configure(info, own).layout, own.threads);
  const Execution small = fit_units(packed, info, scene.features, settings, own, {.most_paths = kMaxReplayPaths});
  require_memory(memory_need(packed, configure(info, small), scene.features, settings), info, own);
  DevicePool::Lease device = pool.take(info);
  Settings guided = settings;
  Features features = scene.features;
  if (wants_pilot(features, settings)) {
    PilotSteps nobody_looks;
    apply(scene.pilot ? *scene.pilot : run_pilot(device, scene.packed, features, settings, own, nobody_looks), features,
          guided);
  }
  guided.crop = {sample.x, sample.y, sample.x + 1, sample.y + 1};  // so that the pixel's unit has all light paths
  Wavefront& wavefront = ReadyWavefronts::of(device).get(device, scene.packed, features, guided, small);
  return wavefront.replay(sample.x, sample.y, sample.sample, report);
}

ReplayedSample replay_path(const Scene& scene, const Settings& settings, const Execution& execution,
                           const PixelSample& sample, const std::function<void(const PathVertex&)>& report) {
  const Features features = features_of(scene, settings, execution);
  const auto packed = std::make_shared<PackedScene>(pack_scene(scene, features, settings));
  return replay_path({.packed = packed, .features = features}, settings, execution, sample, report);
}

}  // namespace eikon
