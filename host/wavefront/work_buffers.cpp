// SPDX-License-Identifier: Apache-2.0
#include "wavefront/work_buffers.h"

#include <algorithm>

#include "shared/records.h"

namespace eikon {
namespace {

constexpr std::uint32_t kMaxBlockPixels = 128 * 128;

}  // namespace

WorkBuffers::WorkBuffers(Device& device, const WavefrontConfig& config, const WorkBufferSizes& plan,
                                 Arguments& arguments) {
  const auto allocate = [&](std::size_t size) {
    bytes += size;
    return device.allocate(size);
  };
  const FilmShape& film = plan.film;
  const std::size_t places = std::size_t{config.chunk + EK_PAD} * config.held_chunks();
  const std::size_t capacity = config.capacity(), pixel_capacity = std::min<std::size_t>(capacity, kMaxBlockPixels);
  frame = allocate(sizeof(Frame));
  pixels = allocate(4 * pixel_capacity);
  state = allocate(4 * places * plan.state_words);
  counts = allocate(16 * std::size_t{config.chunks});
  film_slots = allocate(4 * std::size_t{film.channels + film.mattes} * (capacity + EK_PAD) + 4 * EK_PAD);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    // A device that reads back beside its work writes the next sums at the same time.
    const bool shares = device.info().cpu && i > 0;
    sums[i] = shares ? sums[0] : allocate(4 * film.sum_words(pixel_capacity));
    rejected[i] = shares ? rejected[0] : allocate(4 * film.rejected_words(pixel_capacity));
  }
  diagnostics = allocate(sizeof(Diagnostics));
  next_path = allocate(4);
  tallies = allocate(config.workers * sizeof(WorkerTally));
  // Lanes without a path read these before they are written. Zeros are valid indices.
  for (const Buffer& read_early : {state, film_slots, counts, diagnostics, next_path}) device.fill_zero(read_early);
  arguments.set("frame", frame);
  arguments.set("pixels", pixels);
  arguments.set("path_state", state);
  arguments.set("counts", counts);
  arguments.set("film_slots", film_slots);
  arguments.set("diagnostics", diagnostics);
  arguments.set("next_path", next_path);
  arguments.set("tallies", tallies);
  arguments.set("queue_rays", allocate(config.chunked ? 4 : 8 * capacity));
  arguments.set("queue_shadow", allocate(config.chunked ? 4 : 4 * std::size_t{plan.light_samples} * capacity));
}

}  // namespace eikon
