// SPDX-License-Identifier: Apache-2.0
// Traces rays of a scene through one layout of its tree on one device, and times them. Every
// surface counts as opaque.
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

/// Rays as kernels/probe/trace_rays.cl takes them: ten arrays of `stride` words.
struct RayArrays {
  std::vector<float> words;
  std::size_t count = 0, stride = 0;
};

struct RayKind {
  const char* name;
  bool any_hit, coherent;
  RayArrays rays;
};

/// The program that a bench compiles.
struct RayProgram {
  std::string layout;                          // of the tree, which must have been built
  std::map<std::string, std::string> defines;  // that override the usual ones
};

class RayBench {
 public:
  /// Compiles and uploads. throws DeviceError
  RayBench(Device& device, const PackedScene& scene, const Features& features, const Settings& settings,
           const Execution& execution, const RayProgram& of);

  /// Makes `count` camera rays, and shadow and diffuse rays from their hits. Hits, and so rays, are
  /// the same for every layout.
  std::vector<RayKind> make_rays(const Settings& settings, std::uint32_t count);

  /// Uploads the rays of a kind.
  void load(const RayKind& kind);

  /// Traces the loaded rays. returns the seconds from launch to finish; the first call may compile
  double trace(const RayKind& kind);

  /// Triangle tests and steps through the structure per loaded ray, if the program was compiled
  /// with EK_COUNT (kernels/traverse/hit.h). Layouts bvh16 and bvh8 do not count.
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
