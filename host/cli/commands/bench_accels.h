// SPDX-License-Identifier: Apache-2.0
// `bench rays --accel all` traces the same rays through every accelerator.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "device/device.h"
#include "pack/features.h"
#include "pack/pack.h"
#include "pack/settings.h"

namespace eikon {

struct AccelBench {
  const Features& features;
  const Settings& settings;
  Execution execution;         // accel and layout are ignored
  std::uint32_t rays, rounds;  // of each kind; the best of which counts
};

/// Prints a line per accelerator: the time to build it, its size, and for camera, shadow and
/// diffuse rays the rays per second, the triangles tested per ray and the steps per ray. `bvh` has
/// two lines: the layout that a render uses, and bvh2, which traces rays one by one as all other
/// accelerators do. Two more lines have other triangle tests. `none` is left out where it would
/// take minutes.
/// results  appends {device, accel, layout, test, build_s, nodes, bytes, rays, mrays_per_s,
///          tests_per_ray, steps_per_ray} per line and kind of ray
/// scene    has no tree when this returns
void bench_accels(Device& device, PackedScene& scene, const AccelBench& bench, nlohmann::json& results);

}  // namespace eikon
