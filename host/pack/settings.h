// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/thread_limit.h"
#include "core/trace.h"
#include "film/film.h"
#include "film/pixel_filter.h"
#include "scene/scene.h"

namespace eikon {

/// How light is found. All four have the same expectation; they differ in variance.
enum class LightSampling {
  mis,         // lights are sampled and scattered rays count, weighted by the power heuristic
  light,       // lights are sampled; emission that a scattered ray meets does not count
  cosine,      // scattered by the BSDF; no light sampling
  hemisphere,  // scattered uniformly, pdf 1 / 2 pi; no light sampling
};

inline constexpr std::uint32_t kMostLightSamples = 16;  // memory of paths in flight grows with them

/// Everything that decides the image, devices apart.
struct Settings {
  std::uint32_t width = 0, height = 0;
  Crop crop;
  std::uint64_t sample_begin = 0, sample_end = 64;  // half-open
  std::uint32_t seed = 0;
  std::uint32_t replicate_bits = 1;  // two replicates
  std::uint32_t max_depth = 0;       // 0: no limit
  std::uint32_t roulette_depth = 4;  // the first edge that roulette decides on
  float roulette = 0;                // probability with which it lets a path go on; 0: by what the path carries
  bool whitted = false;  // only perfect mirrors and smooth glass scatter light on; with LightSampling::light
  bool energy_compensation = false;  // rough metal and glass give back what single scattering loses
  bool raycast = false;  // nothing does, and every surface reflects as Blinn has it; with LightSampling::light
  std::uint32_t light_samples = 1;  // shadow rays of each vertex, 1 to kMostLightSamples; of raycast the lights decide
  LightSampling light_sampling = LightSampling::mis;
  std::vector<std::string> aovs;  // layers of layers.h
  std::vector<std::uint32_t>
      depth_series;  // light is summed apart by whether it was scattered more often than each of these
  PixelFilter filter;
  bool transparent = false;  // what the camera sees of the environment is left out, and the film has a channel A
  Camera camera;
  Environment environment;  // what is used: --env, else the file's, else black or the neutral one
};

/// Camera, bounce and shadow rays that a render will trace, roughly: a path has about five edges where depth allows, each
/// with a shadow ray.
inline double expected_rays(const Settings& settings) {
  const auto samples = static_cast<double>(settings.sample_end - settings.sample_begin);
  const std::uint32_t edges = settings.max_depth == 0 ? 5 : std::min(settings.max_depth, 5U);
  return static_cast<double>(settings.crop.pixel_count()) * samples * 2 * edges;
}

/// How meshes that stand at several places are stored.
enum class InstanceMode { automatic, two_level, flat };

/// How the work is done: never changes the image's bits.
struct Execution {
  std::string devices = "all";
  std::string accel = "bvh";
  std::string layout;  // empty: by device; or see choose_layout.h
  InstanceMode instances = InstanceMode::automatic;
  std::optional<std::uint32_t> lanes;               // 1, 8 or 16; by device when unset
  std::optional<bool> chunked;                      // by device when unset
  std::optional<bool> fused;                        // chunks go through all stages in one launch; by device when unset
  std::uint32_t chunk = 0;                          // paths per work-item of a CPU device; 0: by device
  std::uint32_t pool = 0;                           // paths in flight per device; 0: by device
  std::uint32_t block = 128;                        // largest side of a unit's pixel block
  unsigned threads = 0;                             // of host-side work, and compute units of a CPU device; 0: all
  std::shared_ptr<const ThreadLimit> thread_limit;  // what holds the host to them; may be none
  std::uint64_t memory_bytes = 0;                   // at most this of each device; 0: what it has
  bool ticks = true;                                // false: as on a processor without a counter for the profile
  bool optimise = true;                             // false: -cl-opt-disable
  std::string extra_flags = "";                     // see ProgramOptions
  double watchdog_s = 10;        // a device that takes longer for a unit, and than expected, is given up; see device_sessions.h
  std::shared_ptr<Trace> trace;  // for --profile: told what happens when
  Trace::Track track = Trace::kMain;  // there, of the thread at work
};

}  // namespace eikon
