// SPDX-License-Identifier: Apache-2.0
#include "film/sample_set.h"

#include <algorithm>
#include <fmt/format.h>
#include <tuple>
#include <utility>

#include "core/error.h"

namespace eikon {
namespace {

/// Cuts the interval that contains `at` in two, unless `at` is its end.
template <class Interval>
void cut(std::vector<Interval>& intervals, std::uint32_t at) {
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    if (!(intervals[i].begin < at && at < intervals[i].end)) continue;
    Interval rest = intervals[i];
    rest.begin = intervals[i].end = at;
    intervals.insert(intervals.begin() + std::ptrdiff_t(i) + 1, std::move(rest));
    return;
  }
}

/// Makes intervals begin and end at `from` and `to`, and adds empty ones for the gaps in between.
template <class Interval>
void cover(std::vector<Interval>& intervals, std::uint32_t from, std::uint32_t to) {
  cut(intervals, from);
  cut(intervals, to);
  std::vector<Interval> gaps;
  std::uint32_t at = from;
  const auto gap = [&](std::uint32_t until) {
    if (at < until) gaps.push_back({at, until, {}});
  };
  for (const Interval& interval : intervals) {
    if (interval.end <= from || interval.begin >= to) continue;
    gap(interval.begin);
    at = interval.end;
  }
  gap(to);
  intervals.insert(intervals.end(), gaps.begin(), gaps.end());
  std::ranges::sort(intervals, {}, &Interval::begin);
}

/// Joins touching neighbours of equal content.
template <class Interval>
void join(std::vector<Interval>& intervals) {
  std::vector<Interval> joined;
  for (Interval& interval : intervals) {
    if (!joined.empty() && joined.back().end == interval.begin && joined.back().content == interval.content)
      joined.back().end = interval.end;
    else
      joined.push_back(std::move(interval));
  }
  intervals = std::move(joined);
}

bool is_empty(const WorkUnit& unit) {
  return unit.block.x0 >= unit.block.x1 || unit.block.y0 >= unit.block.y1 || unit.sample_begin >= unit.sample_end;
}

}  // namespace

void SampleSet::insert(Ranges& ranges, Range range) {
  const auto after = std::find_if(ranges.begin(), ranges.end(), [&](const Range& r) { return r.begin >= range.begin; });
  auto at = ranges.insert(after, range);
  if (const auto next = at + 1; next != ranges.end() && next->begin == at->end) {
    at->end = next->end;
    ranges.erase(next);
  }
  if (at != ranges.begin() && (at - 1)->end == at->begin) {
    (at - 1)->end = at->end;
    ranges.erase(at);
  }
}

void SampleSet::insert(std::vector<Column>& columns, std::uint32_t x0, std::uint32_t x1, Range range) {
  cover(columns, x0, x1);
  for (Column& column : columns)
    if (column.begin >= x0 && column.end <= x1) insert(column.content, range);
  join(columns);
}

void SampleSet::add(const WorkUnit& unit) {
  if (is_empty(unit)) return;
  if (const std::optional<WorkUnit> twice = overlap(unit))
    throw InternalError(fmt::format("samples {} to {} of pixel {},{} are in the film twice", twice->sample_begin,
                                    twice->sample_end - 1, twice->block.x0, twice->block.y0));
  const Crop& b = unit.block;
  cover(slabs_, b.y0, b.y1);
  for (Slab& slab : slabs_)
    if (slab.begin >= b.y0 && slab.end <= b.y1) insert(slab.content, b.x0, b.x1, {unit.sample_begin, unit.sample_end});
  join(slabs_);
}

void SampleSet::add(const SampleSet& other) {
  for (const WorkUnit& part : other.parts()) add(part);
}

std::optional<WorkUnit> SampleSet::overlap(const WorkUnit& unit) const {
  const Crop& b = unit.block;
  if (is_empty(unit)) return std::nullopt;
  for (const Slab& slab : slabs_) {
    if (slab.end <= b.y0 || slab.begin >= b.y1) continue;
    for (const Column& column : slab.content) {
      if (column.end <= b.x0 || column.begin >= b.x1) continue;
      for (const Range& range : column.content)
        if (range.begin < unit.sample_end && range.end > unit.sample_begin)
          return WorkUnit{{std::max(column.begin, b.x0), std::max(slab.begin, b.y0), std::min(column.end, b.x1),
                           std::min(slab.end, b.y1)},
                          std::max(range.begin, unit.sample_begin),
                          std::min(range.end, unit.sample_end)};
    }
  }
  return std::nullopt;
}

std::optional<WorkUnit> SampleSet::overlap(const SampleSet& other) const {
  for (const WorkUnit& part : other.parts())
    if (const std::optional<WorkUnit> found = overlap(part)) return found;
  return std::nullopt;
}

std::uint64_t SampleSet::complete_until(const Crop& crop, std::uint64_t begin, std::uint64_t end) const {
  const std::vector<WorkUnit> left = missing(crop, begin, end);
  return left.empty() ? end : left.front().sample_begin;
}

std::vector<WorkUnit> SampleSet::missing(const Crop& crop, std::uint64_t begin, std::uint64_t end) const {
  std::vector<WorkUnit> missing;
  if (is_empty({crop, begin, end})) return missing;
  // The slabs and columns of the whole window, with those that have no samples.
  std::vector<Slab> slabs = slabs_;
  cover(slabs, crop.y0, crop.y1);
  for (Slab& slab : slabs) {
    if (slab.begin < crop.y0 || slab.end > crop.y1) continue;
    cover(slab.content, crop.x0, crop.x1);
    for (const Column& column : slab.content) {
      if (column.begin < crop.x0 || column.end > crop.x1) continue;
      std::uint64_t at = begin;
      const auto gap = [&](std::uint64_t until) {
        if (at < until) missing.push_back({{column.begin, slab.begin, column.end, slab.end}, at, until});
      };
      for (const Range& range : column.content) {
        gap(std::min(range.begin, end));
        at = std::max(at, range.end);
      }
      gap(end);
    }
  }
  std::sort(missing.begin(), missing.end(), [](const WorkUnit& a, const WorkUnit& b) {
    return std::tie(a.sample_begin, a.block.y0, a.block.x0) < std::tie(b.sample_begin, b.block.y0, b.block.x0);
  });
  return missing;
}

std::vector<WorkUnit> SampleSet::parts() const {
  std::vector<WorkUnit> parts;
  for (const Slab& slab : slabs_)
    for (const Column& column : slab.content)
      for (const Range& range : column.content)
        parts.push_back({{column.begin, slab.begin, column.end, slab.end}, range.begin, range.end});
  return parts;
}

std::uint64_t SampleSet::sample_count() const {
  std::uint64_t count = 0;
  for (const WorkUnit& part : parts()) count += part.path_count();
  return count;
}

}  // namespace eikon
