// SPDX-License-Identifier: Apache-2.0
#include "film/matte_counts.h"

#include <algorithm>

#include "core/error.h"

namespace eikon {

MatteCounts::MatteCounts(std::uint32_t width, std::uint32_t height) : rows_(height, std::vector<Entry>(width)) {}

void MatteCounts::add(std::uint32_t x, std::uint32_t y, const MatteCount& count) {
  if (count.samples == 0) return;
  std::vector<Entry>& row = rows_.at(y);
  Entry* at = &row.at(x);
  if (at->samples == 0) {
    *at = {count.samples, count.id, 0};
    return;
  }
  while (at->id != count.id && at->next != 0) at = &row[at->next];
  if (at->id != count.id) {
    at->next = static_cast<std::uint32_t>(row.size());
    row.push_back({count.samples, count.id, 0});  // this invalidates `at`
  } else if (__builtin_add_overflow(at->samples, count.samples, &at->samples)) {
    throw InputError("film: more than 2^64 samples of a pixel met one thing");
  }
}

std::vector<MatteCount> MatteCounts::of(std::uint32_t x, std::uint32_t y) const {
  const std::vector<Entry>& row = rows_.at(y);
  std::vector<MatteCount> counts;
  for (const Entry* at = &row.at(x); at->samples != 0; at = &row[at->next]) {
    counts.push_back({at->id, at->samples});
    if (at->next == 0) break;
  }
  std::ranges::sort(counts, {}, &MatteCount::id);
  return counts;
}

}  // namespace eikon
