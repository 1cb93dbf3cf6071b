// SPDX-License-Identifier: Apache-2.0
// The buffers of one device: those that the kernels of a wavefront write, those that describe a
// unit, and those with the scene.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "device/device.h"
#include "film/packed_sums.h"
#include "guide/light_aim.h"
#include "pack/pack.h"
#include "wavefront/config.h"

namespace eikon {

/// The shape of a unit's film sums: words of 32 bits, [replicate][channel][limb][pixel]. Each row
/// of pixels has EK_PAD words behind the last one. Rejected samples are counted in words as well,
/// [replicate][pixel].
struct FilmShape {
  std::uint32_t replicates = 1, channels = 0, mattes = 0;
  [[nodiscard]] std::size_t sum_words(std::size_t pixel_count) const {
    return std::size_t{replicates} * channels * EK_FILM_LIMBS * (pixel_count + EK_PAD);
  }
  [[nodiscard]] std::size_t packed_words(std::size_t pixel_count) const {
    return eikon::packed_words(std::size_t{replicates} * channels, pixel_count + EK_PAD);
  }
  [[nodiscard]] std::size_t rejected_words(std::size_t pixel_count) const {
    return std::size_t{replicates} * (pixel_count + EK_PAD);
  }
};

/// Sizes that depend on the scene; WavefrontConfig has the others.
struct WorkBufferSizes {
  FilmShape film;
  std::uint32_t state_words = 0;  // words of a path: PathStateLayout
  std::uint32_t hit_queues = 0;   // of classes that have one each: class_stages()
  bool logs = false;              // feature path_log
};

/// The sizes that follow from the features and the settings.
[[nodiscard]] WorkBufferSizes work_buffer_sizes(const WavefrontConfig& config, const Features& features,
                                                const Settings& settings);

/// The bytes of each of the buffers.
struct WorkBytes {
  std::size_t frame = 0, pixels = 0, state = 0, counts = 0, film_slots = 0, diagnostics = 0, next_path = 0, tallies = 0;
  std::size_t queue_rays = 0, queue_hits = 0, queue_shadow = 0;
  std::size_t path_log = 0;  // 0: there is none
  // `sum_buffers` times each; packed is 0 where there is none.
  std::size_t sums = 0, rejected = 0, packed = 0, sum_buffers = 1;
  [[nodiscard]] std::uint64_t total() const;
  /// The bytes of the largest buffer.
  [[nodiscard]] std::uint64_t largest() const;
};
[[nodiscard]] WorkBytes work_bytes(const WavefrontConfig& config, const WorkBufferSizes& plan);

struct WorkBuffers {
  Buffer frame, pixels, state, counts, film_slots, diagnostics, next_path, tallies;
  Buffer path_log;  // with WorkBufferSizes::logs
  /// For the two units under way. A device that reads back in the order of its work has one buffer
  /// for both.
  std::array<Buffer, 2> sums, rejected;
  std::array<Buffer, 2> packed;  // sums for the host, if each stage has a launch of its own and there are no chunks
  std::uint64_t bytes = 0;  // of all buffers

  WorkBuffers() = default;
  /// Allocates buffers for units of config.capacity() paths and clears them in the device's queue.
  /// Names all of them in `arguments` but the sums, because each unit has its own.
  /// throws DeviceError saying how much was asked for and what the device has
  WorkBuffers(Device& device, const WavefrontConfig& config, const WorkBufferSizes& plan, Arguments& arguments);
};

/// Makes buffers of the scene's arrays but its texels, of the tree and the filter's table, and
/// names them in `arguments`. A CPU device reads the arrays in place, so they must live, unchanged,
/// as long as the buffers.
/// returns  the bytes of all buffers, copied or not
/// throws   DeviceError
std::uint64_t upload_scene(Device& device, const PackedScene& scene, const Accel& accel,
                           const std::vector<float>& filter, const std::vector<float>& camera_poses,
                           Arguments& arguments);

/// Makes the buffer of the scene's texels, which are copied. returns  its bytes. throws DeviceError
std::uint64_t upload_texels(Device& device, const PackedScene& scene, Arguments& arguments);

/// True if the texels of two scenes that are in memory at the same time are the same memory.
[[nodiscard]] bool have_same_texels(const PackedScene& a, const PackedScene& b);

/// Makes the buffer of a moving camera's poses anew if those of the settings are others.
/// poses  those on the device, which must live as long as the buffer; receives the others
/// returns  true if kernels are to be bound to the new buffer. throws DeviceError
bool replace_camera(Device& device, const PackedScene& scene, const Settings& settings, std::vector<float>& poses,
                    Arguments& arguments);

/// Makes the buffers of a table that guides paths. It must live as long as they. throws DeviceError
void upload_guide(Device& device, const GuideTable& guide, Arguments& arguments);

/// The buffers of what a trial learned about the starts of light paths.
struct LightAimBuffers {
  std::shared_ptr<const LightAim> aim;  // null: they start evenly
  std::vector<float> emission_aim;      // of the scene, times the density factors; empty without `aim`
};
/// Makes them, beside those of the scene. `buffers` must live as long as they, and at its place.
/// throws DeviceError; InternalError if something else is aimed at in the scene
void upload_light_aim(Device& device, const PackedScene& scene, LightAimBuffers& buffers, Arguments& arguments);

/// Makes only those buffers that tracing rays and sampling lights read. throws DeviceError
void upload_tree_and_lights(Device& device, const PackedScene& scene, const Accel& accel, Arguments& arguments);

}  // namespace eikon
