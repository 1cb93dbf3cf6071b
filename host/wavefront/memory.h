// SPDX-License-Identifier: Apache-2.0
// What a render takes of a device's memory, known before anything is compiled or uploaded.
#pragma once
#include <cstdint>
#include <string>

#include "core/host_limits.h"
#include "film/film.h"
#include "pack/pack.h"
#include "wavefront/wavefront.h"

namespace eikon {

struct MemoryNeed {
  std::uint64_t textures = 0, geometry = 0, paths = 0;  // bytes; geometry: triangles, tree, materials and lights
  std::uint64_t saved_once = 0;  // roughly, if meshes at several places were stored once; 0: they are, or there are none
  std::string largest;                                  // the largest single buffer
  std::uint64_t largest_bytes = 0;
  [[nodiscard]] std::uint64_t total() const { return textures + geometry + paths; }
};

/// The tree of config.layout must have been built.
[[nodiscard]] MemoryNeed memory_need(const PackedScene& packed, const WavefrontConfig& config,
                                     const Features& features);

/// Bytes of a film of that layout on the host.
[[nodiscard]] std::uint64_t film_bytes(const FilmLayout& layout);

/// throws DeviceError where the film and its copy (for checkpoints) and what the packed scene holds are more than the process
/// may have. Without this, a control group kills it in the middle.
void require_host_memory(const FilmLayout& layout, bool copied, std::uint64_t packed_bytes, const HostLimits& host);

/// throws DeviceError, with all figures, where a device (or --memory) has less than that, in all or in one buffer
void require_memory(const MemoryNeed& need, const DeviceInfo& device, const Execution& execution);

}  // namespace eikon
