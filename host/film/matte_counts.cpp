// SPDX-License-Identifier: Apache-2.0
#include "film/matte_counts.h"

#include "core/error.h"

namespace eikon {

MatteCounts::MatteCounts(std::uint32_t width, std::uint32_t height) : rows_(height, Row{std::vector<Entry>(width)}) {}

void MatteCounts::add(std::uint32_t x, std::uint32_t y, const MatteCount& count) {
  if (count.samples == 0) return;
  Row& row = rows_.at(y);
  std::vector<Entry>& entries = row.entries;
  if (entries.at(x).samples == 0) {
    entries[x] = {count.samples, count.id, 0};
    return;
  }
  if (count.id < entries[x].id) {  // the entry of the smallest id is the first one
    const auto moved = static_cast<std::uint32_t>(entries.size());
    entries.push_back(entries[x]);
    entries[x] = {count.samples, count.id, moved};
    return;
  }
  std::size_t at = row.pixel == x && entries[row.last].samples > 0 && entries[row.last].id <= count.id ? row.last : x;
  while (entries[at].next != 0 && entries[entries[at].next].id <= count.id) at = entries[at].next;
  if (entries[at].id != count.id) {
    const auto added = static_cast<std::uint32_t>(entries.size());
    entries.push_back({count.samples, count.id, entries[at].next});
    entries[at].next = added;
    at = added;
  } else if (__builtin_add_overflow(entries[at].samples, count.samples, &entries[at].samples)) {
    throw InputError("film: more than 2^64 samples of a pixel met one thing");
  }
  row.pixel = x;
  row.last = at;
}

std::vector<MatteCount> MatteCounts::of(std::uint32_t x, std::uint32_t y) const {
  const std::vector<Entry>& entries = rows_.at(y).entries;
  std::vector<MatteCount> counts;
  for (const Entry* at = &entries.at(x); at->samples != 0; at = &entries[at->next]) {
    counts.push_back({at->id, at->samples});
    if (at->next == 0) break;
  }
  return counts;
}

}  // namespace eikon
