// SPDX-License-Identifier: Apache-2.0
// What the kernels of one wavefront write, and what they read of a unit; the scene is apart (scene_buffers.h).
#pragma once
#include <array>
#include <cstdint>

#include "device/device.h"
#include "wavefront/wavefront_config.h"

namespace eikon {

/// What a unit's film sums are of.
struct FilmShape {
  std::uint32_t replicates = 1, channels = 0, mattes = 0;
  [[nodiscard]] std::size_t sum_words(std::size_t pixel_count) const {
    return std::size_t{replicates} * channels * EK_FILM_LIMBS * (pixel_count + EK_PAD);
  }
  [[nodiscard]] std::size_t rejected_words(std::size_t pixel_count) const {
    return std::size_t{replicates} * (pixel_count + EK_PAD);
  }
};

/// What decides the memory's size, beside how the stages run.
struct MemoryPlan {
  FilmShape film;
  std::uint32_t state_words = 0;    // of a path: PathStateLayout
  std::uint32_t light_samples = 1;  // shadow rays of a path at a depth, at most
};

struct WavefrontMemory {
  Buffer frame, pixels, state, counts, film_slots, diagnostics, next_path, tallies;
  /// Of the two units under way: one for both on a device that reads back in the order of its work.
  std::array<Buffer, 2> sums, rejected;
  std::uint64_t bytes = 0;  // of all of it

  WavefrontMemory() = default;
  /// For units of config.capacity() paths. Names everything in `arguments` but the sums, of which the units have their own. Zeros, in
  /// the device's queue. throws DeviceError saying how much was asked for and what the device has
  WavefrontMemory(Device& device, const WavefrontConfig& config, const MemoryPlan& plan, Arguments& arguments);
};

}  // namespace eikon
