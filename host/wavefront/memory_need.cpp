// SPDX-License-Identifier: Apache-2.0
#include "wavefront/memory_need.h"

#include <algorithm>
#include <limits>
#include <fmt/format.h>

#include "core/error.h"
#include "wavefront/buffers.h"
#include "wavefront/photons/photon_map.h"
#include "wavefront/stages/light_stages.h"
#include "wavefront/unit_shrink.h"

namespace eikon {
namespace {

std::string megabytes(std::uint64_t bytes) { return fmt::format("{:.1f} MB", double(bytes) / 0x1p20); }

}  // namespace

UnitBufferBytes unit_buffer_bytes(const WavefrontConfig& config, const Features& features, const Settings& settings) {
  const WorkBytes work = work_bytes(config, work_buffer_sizes(config, features, settings));
  if (!needs_stage(config, features, config.fused ? "light_paths" : "splat")) return {work.total(), work.largest()};
  const std::uint64_t splats = LightStages::bytes(config);
  return {work.total() + splats, std::max(work.largest(), splats)};
}

MemoryNeed memory_need(const PackedScene& packed, const WavefrontConfig& config, const Features& features,
                       const Settings& settings) {
  MemoryNeed need;
  need.textures = 4 * packed.texel_count();
  need.geometry = packed.bytes(config.layout) - need.textures;
  need.paths = unit_buffer_bytes(config, features, settings).total;
  if (features.has(Feature::merging)) need.photons = photon_map_bytes(settings);
  need.two_level_saving = packed.two_level_saving;
  const auto buffer = [&](const char* name, std::uint64_t bytes) {
    if (bytes > need.largest_bytes) need.largest = name, need.largest_bytes = bytes;
  };
  buffer("the textures", need.textures);
  buffer("the triangles", packed.triangles.size() * sizeof(Triangle));
  buffer("the triangles at each pose", packed.pose_triangles.size() * sizeof(Triangle));
  buffer("the triangles at the next frame", packed.next_corners.size() * sizeof(std::uint32_t));
  buffer("the shapes", packed.shapes.size() * sizeof(ShapeRecord));
  buffer("the environment map's texels", packed.environment_texels.size() * sizeof(float4));
  const auto tree = packed.accels.find(config.layout);
  if (tree != packed.accels.end()) {
    buffer("the tree", tree->second.nodes.size() * sizeof(tree->second.nodes[0]));
    buffer("the tree's leaves", tree->second.leaves.size() * sizeof(tree->second.leaves[0]));
  }
  return need;
}

Execution fit_units(const DeviceInfo& device, const Features& features, const Settings& settings,
                    const Execution& execution, const UnitRoom& room) {
  Execution fitted = execution;
  const std::uint32_t asked = execution.unit_paths;
  if (room.most_paths != 0) fitted.unit_paths = asked == 0 ? room.most_paths : std::min(asked, room.most_paths);
  WavefrontConfig config = configure(device, fitted);
  const bool may_be_less = room.most_paths != 0 || (asked == 0 && !config.chunked);
  const auto fits = [&] {
    const UnitBufferBytes buffers = unit_buffer_bytes(config, features, settings);
    const bool numbered = buffers.largest / 4 <= std::numeric_limits<std::uint32_t>::max();  // the words of a buffer
    const bool stored = room.beside_bytes + buffers.total <= available_bytes(device, execution) &&
                        buffers.largest <= device.max_allocation_bytes;
    return numbered && (stored || !may_be_less);
  };
  while (config.capacity() > kMinUnitPaths && !fits()) {
    Execution less = fitted;
    less.unit_paths = config.capacity() / 2;
    const WavefrontConfig smaller = configure(device, less);
    if (smaller.capacity() == config.capacity()) break;  // a single chunk, whose size was asked for
    fitted = less;
    config = smaller;
  }
  return fitted;
}

Execution fit_units(const PackedScene& packed, const DeviceInfo& device, const Features& features,
                    const Settings& settings, const Execution& execution, const UnitRoom& room) {
  const MemoryNeed need = memory_need(packed, configure(device, execution), features, settings);
  return fit_units(device, features, settings, execution,
                   {room.most_paths, room.beside_bytes + need.total() - need.paths});
}

std::uint64_t film_bytes(const FilmLayout& layout) {
  return layout.crop.pixel_count() * layout.replicates *
             (layout.channels.size() * sizeof(int128) + sizeof(std::uint64_t)) +
         layout.crop.pixel_count() * layout.mattes.size() * MatteCounts::kBytesPerPixel;
}

void require_host_memory(const FilmLayout& layout, bool copied, std::uint64_t packed_bytes, const HostLimits& host) {
  // The copy, which is the larger one, is gone before the error is predicted.
  const std::uint64_t film = film_bytes(layout), error = layout.crop.pixel_count() * kErrorBytesPerPixel,
                      all = film + (copied ? film : error);
  if (host.memory_bytes == 0 || all + packed_bytes <= host.memory_bytes) return;
  throw DeviceError(
      fmt::format("the image does not fit the memory that this process may use: the film and {} {}, the scene {}; "
                  "there is {} ({}); "
                  "render it in parts (--crop) or smaller (--size)",
                  copied ? "its copy for checkpoints" : "the prediction of its error", megabytes(all),
                  megabytes(packed_bytes), megabytes(host.memory_bytes), host.memory_why));
}

void require_memory(const MemoryNeed& need, const DeviceInfo& device, const Execution& execution) {
  const std::uint64_t available = available_bytes(device, execution);
  const bool capped = available < device.memory_bytes;
  const std::string figures =
      fmt::format("textures {}, geometry {}, paths in flight {}{}", megabytes(need.textures), megabytes(need.geometry),
                  megabytes(need.paths), need.photons > 0 ? ", photons " + megabytes(need.photons) : "");
  const bool once = need.two_level_saving > 0 && execution.instances != InstanceMode::two_level;
  const std::string advice =
      need.photons > need.textures + need.geometry + need.paths ? "allow more memory, or leave out --caustics merge"
      : need.paths > need.textures + need.geometry ? "allow more memory, or make the picture smaller (--size)"
      : need.textures > need.geometry              ? "use smaller images"
      : once ? fmt::format("store meshes once (--instances two-level saves about {})", megabytes(need.two_level_saving))
      : execution.accel != "bvh" ? "use --accel bvh, which takes the least, simpler meshes or fewer instances"
                                 : "use simpler meshes or fewer instances";
  if (need.total() > available)
    throw DeviceError(
        fmt::format("the scene does not fit device '{}': it needs {} ({}); {} is {}; {}, or another device (--devices)",
                    device.name, megabytes(need.total()), figures,
                    capped                        ? "--memory"
                    : device.memory_limit.empty() ? "its memory"
                                                  : fmt::format("what {} allows", device.memory_limit),
                    megabytes(available), advice));
  if (need.largest_bytes > device.max_allocation_bytes)
    throw DeviceError(fmt::format(
        "the scene does not fit device '{}': {}; {} need {} in one buffer, which may have {}; {}, or another device "
        "(--devices)",
        device.name, figures, need.largest, megabytes(need.largest_bytes), megabytes(device.max_allocation_bytes),
        advice));
}

}  // namespace eikon
