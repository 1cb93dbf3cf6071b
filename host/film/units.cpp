// SPDX-License-Identifier: Apache-2.0
#include "film/units.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

namespace eikon {
namespace {

constexpr std::uint32_t kTile = 4;  // side in pixels of a tile that neighbouring lanes start with

/// Returns the begin of the i-th of `parts` nearly equal parts of [begin, end), at whole tiles from
/// `begin` if the parts are long enough.
std::uint32_t cut_at(std::uint32_t begin, std::uint32_t end, std::uint32_t i, std::uint32_t parts) {
  const std::uint32_t length = end - begin;
  const auto at = std::uint32_t(std::uint64_t{length} * i / parts);
  const std::uint32_t grain = length / parts >= 2 * kTile ? kTile : 1;
  return i == parts ? end : begin + at / grain * grain;
}

/// Returns the least number of parts such that none is longer than `most`.
std::uint32_t parts_of(std::uint32_t length, std::uint32_t most) {
  std::uint32_t parts = (length + most - 1) / most;
  const auto longest = [&] {
    std::uint32_t most_pixels = 0;
    for (std::uint32_t i = 0; i < parts; ++i)
      most_pixels = std::max(most_pixels, cut_at(0, length, i + 1, parts) - cut_at(0, length, i, parts));
    return most_pixels;
  };
  while (longest() > most) ++parts;
  return parts;
}

/// Returns how many samples from `begin` on a unit of at most `most` takes.
std::uint64_t sample_count(std::uint64_t begin, std::uint64_t end, std::uint64_t most, std::uint64_t period) {
  most = std::clamp<std::uint64_t>(most, 1, period);
  const std::uint64_t until = begin + std::min({most, end - begin, period - begin % period});
  if (until == end) return end - begin;
  const std::uint64_t grain = std::bit_floor(std::max<std::uint64_t>(most / 4, 1));
  const std::uint64_t round = until / grain * grain;
  return round > begin && 2 * (round - begin) >= until - begin ? round - begin : until - begin;
}

/// Cuts the block of `unit` into the coarsest grid of nearly square parts of at most `most` pixels,
/// and leaves it the first one. Appends the others to `rest`: those in the same rows as one box,
/// and those below as another.
void cut_to_part(WorkUnit& unit, std::uint64_t most, std::vector<WorkUnit>& rest) {
  const Crop all = unit.block;
  const std::uint64_t parts = (all.pixel_count() + most - 1) / most;
  if (parts <= 1) return;
  const double ideal_rows = std::sqrt(double(parts) * all.height() / all.width());
  const double most_rows = std::min(double(parts), double(all.height()));
  const auto rows = std::uint32_t(std::clamp(std::round(ideal_rows), 1.0, most_rows));
  const auto columns = std::uint32_t(std::min<std::uint64_t>((parts + rows - 1) / rows, all.width()));
  unit.block.x1 = cut_at(all.x0, all.x1, 1, columns);
  unit.block.y1 = cut_at(all.y0, all.y1, 1, rows);
  WorkUnit beside = unit, below = unit;
  beside.block.x0 = unit.block.x1, beside.block.x1 = all.x1;
  below.block = {all.x0, unit.block.y1, all.x1, all.y1};
  rest.push_back(beside);
  rest.push_back(below);
}

}  // namespace

bool UnitPool::Earlier::operator()(const WorkUnit& a, const WorkUnit& b) const {
  const auto key = [](const WorkUnit& u) {
    return std::tie(u.sample_begin, u.block.y0, u.block.x0, u.block.y1, u.block.x1, u.sample_end);
  };
  return key(a) < key(b);
}

std::optional<WorkUnit> UnitPool::joined(const WorkUnit& a, const WorkUnit& b) const {
  WorkUnit both = a;
  both.block = {std::min(a.block.x0, b.block.x0), std::min(a.block.y0, b.block.y0), std::max(a.block.x1, b.block.x1),
                std::max(a.block.y1, b.block.y1)};
  both.sample_begin = std::min(a.sample_begin, b.sample_begin);
  both.sample_end = std::max(a.sample_end, b.sample_end);
  const bool same_block = a.block == b.block;
  const bool same_samples = a.sample_begin == b.sample_begin && a.sample_end == b.sample_end;
  if (same_block && !same_samples && (a.sample_end == b.sample_begin || b.sample_end == a.sample_begin)) return both;
  const bool whole = both.block.pixel_count() == a.block.pixel_count() + b.block.pixel_count();
  if (same_samples && whole && both.block.width() <= block_ && both.block.height() <= block_) return both;
  return std::nullopt;
}

void UnitPool::put(WorkUnit box) {
  if (box.path_count() == 0) return;
  paths_ += box.path_count();
  for (auto it = boxes_.begin(); it != boxes_.end();) {
    const std::optional<WorkUnit> both = joined(*it, box);
    if (!both) {
      ++it;
      continue;
    }
    boxes_.erase(it);
    box = *both;
    it = boxes_.begin();
  }
  boxes_.insert(box);
}

void UnitPool::add(const WorkUnit& box) {
  const Crop& b = box.block;
  if (box.path_count() == 0) return;
  const bool first = boxes_.empty();  // then no block touches another box
  const std::uint32_t columns = parts_of(b.width(), block_), rows = parts_of(b.height(), block_);
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t column = 0; column < columns; ++column) {
      WorkUnit part = box;
      part.block = {cut_at(b.x0, b.x1, column, columns), cut_at(b.y0, b.y1, row, rows),
                    cut_at(b.x0, b.x1, column + 1, columns), cut_at(b.y0, b.y1, row + 1, rows)};
      if (!first) {
        put(part);
        continue;
      }
      paths_ += part.path_count();
      boxes_.insert(part);
    }
}

