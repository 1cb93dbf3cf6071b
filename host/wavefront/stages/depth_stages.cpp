// SPDX-License-Identifier: Apache-2.0
#include "wavefront/stages/depth_stages.h"

#include <algorithm>
#include <array>
#include <span>

namespace eikon {
namespace {

/// The words that are kept of a depth, of buffer `counts` (kernels/shared/queue_counts.h).
std::span<const std::uint32_t> depth_words(std::span<const std::uint32_t> words, std::uint32_t depth) {
  return words.subspan(kQueueWords + EK_DEPTH_WORDS * (depth % EK_COUNT_DEPTHS), EK_DEPTH_WORDS);
}

/// The counts after one of several depths, as queue_counts() takes them for one chunk.
/// words  of buffer `counts` (kernels/shared/queue_counts.h)
/// last   the last depth that was launched before they were read
std::array<std::uint32_t, kQueueWords> counts_after(std::span<const std::uint32_t> words, std::uint32_t depth,
                                                    std::uint32_t last) {
  std::array<std::uint32_t, kQueueWords> counts{};
  const auto kept = [&](std::uint32_t of) { return depth_words(words, of); };
  const std::size_t next = (depth + 1) & 1;
  counts[next] = depth == last ? words[next] : kept(depth + 1)[0];
  counts[2] = depth == last ? words[2] : kept(depth)[1];
  return counts;
}

}  // namespace

/// Launches the stages of the next depths, whose paths are at most left_.
void DepthStages::launch(std::uint32_t count) {
  ReadBack& at = read_backs_.emplace_back();
  at.first = launched_ + 1;
  at.last = launched_ + count;
  if (!spare_.empty()) {
    at.counts = std::move(spare_.back());
    spare_.pop_back();
  }
  at.counts.resize(device_, config_.chunked ? kQueueWords * stages_.chunks(paths_) : EK_COUNT_WORDS);
  for (std::uint32_t depth = at.first; depth <= at.last; ++depth) {
    counters_.add_depth(depth, std::uint64_t{divide_up(left_, kWorkGroup)} * kWorkGroup);
    stages_.run("intersect", depth, paths_, left_);
    if (replays_one_path) after_intersect(depth);
    for (const char* stage :
         {"miss", "shade", "sort_hits", "shade_flat_lambert", "shade_opaque", "shade_transmissive", "compact"})
      stages_.run(stage, depth, paths_, left_);
    if (depth == at.last) at.ticket = device_.read_later(counts_, at.counts.words().data(), at.counts.size_bytes());
    stages_.run("shadow", depth, paths_, left_);
  }
  launched_ = at.last;
  device_.flush();
}

void DepthStages::begin(const Frame& frame, const Buffer& counts) {
  counts_ = counts;
  read_backs_.clear();
  plan_.restart();
  plan_.add(frame.path_count);
  paths_ = left_ = frame.path_count;
  max_depth_ = frame.max_depth;
  known_ = 1, launched_ = 0;
  counters_.begin_unit(paths_);
  stages_.run("generate", 1, paths_, paths_);
  launch(1);
}

std::uint32_t DepthStages::next_depths() const {
  if (config_.chunked || replays_one_path) return 1;
  const std::uint32_t depths = plan_.depths(left_, launched_ + 1 - known_);
  // No path goes beyond the last depth but through null interfaces, which are few.
  return max_depth_ > launched_ ? std::min(depths, max_depth_ - launched_) : depths;
}

RayCounts DepthStages::launch_rest() {
  RayCounts rays;
  bool all_likely = false;  // all depths that are likely to have paths are under way
  while (left_ > 0) {
    const bool few = !config_.chunked && !replays_one_path && left_ <= DepthPlan::kFew;
    const std::size_t ahead = replays_one_path ? 0 : 1;  // depths under way while the host looks at the one before
    if (few ? all_likely : read_backs_.size() > ahead) {
      rays += take_first();
      all_likely = all_likely && !read_backs_.empty();
    } else {
      launch(next_depths());
      all_likely = few;
    }
  }
  return rays;
}

void DepthStages::settle() {
  while (!read_backs_.empty()) take_first();  // their counts are zero
}

/// Waits for the counts of the depths that were launched first.
RayCounts DepthStages::take_first() {
  device_.wait(read_backs_.front().ticket);
  ReadBack at = std::move(read_backs_.front());
  read_backs_.pop_front();
  RayCounts rays;
  for (std::uint32_t depth = at.first; depth <= at.last && left_ > 0; ++depth) {
    RayCounts on;
    if (config_.chunked) {
      on = counters_.end_depth(depth, at.counts.words(), paths_);
    } else {
      on = counters_.end_depth(depth, counts_after(at.counts.words(), depth, at.last), paths_);
      counters_.add_class_hits(depth_words(at.counts.words(), depth).subspan(EK_DEPTH_HITS));
    }
    rays += on;
    left_ = on.scattered;
    known_ = depth + 1;
    plan_.add(left_);
  }
  spare_.push_back(std::move(at.counts));
  return rays;
}

}  // namespace eikon
