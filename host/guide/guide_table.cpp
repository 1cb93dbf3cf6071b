// SPDX-License-Identifier: Apache-2.0
#include "guide/guide_table.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "io/xxhash64.h"

namespace eikon {
namespace {

constexpr std::size_t kSlotsPerCell = 4;  // at least: searches then end after one or two slots
constexpr auto kMinWeight = std::uint32_t(double(EK_GUIDE_LEAST) * EK_GUIDE_TOTAL / EK_GUIDE_BINS);  // of a bin

void add_slot(GuideTable& table, CellId id, std::uint32_t cell) {
  const auto xy = std::uint32_t(id), zn = std::uint32_t(id >> 32);
  const std::uint32_t hash = cell_hash(xy, zn);
  const std::uint32_t tag = cell_tag(xy, hash);
  std::uint32_t slot = hash & table.slot_mask();
  while (table.slots[2 * slot] != 0) slot = (slot + 1) & table.slot_mask();
  table.slots[2 * slot] = tag;
  table.slots[2 * slot + 1] = cell;
}

}  // namespace

CellId coarser(CellId id) {
  const auto xy = std::uint32_t(id), zn = std::uint32_t(id >> 32);
  const std::uint32_t code = (zn >> 16) & 0xffU, level = zn >> 24;
  return cell_id((xy >> 1) & 0x7fff7fffU, ((zn & 0xffffU) >> 1) | code << 16 | (level + 1) << 24);
}

bool GuideTable::is_sound() const {
  const std::size_t count = cell_count(), slot_count = slots.size() / 2;
  if (!(scale > 0) || !std::isfinite(scale) || count == 0 || cells.size() % EK_GUIDE_CELL_WORDS != 0) return false;
  if (slots.size() % 2 != 0 || !std::has_single_bit(slot_count)) return false;
  std::size_t taken = 0;
  for (std::size_t slot = 0; slot < slot_count; ++slot) {
    if (slots[2 * slot] == 0) continue;
    ++taken;
    if (slots[2 * slot + 1] >= count) return false;
  }
  if (taken == 0) return true;
  for (std::size_t i = 0; i < count; ++i)
    if (!is_sound_cell(std::span(cells).subspan(i * EK_GUIDE_CELL_WORDS, EK_GUIDE_CELL_WORDS))) return false;
  return taken < slot_count;
}

std::uint64_t GuideTable::digest() const {
  std::uint64_t hash = xxhash64(std::as_bytes(std::span(slots)), roulette_depth);
  hash = xxhash64(std::as_bytes(std::span(cells)), hash);
  return xxhash64(std::as_bytes(std::span(&scale, 1)), hash);
}

std::array<std::uint32_t, EK_GUIDE_BINS> guide_weights(const std::array<double, EK_GUIDE_BINS>& target) {
  constexpr double kShared = EK_GUIDE_TOTAL - double(kMinWeight) * EK_GUIDE_BINS;
  double sum = 0;
  for (const double t : target) sum += t;
  std::array<std::uint32_t, EK_GUIDE_BINS> weights{};
  // Sums are rounded, not weights, so that the total is exact.
  double up_to = 0;
  std::uint32_t given = 0;
  for (std::size_t bin = 0; bin < EK_GUIDE_BINS; ++bin) {
    up_to += sum > 0 ? target[bin] / sum : 1.0 / EK_GUIDE_BINS;
    const double share = bin + 1 == EK_GUIDE_BINS ? 1.0 : std::min(up_to, 1.0);
    const auto now = std::uint32_t(share * kShared + 0.5);  // rounded
    weights[bin] = kMinWeight + (now - given);
    given = now;
  }
  return weights;
}

GuideCellWords words_of(const GuideCellData& cell) {
  GuideCellWords words{};
  const auto set_half = [&](std::size_t half, std::uint32_t value) { words[half / 2] |= value << (16 * (half % 2)); };
  const auto weights = guide_weights(cell.target);
  std::uint32_t below = 0;
  for (std::size_t bin = 0; bin < EK_GUIDE_BINS; ++bin) {
    if (bin % EK_GUIDE_ROWS == 0) set_half(2 * GUIDE_bounds + bin / EK_GUIDE_ROWS, below);
    set_half(2 * GUIDE_weights + bin, weights[bin]);
    below += weights[bin];
  }
  words[GUIDE_indirect] = std::bit_cast<std::uint32_t>(float(cell.indirect));
  words[GUIDE_direct] = std::bit_cast<std::uint32_t>(float(cell.direct));
  return words;
}

bool is_sound_cell(std::span<const std::uint32_t> words) {
  const auto half = [&](std::size_t which) { return words[which / 2] >> (16 * (which % 2)) & 0xffffU; };
  for (const std::size_t radiance : {std::size_t(GUIDE_indirect), std::size_t(GUIDE_direct)})
    if (const auto value = std::bit_cast<float>(words[radiance]); !(value >= 0) || !std::isfinite(value)) return false;
  std::uint32_t below = 0;
  for (std::size_t bin = 0; bin < EK_GUIDE_BINS; ++bin) {
    if (bin % EK_GUIDE_ROWS == 0 && half(2 * GUIDE_bounds + bin / EK_GUIDE_ROWS) != below) return false;
    const std::uint32_t weight = half(2 * GUIDE_weights + bin);
    if (weight < kMinWeight) return false;
    below += weight;
  }
  return below == EK_GUIDE_TOTAL;
}

GuideTable assemble_guide_table(std::span<const std::pair<CellId, const GuideCellWords*>> cells, float scale) {
  GuideTable table;
  table.scale = scale;
  table.slots.assign(2 * std::bit_ceil(std::max<std::size_t>(kSlotsPerCell * cells.size(), 1)), 0);
  table.cells.resize(std::max<std::size_t>(cells.size(), 1) * EK_GUIDE_CELL_WORDS);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    add_slot(table, cells[i].first, std::uint32_t(i));
    std::ranges::copy(*cells[i].second, table.cells.begin() + std::ptrdiff_t(i * EK_GUIDE_CELL_WORDS));
  }
  return table;
}

GuideTable make_guide_table(const std::vector<GuideCellData>& cells, float scale) {
  std::vector<GuideCellWords> words(cells.size());
  std::vector<std::pair<CellId, const GuideCellWords*>> pairs;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    words[i] = words_of(cells[i]);
    pairs.emplace_back(cells[i].id, &words[i]);
  }
  return assemble_guide_table(pairs, scale);
}

}  // namespace eikon
