// SPDX-License-Identifier: Apache-2.0
// The light paths of a unit on one device: their launches, and the splats that they leave.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "device/device.h"
#include "film/units.h"
#include "pack/features.h"
#include "shared/records.h"
#include "shared/splat.h"
#include "wavefront/config.h"
#include "wavefront/ray_counters.h"

namespace eikon {

/// Light paths of an image: so many of each sample index, which the pixels of its window own in equal shares.
struct LightPathPlan {
  std::uint64_t count = 0;  // 0: none
  Crop window;
};

/// Consecutive numbers.
struct NumberRange {
  std::uint32_t first = 0, count = 0;
};
/// The numbers of the light paths that the pixels of a block own, in each of the unit's samples: a range for each row.
[[nodiscard]] std::vector<NumberRange> light_paths_of(const LightPathPlan& plan, const Crop& block);

/// The light paths of one unit under way.
struct LightUnit {
  std::vector<NumberRange> ranges;  // light_paths_of its block
  std::uint64_t count = 0;          // numbers in them
  std::vector<std::uint32_t> splats;   // SPLAT_WORDS each, all finite and within the film's range
  RayCounts rays, part_rays;
  std::uint64_t nonfinite = 0, saturated = 0;  // splats that were left out

  /// Some of its light paths: of some numbers, counted through the ranges, and some samples.
  struct Part {
    std::uint64_t first = 0, end = 0;
    std::uint64_t sample_begin = 0, sample_end = 0;
  };
  std::vector<Part> left;  // the last one is the next; it is cut to what there is room for
  Part running;
  std::vector<std::uint32_t> numbers, words;  // of the part that runs, and the splats that it leaves
  Frame frame{};
  std::array<std::uint32_t, SPLATS_COUNTS> counts{};
  Ticket counted;
};

/// Runs light paths in parts that fit the memory for splats. If a part leaves more, it is divided and traced again.
class LightStages {
 public:
  LightStages() = default;
  /// program: with the stages of light paths. Allocates the buffers of splats, and names them in `arguments`. throws DeviceError
  LightStages(Device& device, const Program& program, const WavefrontConfig& config, Arguments& arguments);
  /// Device memory of the splats of so many paths in flight.
  [[nodiscard]] static std::uint64_t bytes(const WavefrontConfig& config);

  /// stages: kernels of the wavefront that have a launch of their own, bound; they must live as long as this
  void bind(const Arguments& arguments, std::map<std::string, Kernel>& stages);

  /// Starts the light paths of a unit behind the work that is in the device's queue; if each stage has a launch of its
  /// own, it waits until they have ended.
  /// frame  of the wavefront; which: of its two units. `of` must not move before finish()
  void begin(LightUnit& of, std::size_t which, const WorkUnit& unit, const LightPathPlan& plan, const Frame& frame);
  /// Launches the kernel of all stages on no paths, if there is one.
  void warm_up();
  /// Waits for all light paths of the unit.
  void finish(LightUnit& of, std::size_t which);

 private:
  Device* device_ = nullptr;
  WavefrontConfig config_;
  std::map<std::string, Kernel>* stages_ = nullptr;
  std::array<Kernel, 2> fused_;
  // Of each unit under way; one for both if each stage has a launch of its own.
  std::array<Buffer, 2> splats_, counts_;
  Buffer frame_, numbers_, next_path_, queue_counts_;

  void launch(LightUnit& of, std::size_t which);
  void run_stages(LightUnit& of);
  void collect(LightUnit& of, std::size_t which);
};

}  // namespace eikon
