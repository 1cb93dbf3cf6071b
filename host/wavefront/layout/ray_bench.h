// SPDX-License-Identifier: Apache-2.0
// Rays of a scene through one layout of its tree on one device, timed. Every surface counts as opaque.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "device/device.h"
#include "pack/pack.h"
#include "pack/settings.h"
#include "wavefront/wavefront.h"

namespace eikon {

/// Rays as kernels/probe/trace_rays.cl takes them: nine arrays of `stride` words.
struct RayArrays {
  std::vector<float> words;
  std::size_t count = 0, stride = 0;
};

struct RayKind {
  const char* name;
  bool any_hit, coherent;
  RayArrays rays;
};

class RayBench {
 public:
  /// Compiles for `layout`, whose tree must have been built, and uploads. defines: in place of the usual ones.
  /// throws DeviceError
  RayBench(Device& device, const PackedScene& scene, const Features& features, const Settings& settings,
           const Execution& execution, const std::string& layout,
           const std::map<std::string, std::string>& defines = {});

  /// `count` camera rays, and from their hits shadow and diffuse rays; the same for every layout, since hits are.
  std::vector<RayKind> make_rays(const Settings& settings, std::uint32_t count);

  /// Puts the rays of a kind on the device.
  void load(const RayKind& kind);

  /// Seconds from launch to finish, of the rays that were loaded. The first call may compile.
  double trace(const RayKind& kind);

  /// Per ray, of those that were loaded, where the program was compiled with EK_COUNT (kernels/traverse/hit.h): tests of triangles, and
  /// steps through the structure. Not for layouts bvh16 and bvh8, which do not count.
  struct Counts {
    double tests = 0, steps = 0;
  };
  Counts count(const RayKind& kind);

 private:
  [[nodiscard]] std::size_t chunk() const;
  void run(const std::string& kernel, std::size_t items);
  void launch(const std::string& kernel, std::size_t items);

  Device& device_;
  WavefrontConfig config_;
  Arguments arguments_;
  Buffer hits_;
  std::map<std::string, Kernel> kernels_;
};

}  // namespace eikon
