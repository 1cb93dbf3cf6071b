// SPDX-License-Identifier: Apache-2.0
// Embree's single-ray functions as a yardstick; the only place outside the tests that knows Embree.
#pragma once
#include <memory>
#include <span>

#include "wavefront/layout/ray_bench.h"
#include "shared/records.h"

namespace eikon {

class EmbreeYardstick {
 public:
  /// Builds a scene with Embree's defaults (quality medium, not its robust mode) and `threads` threads.
  /// throws UsageError when eikon was built without Embree
  EmbreeYardstick(std::span<const Triangle> triangles, unsigned threads);
  ~EmbreeYardstick();
  EmbreeYardstick(const EmbreeYardstick&) = delete;
  EmbreeYardstick& operator=(const EmbreeYardstick&) = delete;

  [[nodiscard]] double build_s() const;
  /// Seconds for one rtcIntersect1 (closest) or rtcOccluded1 (any) per ray, on all threads.
  double trace(const RayArrays& rays, bool any_hit) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace eikon
