// SPDX-License-Identifier: Apache-2.0
#include "render/film_store.h"

#include <algorithm>

namespace eikon {

FilmStore::Rows::Rows(FilmStore& store, std::uint32_t begin, std::uint32_t count)
    : store_(store), begin_(begin % kBands), count_(std::min(count, kBands)) {
  for (std::uint32_t band = 0; band < kBands; ++band)
    if (holds(band)) store_.bands_[band].lock();
}

FilmStore::Rows::~Rows() {
  for (std::uint32_t band = 0; band < kBands; ++band)
    if (holds(band)) store_.bands_[band].unlock();
}

void FilmStore::add(const WorkUnit& unit, const UnitSums& sums, const std::string& arithmetic) {
  // Splats reach all rows.
  const bool everywhere = sums.light_paths > 0;
  const std::uint32_t first = unit.block.y0 / kBandRows, last = (unit.block.y1 - 1) / kBandRows;
  const Rows rows(*this, everywhere ? 0 : first, everywhere ? kBands : last - first + 1);
  try {
    state_.film.add(sums);
    // While the rows are held, so that a copy has both or neither.
    const std::lock_guard lock(done_mutex_);
    state_.sample_set.add(unit);
    state_.arithmetic.insert(arithmetic);
  } catch (...) {
    spoiled_ = true;
    throw;
  }
}

FilmState FilmStore::copy() {
  const Rows all(*this, 0, kBands);
  const std::lock_guard lock(done_mutex_);
  return state_;
}

std::vector<WorkUnit> FilmStore::missing(const Crop& crop, std::uint64_t begin, std::uint64_t end) {
  const std::lock_guard lock(done_mutex_);
  return state_.sample_set.missing(crop, begin, end);
}

}  // namespace eikon
