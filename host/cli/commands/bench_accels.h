// SPDX-License-Identifier: Apache-2.0
// `bench rays --accel all`: the same rays through every accelerator.
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
  Execution execution;         // accel and layout count for nothing
  std::uint32_t rays, rounds;  // of each kind; the best of which counts
};

/// Prints a line per accelerator: time to build, size, and for camera, shadow and diffuse rays how many are traced in a second, how
/// many triangles each is tested against, and how many steps it takes. `bvh` stands there twice: in the layout that a
/// render uses, and as bvh2, whose rays go one by one as those of all others do. Behind it the same with other tests of triangles.
/// Appends {device, accel, layout, test, build_s, nodes, bytes, rays, mrays_per_s, tests_per_ray, steps_per_ray} per line and kind.
/// `none` is left out of scenes where it would take minutes. Leaves no tree in `scene`.
void bench_accels(Device& device, PackedScene& scene, const AccelBench& bench, nlohmann::json& results);

}  // namespace eikon
