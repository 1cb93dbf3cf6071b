// SPDX-License-Identifier: Apache-2.0
// `bench rays` compares with every accelerator (--accel all) and with Embree (--versus embree).
#pragma once
#include <memory>
#include <span>
#include <nlohmann/json_fwd.hpp>

#include "wavefront/layout/ray_bench.h"

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

/// Embree's single-ray functions as a yardstick. Outside the tests, nothing else uses Embree.
class EmbreeYardstick {
 public:
  /// Builds a scene with `threads` threads and Embree's defaults: quality medium, not robust.
  /// throws UsageError when eikon was built without Embree
  EmbreeYardstick(std::span<const Triangle> triangles, unsigned threads);
  ~EmbreeYardstick();
  EmbreeYardstick(const EmbreeYardstick&) = delete;
  EmbreeYardstick& operator=(const EmbreeYardstick&) = delete;

  [[nodiscard]] double build_s() const;
  /// Calls rtcIntersect1, or rtcOccluded1 if any hit will do, for each ray. Returns the seconds.
  double trace(const RayArrays& rays, bool any_hit) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace eikon
