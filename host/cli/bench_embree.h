// SPDX-License-Identifier: Apache-2.0
// Embree's single-ray functions as a yardstick; the only place outside the tests that knows Embree.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "shared/records.h"

namespace eikon {

/// Rays as kernels/trace_rays.cl takes them: seven arrays of `stride` floats.
struct RayArrays {
  std::vector<float> words;
  std::size_t count = 0, stride = 0;
};

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
