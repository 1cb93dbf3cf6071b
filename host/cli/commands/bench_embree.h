// SPDX-License-Identifier: Apache-2.0
// Embree's single-ray functions as a yardstick. Outside the tests, nothing else uses Embree.
#pragma once
#include <memory>
#include <span>

#include "wavefront/layout/ray_bench.h"
#include "shared/records.h"

namespace eikon {

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
