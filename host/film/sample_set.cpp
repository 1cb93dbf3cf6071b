// SPDX-License-Identifier: Apache-2.0
#include "film/sample_set.h"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <span>
#include <tuple>
#include <utility>

#include "core/error.h"

namespace eikon {
namespace {

// Intervals of a vector increase and do not overlap, so that binary search finds them. Parts come
// mostly in the order in which parts() lists them, and then each is added at the end; so no step
// goes through all intervals.

/// The first interval that ends after `at`.
template <class Intervals>
auto first_after(Intervals& intervals, std::uint32_t at) {
  return std::ranges::upper_bound(intervals, at, {}, [](const auto& interval) { return interval.end; });
}

/// The first interval that begins at `at` or after it.
template <class Intervals>
auto first_from(Intervals& intervals, std::uint32_t at) {
  return std::ranges::lower_bound(intervals, at, {}, [](const auto& interval) { return interval.begin; });
}

/// Cuts the interval that contains `at` in two, unless `at` is its end.
template <class Interval>
void cut(std::vector<Interval>& intervals, std::uint32_t at) {
  const auto found = first_after(intervals, at);
  if (found == intervals.end() || found->begin >= at) return;
  Interval rest = *found;
  rest.begin = found->end = at;
  intervals.insert(found + 1, std::move(rest));
}

/// Makes intervals begin and end at `from` and `to`, and adds empty ones for the gaps in between.
/// Returns those from `from` to `to`.
template <class Interval>
std::span<Interval> cover(std::vector<Interval>& intervals, std::uint32_t from, std::uint32_t to) {
  cut(intervals, from);
  cut(intervals, to);
  const auto first = first_after(intervals, from) - intervals.begin();
  const auto last = first_from(intervals, to) - intervals.begin();
  std::vector<Interval> gaps;
  std::uint32_t at = from;
  const auto gap = [&](std::uint32_t until) {
    if (at < until) gaps.push_back({at, until, {}});
  };
  for (auto i = first; i < last; ++i) {
    gap(intervals[std::size_t(i)].begin);
    at = intervals[std::size_t(i)].end;
  }
  gap(to);
  const auto added = intervals.insert(intervals.begin() + last, gaps.begin(), gaps.end());
  const auto end = added + std::ptrdiff_t(gaps.size());
  std::inplace_merge(intervals.begin() + first, added, end,
                     [](const Interval& a, const Interval& b) { return a.begin < b.begin; });
  return {intervals.begin() + first, end};
}

/// Joins touching neighbours of equal content, of which one lies between `from` and `to`.
template <class Interval>
void join(std::vector<Interval>& intervals, std::uint32_t from, std::uint32_t to) {
  auto kept = first_after(intervals, from == 0 ? 0 : from - 1);  // it ends at `from` or after it
  const auto end = to == std::numeric_limits<std::uint32_t>::max() ? intervals.end() : first_from(intervals, to + 1);
  for (auto next = kept + 1; next < end; ++next) {
    if (kept->end == next->begin && kept->content == next->content)
      kept->end = next->end;
    else if (++kept != next)
      *kept = std::move(*next);
  }
  intervals.erase(kept + 1, end);
}

bool is_empty(const WorkUnit& unit) {
  return unit.block.x0 >= unit.block.x1 || unit.block.y0 >= unit.block.y1 || unit.sample_begin >= unit.sample_end;
}

}  // namespace

void SampleSet::insert(Ranges& ranges, Range range) {
  const auto next = std::ranges::lower_bound(ranges, range.begin, {}, &Range::begin);
  const bool touches_next = next != ranges.end() && next->begin == range.end;
  const bool touches_last = next != ranges.begin() && (next - 1)->end == range.begin;
  if (touches_last && touches_next) {
    (next - 1)->end = next->end;
    ranges.erase(next);
  } else if (touches_last) {
    (next - 1)->end = range.end;
  } else if (touches_next) {
    next->begin = range.begin;
  } else {
    ranges.insert(next, range);
  }
}

void SampleSet::insert(std::vector<Column>& columns, std::uint32_t x0, std::uint32_t x1, Range range) {
  for (Column& column : cover(columns, x0, x1)) insert(column.content, range);
  join(columns, x0, x1);
}

void SampleSet::add(const WorkUnit& unit) {
  if (is_empty(unit)) return;
  if (const std::optional<WorkUnit> twice = overlap(unit))
    throw InternalError(fmt::format("samples {} to {} of pixel {},{} are in the film twice", twice->sample_begin,
                                    twice->sample_end - 1, twice->block.x0, twice->block.y0));
  const Crop& b = unit.block;
  for (Slab& slab : cover(slabs_, b.y0, b.y1)) insert(slab.content, b.x0, b.x1, {unit.sample_begin, unit.sample_end});
  join(slabs_, b.y0, b.y1);
}

void SampleSet::add(const SampleSet& other) {
  for (const WorkUnit& part : other.parts()) add(part);
}

std::optional<WorkUnit> SampleSet::overlap(const WorkUnit& unit) const {
  const Crop& b = unit.block;
  if (is_empty(unit)) return std::nullopt;
  for (auto slab = first_after(slabs_, b.y0); slab != slabs_.end() && slab->begin < b.y1; ++slab) {
    const std::vector<Column>& columns = slab->content;
    for (auto column = first_after(columns, b.x0); column != columns.end() && column->begin < b.x1; ++column) {
      const auto range = std::ranges::upper_bound(column->content, unit.sample_begin, {}, &Range::end);
      if (range != column->content.end() && range->begin < unit.sample_end)
        return WorkUnit{{std::max(column->begin, b.x0), std::max(slab->begin, b.y0), std::min(column->end, b.x1),
                         std::min(slab->end, b.y1)},
                        std::max(range->begin, unit.sample_begin),
                        std::min(range->end, unit.sample_end)};
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
  for (Slab& slab : cover(slabs, crop.y0, crop.y1)) {
    for (const Column& column : cover(slab.content, crop.x0, crop.x1)) {
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