// Chooses among the boxes of the lowest first sample: the largest that fits, else the smallest.
UnitPool::Boxes::iterator UnitPool::choose(std::uint64_t most_pixels) const {
  constexpr int kMaxCompared = 64;  // boxes; beyond them the order of rows is as good
  auto best = boxes_.begin();
  int compared = 0;
  for (auto it = boxes_.begin(); it != boxes_.end() && compared < kMaxCompared; ++it, ++compared) {
    if (it->sample_begin != boxes_.begin()->sample_begin) break;
    const std::uint64_t pixels = it->block.pixel_count(), chosen = best->block.pixel_count();
    const bool fits = pixels <= most_pixels, chosen_fits = chosen <= most_pixels;
    if (fits ? (!chosen_fits || pixels > chosen) : (!chosen_fits && pixels < chosen)) best = it;
  }
  return best;
}

std::optional<WorkUnit> UnitPool::take(std::uint64_t most_paths, std::uint64_t most_samples,
                                       std::uint64_t most_pixels) {
  if (boxes_.empty()) return std::nullopt;
  most_paths = std::max<std::uint64_t>(most_paths, 1);
  most_pixels = std::max<std::uint64_t>(most_pixels, 1);
  const auto chosen = choose(std::min(most_paths, most_pixels));
  WorkUnit unit = *chosen;
  boxes_.erase(chosen);
  paths_ -= unit.path_count();
  std::vector<WorkUnit> rest;
  cut_to_part(unit, most_pixels, rest);
  while (unit.block.pixel_count() > most_paths) {
    WorkUnit other = unit;
    if (unit.block.width() >= unit.block.height())
      unit.block.x1 = other.block.x0 = cut_at(unit.block.x0, unit.block.x1, 1, 2);
    else
      unit.block.y1 = other.block.y0 = cut_at(unit.block.y0, unit.block.y1, 1, 2);
    rest.push_back(other);
  }
  const std::uint64_t most = std::min(most_paths / unit.block.pixel_count(), most_samples);
  WorkUnit later = unit;
  unit.sample_end = later.sample_begin =
      unit.sample_begin + sample_count(unit.sample_begin, unit.sample_end, most, period_);
  rest.push_back(later);
  for (const WorkUnit& part : rest) put(part);
  return unit;
}

std::vector<std::uint32_t> unit_pixels(const Crop& block) {
  std::vector<std::uint32_t> pixels;
  pixels.reserve(std::size_t(block.pixel_count()));
  for (std::uint32_t y0 = block.y0; y0 < block.y1; y0 += kTile)
    for (std::uint32_t x0 = block.x0; x0 < block.x1; x0 += kTile)
      for (std::uint32_t y = y0; y < std::min(y0 + kTile, block.y1); ++y)
        for (std::uint32_t x = x0; x < std::min(x0 + kTile, block.x1); ++x) pixels.push_back(x | y << 16);
  return pixels;
}

}  // namespace eikon
