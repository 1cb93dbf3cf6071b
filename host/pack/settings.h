// SPDX-License-Identifier: Apache-2.0
// The orders of a render: Settings decide the image, and Execution decides how the work is done.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/trace.h"
#include "film/film.h"
#include "film/pixel_filter.h"
#include "guide/guide_table.h"
#include "guide/light_aim.h"
#include "scene/scene.h"

namespace eikon {

/// The light that a render counts.
enum class Integrator {
  path,     // all light, up to Settings::max_depth edges
  whitted,  // light goes on from perfect mirrors and smooth glass alone; with LightSampling::light
  raycast,  // light does not go on, and every surface has Blinn's highlights; with LightSampling::light
};

[[nodiscard]] const char* name_of(Integrator integrator);  // as --integrator has it

/// The strategy for direct light. All four have the same mean, and differ in variance.
enum class LightSampling {
  mis,         // lights are sampled and scattered rays count, weighted by the power heuristic
  light,       // lights are sampled; emission that a scattered ray meets does not count
  bsdf,        // rays are scattered by the BSDF; lights are not sampled
  hemisphere,  // rays are scattered uniformly, with pdf 1 / 2 pi; lights are not sampled
};
[[nodiscard]] const char* name_of(LightSampling sampling);  // as --light-sampling has it
[[nodiscard]] inline bool samples_lights(LightSampling sampling) {
  return sampling == LightSampling::mis || sampling == LightSampling::light;
}

/// The rays that pass the backs of single-sided surfaces (glTF's doubleSided: false), as if those
/// were not there.
enum class Culling {
  none,
  camera,  // the rays from the camera to what they meet first; shadow rays and scattered rays meet both sides
};
[[nodiscard]] const char* name_of(Culling culling);  // as --cull has it

/// A choice whether paths follow what a pilot, a small render before the render, learned about
/// where light comes from. The mean of the image is the same either way.
enum class Guiding {
  automatic,  // where the pilot finds that it pays
  on,         // always
  off,
};
[[nodiscard]] const char* name_of(Guiding guiding);  // as --guiding has it

inline constexpr std::uint32_t kMaxImageSide = 65535;  // of an image: pixel coordinates travel as two 16-bit halves
inline constexpr std::uint64_t kMaxSamples = std::uint64_t{1} << 48;  // the end of the last range of a pixel's samples
// The most paths of all pixels together, so that sums of their numbers do not wrap.
inline constexpr std::uint64_t kMaxImagePaths = std::uint64_t{1} << 60;
inline constexpr double kMaxRadiance = 1e30;           // of an even environment
inline constexpr std::uint32_t kMaxLightSamples = 16;  // the memory of paths in flight grows with them

/// Everything that decides the image, besides the scene. Devices do not.
struct Settings {
  std::uint32_t width = 0, height = 0;
  Crop crop;
  std::uint64_t sample_begin = 0, sample_end = 64;  // half-open
  /// The samples of each pixel that are expected, where the render may end before sample_end, such
  /// as one with a time limit; 0: all. From it follows how much work is spent on a better tree
  /// (expected_rays); the image does not depend on it.
  std::uint64_t likely_samples = 0;
  std::uint32_t seed = 0;
  // log2 of the number of replicates: sample i of each pixel belongs to replicate i modulo that
  // number, and the replicates are independent, so that their spread tells the error of the image
  // (film/film.h).
  std::uint32_t replicate_bits = 1;
  // The most edges of a path. Edge 1 goes from the camera to what it meets first, edge 2 from there
  // on; null interfaces (kernels/film/slots.h) do not count. 0: no limit
  std::uint32_t max_depth = 0;
  Integrator integrator = Integrator::path;
  std::uint32_t roulette_depth = 4;  // the first edge that Russian roulette decides on
  float roulette_survival = 0;       // constant survival probability; 0: by the path's throughput
  bool energy_compensation = false;  // rough metal and glass give back what single scattering loses
  Culling culling = Culling::none;   // --cull has the default `camera`: instruments that place rays meet all surfaces
  LightSampling light_sampling = LightSampling::mis;
  std::uint32_t light_samples = 1;          // shadow rays of each vertex, 1 to kMaxLightSamples; raycast ignores it
  std::vector<std::string> aovs;            // layers of layers.h
  std::vector<std::uint32_t> depth_series;  // light is also summed apart by these bounds (scatter_bounds, layers.h)
  PixelFilter filter;
  bool transparent = false;            // the film leaves out the environment that the camera sees, and has a channel A
  std::uint64_t light_path_count = 0;  // of each sample index; the image has them whatever its crop. 0: none
  /// Camera paths of the trial that decides on light_path_count (usual_light_trial_paths); 0: there
  /// is none.
  std::uint64_t light_trial_paths = 0;
  std::shared_ptr<const LightAim> light_aim;  // what the trial learned about their starts; null: these are even
  /// Photons light what is seen through glass and in mirrors (wavefront/photons/photon_map.h), with
  /// a bias.
  bool merges_caustics = false;
  Guiding guiding = Guiding::off;
  std::uint64_t pilot_paths = 0;            // from which it is learned how to guide paths (usual_pilot_paths); 0: none
  std::shared_ptr<const GuideTable> guide;  // what a pilot learned; null: paths are not guided
  Camera camera;
  std::optional<Camera> next_camera;  // at the next frame, for layer `motion`; nothing: it stands still
  std::vector<Camera> camera_poses;  // at the times of Scene::poses; empty: the camera stands still
  Environment environment;           // what is used: --env, else the file's, else black or the neutral one
};

inline constexpr double kMaxLightPathRatio = 4;  // light paths for each path from the camera

/// Light paths of each sample index, if there are so many for each path from the camera.
[[nodiscard]] std::uint64_t light_paths_of_ratio(const Settings& settings, double ratio);

/// True if the camera, a surface or a light without extent moves while the shutter is open.
[[nodiscard]] bool moves(const Scene& scene, const Settings& settings);

/// A rough number of the rays that a render will trace.
[[nodiscard]] double expected_rays(const Settings& settings);

/// Storage of meshes with several instances.
enum class InstanceMode { automatic, two_level, flat };

/// The most paths that a unit of work may have.
inline constexpr std::uint32_t kMaxUnitPaths = 1U << 25;

/// The way in which the work is done. Nothing of it changes the image's bits.
struct Execution {
  std::string devices = "all";
  std::string accel = "bvh";
  std::string layout;  // of the tree: see choose_layout.h; empty: by device
  InstanceMode instances = InstanceMode::automatic;
  std::optional<std::uint32_t> lanes;        // 1, 8 or 16; by device when unset
  std::optional<bool> chunked;               // by device when unset
  std::optional<bool> fused;                 // one launch runs all stages of a chunk; by device when unset
  std::uint32_t chunk = 0;                   // paths per work-item of a CPU device; 0: by device
  std::uint32_t unit_paths = 0;              // most paths of a unit; 0: by device
  std::uint32_t block = 0;                   // largest side of a unit's pixel block; 0: by device
  unsigned threads = 0;                      // of the host, and compute units of a CPU device; 0: all
  std::shared_ptr<const void> thread_limit;  // holds the host to `threads`; may be null
  std::uint64_t memory_bytes = 0;            // most memory to take of each device; 0: all it has
  bool timed = true;                         // the times of stages are wanted
  bool ticks = true;                         // false: times stages as on a processor without a cycle counter
  bool optimise = true;                      // false: -cl-opt-disable
  std::string extra_flags = "";              // see ProgramOptions
  // A device is given up if a unit takes longer than this, and longer than expected
  // (device_sessions.h).
  double watchdog_s = 10;
  std::shared_ptr<Trace> trace;       // of --profile; may be null
  Trace::Track track = Trace::kMain;  // of the thread at work, in the trace
};

/// Reads EIKON_LANES, EIKON_STAGES, EIKON_NO_OPTIMISE, EIKON_WATCHDOG, EIKON_TICKS,
/// EIKON_UNIT_PATHS and EIKON_UNIT_BLOCK, which `eikon --help` explains. As long as `execution` or
/// a copy of it lives, the host uses at most `execution.threads` threads, and at most those that
/// the process may use.
/// throws UsageError
void read_execution_environment(Execution& execution);

}  // namespace eikon
