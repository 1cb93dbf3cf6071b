// SPDX-License-Identifier: Apache-2.0
// The light paths of a unit on one device: their launches, and the splats that they leave.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "device/device.h"
#include "film/units.h"
#include "pack/features.h"
#include "shared/photon.h"
#include "shared/records.h"
#include "shared/splat.h"
#include "wavefront/config.h"
#include "wavefront/ray_counters.h"
#include "wavefront/stages/stage_kernels.h"

namespace eikon {

/// The light paths of an image. Each sample index has `count` of them, numbered from 0, which the
/// pixels of the window own in equal shares.
struct LightPathPlan {
  std::uint64_t count = 0;  // 0: there are none
  Crop window;
};

/// The numbers first to first + count - 1.
struct LightPathRange {
  std::uint32_t first = 0, count = 0;
};
/// The numbers of the light paths that the pixels of a block own, in each of the unit's samples: a
/// range for each row.
[[nodiscard]] std::vector<LightPathRange> light_paths_of(const LightPathPlan& plan, const Crop& block);

/// The light paths of one unit under way. The memory for splats is limited, and how many splats a
/// light path leaves is known only when it has been traced. So light paths are traced part by part,
/// and a part whose splats do not fit is halved and traced again.
struct LightUnit {
  std::vector<LightPathRange> ranges;          // light_paths_of() the unit's block
  std::uint64_t count = 0;                     // numbers in all ranges: light paths of each of the unit's samples
  std::vector<std::uint32_t> splats;           // so far; SPLAT_WORDS each, all finite and within the film's range
  RayCounts rays;                              // so far
  std::uint64_t nonfinite = 0, saturated = 0;  // splats so far that were left out

  /// Some of the unit's light paths, over some of its samples.
  struct Part {
    std::uint64_t first = 0, end = 0;  // positions in the ranges, one behind the other
    std::uint64_t sample_begin = 0, sample_end = 0;
  };
  std::vector<Part> left;  // the last one is the next; as much is cut from it as there is room for

  std::uint32_t record_words = SPLAT_WORDS;  // of a splat; of a photon if photons are looked for
  std::uint32_t value_word = SPLAT_r;        // the first of the three words with what it brings

  // Of the part that runs.
  Part running;
  std::vector<std::uint32_t> numbers;  // of its light paths
  Frame frame{};
  RayCounts part_rays;               // if each stage has a launch of its own
  std::vector<std::uint32_t> words;  // its splats, as far as they are read back
  std::array<std::uint32_t, SPLATS_COUNTS> counts{};
  Ticket counted;  // `words` and `counts` are there
};

/// Takes a part that there is room for from the last one of `left`, which is not empty.
[[nodiscard]] LightUnit::Part take_light_part(std::vector<LightUnit::Part>& left, const WavefrontConfig& config);

/// Runs light paths in parts that fit the memory for splats. If a part leaves more, it is divided
/// and traced again.
class LightStages {
 public:
  LightStages() = default;
  /// program: with the stages of light paths. Allocates the buffers of splats, and names them in
  /// `arguments`. throws DeviceError
  LightStages(Device& device, const Program& program, const WavefrontConfig& config, Arguments& arguments);
  /// Device memory of the splats of so many paths in flight.
  [[nodiscard]] static std::uint64_t bytes(const WavefrontConfig& config);

  /// Binds the kernels to their buffers. To be called again when a buffer in `arguments` is another
  /// one.
  /// stages  kernels of the wavefront that have a launch of their own, bound; they must live as
  ///         long as this
  void bind(const Arguments& arguments, StageKernels& stages);

  /// Starts the light paths of a unit behind the work that is in the device's queue; if each stage
  /// has a launch of its own, it waits until they have ended.
  /// lights  must not move before finish()
  /// which   0 or 1: the place of the unit among the two of the wavefront
  /// frame   of the wavefront
  void begin(LightUnit& lights, std::size_t which, const WorkUnit& unit, const LightPathPlan& plan, const Frame& frame);
  /// Traces frame.light_path_count light paths for each of some samples, and waits for them. Their
  /// photons come instead of splats.
  /// samples  begin and end
  void find_photons(LightUnit& lights, std::size_t which, std::pair<std::uint64_t, std::uint64_t> samples,
                    const Frame& frame);
  /// Launches the kernel of all stages on no paths, if there is one.
  void warm_up();
  /// Waits for all light paths of the unit.
  void finish(LightUnit& lights, std::size_t which);

 private:
  Device* device_ = nullptr;
  WavefrontConfig config_;
  StageKernels* stages_ = nullptr;
  std::array<Kernel, 2> fused_;
  // Of each unit under way; one for both if each stage has a launch of its own.
  std::array<Buffer, 2> splats_, counts_;
  Buffer frame_, numbers_, next_path_, queue_counts_;

  void start(LightUnit& lights, std::size_t which, std::uint32_t kind, const Frame& frame);
  void launch(LightUnit& lights, std::size_t which);
  void run_stages(LightUnit& lights);
  void collect(LightUnit& lights, std::size_t which);
};

}  // namespace eikon
