// SPDX-License-Identifier: Apache-2.0
// The device and host memory that a render takes, known before anything is compiled or uploaded.
#pragma once
#include <cstdint>
#include <string>

#include "core/host_limits.h"
#include "film/film.h"
#include "pack/pack.h"
#include "wavefront/wavefront.h"

namespace eikon {

/// The bytes of a device's buffers that grow with the paths of a unit
/// (WavefrontConfig::capacity()).
struct UnitBufferBytes {
  std::uint64_t total = 0, largest = 0;  // largest: of one buffer
};
[[nodiscard]] UnitBufferBytes unit_buffer_bytes(const WavefrontConfig& config, const Features& features,
                                                const Settings& settings);

/// The bytes that a render takes of a device, by what they are for.
struct MemoryNeed {
  std::uint64_t textures = 0, geometry = 0, paths = 0;  // bytes; geometry: triangles, tree, materials and lights
  std::uint64_t two_level_saving = 0;                   // rough bytes that --instances two-level would save
  std::string largest;                                  // what the largest single buffer holds, for messages
  std::uint64_t largest_bytes = 0;                      // of it
  std::uint64_t photons = 0;  // bytes of the maps of --caustics merge
  [[nodiscard]] std::uint64_t total() const { return textures + geometry + paths + photons; }
};

/// The memory of one device. The tree of config.layout must have been built.
[[nodiscard]] MemoryNeed memory_need(const PackedScene& packed, const WavefrontConfig& config, const Features& features,
                                     const Settings& settings);

/// The limits of a device's units beside those of the device.
struct UnitRoom {
  std::uint32_t most_paths = 0;    // of a unit, where larger ones would be of no use; 0: no limit
  std::uint64_t beside_bytes = 0;  // of what is on the device beside units and scene
};

/// Returns `execution` with the paths that units are to have on this device. Without a limit by
/// `execution` or by `room`, a device that launches each stage has smaller units where it, or
/// --memory, has too little for the usual ones. Also a limit by `execution` is lowered where
/// kernels could not number the words of a buffer.
/// packed  with the tree of the device's layout
[[nodiscard]] Execution fit_units(const PackedScene& packed, const DeviceInfo& device, const Features& features,
                                  const Settings& settings, const Execution& execution, const UnitRoom& room = {});
/// The same for a scene that is not packed: room.beside_bytes has its bytes, too.
[[nodiscard]] Execution fit_units(const DeviceInfo& device, const Features& features, const Settings& settings,
                                  const Execution& execution, const UnitRoom& room);

/// Bytes that a film of this layout takes on the host.
[[nodiscard]] std::uint64_t film_bytes(const FilmLayout& layout);

/// Checks that the film, with its copy for checkpoints or else the prediction of its error, and the
/// packed scene fit the memory that this process may use. Without this a control group would kill
/// it during the render. throws DeviceError if they do not
void require_host_memory(const FilmLayout& layout, bool copied, std::uint64_t packed_bytes, const HostLimits& host);

/// Checks that a device (or --memory) has that much in all, and in one buffer. throws DeviceError
/// with all figures if not
void require_memory(const MemoryNeed& need, const DeviceInfo& device, const Execution& execution);

}  // namespace eikon
