// SPDX-License-Identifier: Apache-2.0
#include "wavefront/ray_counters.h"

#include <algorithm>
#include <fmt/format.h>

#include "core/clock.h"

namespace eikon {

RayCounters::RayCounters(Device& device, const WavefrontConfig& config, const Features& features, Trace* timeline)
    : device_(device),
      config_(config),
      has_environment_(features.has_environment()),
      has_shadow_(features.has(Feature::next_event)),
      class_stages_(class_stages(config, features)),
      timeline_(timeline),
      live_counter_(fmt::format("live paths, device {}", device.info().selector)) {}

void RayCounters::restart(Trace* timeline) {
  timeline_ = timeline;
  bounces_ = {};
  counted_s_ = 0;
}

RayCounts RayCounters::add_launch(std::uint64_t paths, std::span<const WorkerTally> tallies,
                                const std::map<std::string, double>& shares) {
  RayCounts rays{.camera = paths};
  for (const WorkerTally& tally : tallies) {
    rays.scattered += tally.scattered;
    rays.shadow += tally.shadow;
  }
  Profiler& profiler = device_.profiler();
  profiler.divide("paths", shares);
  add_bounces(bounces_, tallies, config_.lanes, config_.chunk);
  count_live(double(config_.workers) * mean_chunk_paths(tallies));
  profiler.add_items("generate", rays.camera);
  profiler.add_items("intersect", rays.camera + rays.scattered);
  if (has_environment_) profiler.add_items("miss", rays.camera + rays.scattered);
  profiler.add_items("shade", rays.camera + rays.scattered);
  if (has_shadow_) profiler.add_items("shadow", rays.shadow);
  return rays;
}

void RayCounters::begin_unit(std::uint64_t paths) {
  count_live(0);
  for (std::uint64_t first = 0, chunk = config_.chunk; first < paths; first += chunk)
    count_paths(1, std::min(chunk, paths - first));
  Profiler& profiler = device_.profiler();
  profiler.add_items("generate", paths);
  profiler.add_items("intersect", paths);
  if (class_stages_.empty()) profiler.add_items("shade", paths);
}

void RayCounters::add_depth(std::uint32_t depth, std::uint64_t work_items) {
  if (config_.chunked) return;
  bounce_at(bounces_, depth).lanes += work_items;
  bounce_at(bounces_, depth).slots += config_.capacity();
}

RayCounts RayCounters::end_depth(std::uint32_t depth, std::span<const std::uint32_t> counts, std::uint64_t paths) {
  for (std::size_t chunk = 0; chunk < counts.size() / kQueueWords; ++chunk)
    count_paths(depth + 1, queue_counts(counts, chunk, depth).next_paths);
  const QueueCounts total = total_counts(counts, depth);
  const std::uint64_t next = total.next_paths, shadow = has_shadow_ ? total.shadow_rays : 0;
  bounce_at(bounces_, depth).shadow_rays += shadow;
  count_live(double(next));
  Profiler& profiler = device_.profiler();
  if (next > 0) {
    profiler.add_items("intersect", next);
    if (class_stages_.empty()) profiler.add_items("shade", next);
  }
  if (has_environment_) profiler.add_items("miss", depth == 1 ? paths + next : next);
  if (shadow > 0) profiler.add_items("shadow", shadow);
  return {.camera = 0, .scattered = next, .shadow = shadow};
}

void RayCounters::add_class_hits(std::span<const std::uint32_t> hits) {
  for (std::size_t k = 0; k < class_stages_.size(); ++k)
    if (hits[k] > 0) device_.profiler().add_items(class_stages_[k], hits[k]);
}

/// Adds paths that reached a depth, of one chunk or of the queue.
void RayCounters::count_paths(std::uint32_t depth, std::uint64_t paths) {
  Bounce& bounce = bounce_at(bounces_, depth);
  bounce.paths += paths;
  if (!config_.chunked || paths == 0) return;
  bounce.lanes += std::uint64_t{divide_up(paths, config_.lanes)} * config_.lanes;
  bounce.slots += config_.chunk;
}

/// Records the number of live paths since the last call.
void RayCounters::count_live(double paths) {
  if (timeline_ == nullptr) return;
  const double now = host_seconds();
  if (counted_s_ > 0) timeline_->count(live_counter_, counted_s_, now, paths);
  counted_s_ = now;
}

}  // namespace eikon
