// SPDX-License-Identifier: Apache-2.0
#include "film/film.h"

#include <algorithm>
#include <array>
#include <bit>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "core/device_vector.h"
#include "core/error.h"
#include "film/packed_sums.h"

namespace eikon {
namespace {

__extension__ typedef unsigned __int128 uint128;

// Pixels of a unit that a thread adds in about a millisecond. The units of CPUs have no more, and
// those of GPUs up to a million.
constexpr std::size_t kPixelsOfPart = std::size_t{1} << 14;
// A thread adds about so many of the numbers that say what samples met before it takes more.
constexpr std::size_t kNumbersOfPart = std::size_t{1} << 18;
// A band has so many rows, as unit_pixels lists pixels in tiles of as many.
constexpr std::uint32_t kRowsOfBand = 4;

constexpr int128 kMaxSum = static_cast<int128>(~uint128{0} >> 1);

/// The indices of pixels (x | y << 16) by the band of rows in which they lie. Threads may add to
/// the mattes of different bands at the same time, because these have no row in common.
std::vector<std::vector<std::uint32_t>> bands_of(std::span<const std::uint32_t> pixels) {
  if (pixels.empty()) return {};
  const auto [lowest, highest] = std::ranges::minmax(pixels, {}, [](std::uint32_t pixel) { return pixel >> 16; });
  const std::uint32_t y0 = lowest >> 16;
  std::vector<std::vector<std::uint32_t>> bands(((highest >> 16) - y0) / kRowsOfBand + 1);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    bands[((pixels[i] >> 16) - y0) / kRowsOfBand].push_back(std::uint32_t(i));
  return bands;
}

}  // namespace

std::uint64_t samples_of_replicate(std::uint64_t begin, std::uint64_t end, std::uint32_t replicate,
                                   std::uint32_t replicates) {
  const auto below = [&](std::uint64_t sample) {
    return sample > replicate ? (sample - replicate - 1) / replicates + 1 : 0;
  };
  return below(end) - below(begin);
}

Film::Film(FilmLayout layout) : layout_(std::move(layout)) {
  const Crop& crop = layout_.crop;
  if (crop.x0 >= crop.x1 || crop.y0 >= crop.y1 || crop.x1 > layout_.width || crop.y1 > layout_.height)
    throw InternalError(fmt::format("film crop {},{},{},{} is empty or outside the image of {}x{}", crop.x0, crop.y0,
                                    crop.x1, crop.y1, layout_.width, layout_.height));
  if (!std::has_single_bit(layout_.replicates))
    throw InternalError(fmt::format("{} film replicates: not a power of two", layout_.replicates));
  const auto& channels = layout_.channels;
  if (channels.size() < 3 || channels[0] != "R" || channels[1] != "G" || channels[2] != "B")
    throw InternalError("the film's channels do not begin with R, G, B");
  for (const std::string& channel : channels) splats_of_.push_back(channel_index(fmt::format("{}{}", kSplats, channel)));
  const auto splats = std::ranges::find_if(channels, [](const std::string& name) { return name.starts_with(kSplats); });
  camera_channels_ = std::size_t(splats - channels.begin());
  const std::size_t cells = crop.pixel_count() * layout_.replicates;
  sums_.reserve(cells * channels.size());
  // Small pages take 10 ms at 512x512.
  prefer_huge_pages(sums_.data(), sums_.capacity() * sizeof(int128));
  sums_.assign(cells * channels.size(), 0);
  counts_.assign(cells, 0);
  mattes_.assign(layout_.mattes.size(), MatteCounts(crop.width(), crop.height()));
  limit_ = kMaxSum >> std::countr_zero(layout_.replicates);
}

std::optional<std::uint32_t> Film::channel_index(std::string_view name) const {
  for (std::uint32_t c = 0; c < layout_.channels.size(); ++c)
    if (layout_.channels[c] == name) return c;
  return std::nullopt;
}

std::size_t Film::pixel_index(std::uint32_t x, std::uint32_t y) const {
  const Crop& crop = layout_.crop;
  if (x < crop.x0 || x >= crop.x1 || y < crop.y0 || y >= crop.y1)
    throw InternalError(
        fmt::format("pixel {},{} is outside the film's crop {},{},{},{}", x, y, crop.x0, crop.y0, crop.x1, crop.y1));
  return std::size_t{y - crop.y0} * crop.width() + (x - crop.x0);
}

void Film::add_to_sum(std::size_t index, int128 value) {
  int128 result = 0;
  if (__builtin_add_overflow(sums_[index], value, &result) || result > limit_ || result < -limit_) refuse_sum(index);
  sums_[index] = result;
}

void Film::refuse_sum(std::size_t index) const {
  const std::size_t pixel = index / layout_.channels.size() / layout_.replicates;
  throw InputError(fmt::format(
      "film: the radiance of pixel {},{} summed over its samples is beyond 2^63: give the lights less emission",
      layout_.crop.x0 + pixel % layout_.crop.width(), layout_.crop.y0 + pixel / layout_.crop.width()));
}

void Film::add(const UnitSums& unit) {
  const std::uint32_t replicates = layout_.replicates;
  const std::size_t sums = replicates * camera_channels_, stride = unit.pixel_stride;
  const bool fits = unit.packed.empty() ? unit.limbs.size() == sums * EK_FILM_LIMBS * stride
                                        : unit.packed.size() == packed_words(sums, stride) && unit.packed[0] == 0;
  if (unit.pixels.size() > stride || !fits || unit.rejected.size() != replicates * stride ||
      unit.sample_begin > unit.sample_end)
    throw InternalError(fmt::format(
        "unit of {} pixels, stride {}: {} limbs, {} packed words and {} rejected counts do not fit a film of {} "
        "replicates and {} channels",
        unit.pixels.size(), stride, unit.limbs.size(), unit.packed.size(), unit.rejected.size(), replicates,
        camera_channels_));
  std::vector<std::uint64_t> drawn(replicates);
  for (std::uint32_t r = 0; r < replicates; ++r)
    drawn[r] = samples_of_replicate(unit.sample_begin, unit.sample_end, r, replicates);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, unit.pixels.size(), kPixelsOfPart),
                    [&](const auto& part) { add_pixels(unit, drawn, part.begin(), part.end()); });
  add_mattes(unit);
  if (unit.light_paths > 0) add_splats(unit);
}

/// Adds the pixels [begin, end) of a unit: their counts and their sums.
/// drawn  samples of a pixel that the unit has of each replicate
void Film::add_pixels(const UnitSums& unit, std::span<const std::uint64_t> drawn, std::size_t begin, std::size_t end) {
  const std::size_t replicates = drawn.size();
  // The unit's arrays are read along the pixels, in groups whose film sums fit into the L1 cache.
  constexpr std::size_t kTogether = 128;
  std::array<std::size_t, kTogether> film_pixels{};
  for (std::size_t first = begin; first < end; first += kTogether) {
    const std::size_t count = std::min(kTogether, end - first);
    for (std::size_t i = 0; i < count; ++i)
      film_pixels[i] = pixel_index(unit.pixels[first + i] & 0xffffu, unit.pixels[first + i] >> 16);
    for (std::size_t r = 0; r < replicates; ++r) {
      const std::uint32_t* const rejected = &unit.rejected[r * unit.pixel_stride + first];
      for (std::size_t i = 0; i < count; ++i) {
        if (rejected[i] > drawn[r])
          throw InternalError(fmt::format("unit rejects {} of {} samples of a pixel", rejected[i], drawn[r]));
        counts_[film_pixels[i] * replicates + r] += drawn[r] - rejected[i];
      }
    }
    add_sums(unit, first, std::span(film_pixels).first(count));
  }
}

/// Adds the sums of some pixels of a unit.
/// first        the first of them in the unit's arrays
/// film_pixels  their places in the film
void Film::add_sums(const UnitSums& unit, std::size_t first, std::span<const std::size_t> film_pixels) {
  const std::size_t channels = camera_channels_, all_channels = layout_.channels.size(), stride = unit.pixel_stride;
  const std::size_t sums = layout_.replicates * channels;
  for (std::size_t k = 0; k < sums; ++k) {
    const std::size_t place = k / channels * all_channels + k % channels,
                      pixel_sums = layout_.replicates * all_channels;
    if (!unit.packed.empty()) {
      const std::uint32_t* const words = &unit.packed[EK_PACKED_HEAD + first];
      const std::uint32_t *const low = words + 2 * k * stride, *const shifts = words + (2 * sums + k / 4) * stride;
      for (std::size_t i = 0; i < film_pixels.size(); ++i) {
        const auto number = static_cast<std::int64_t>(low[i] | std::uint64_t{low[stride + i]} << 32);
        add_to_sum(film_pixels[i] * pixel_sums + place, static_cast<int128>(number)
                                                            << (shifts[i] >> 8 * (k % 4) & 0x7fU));
      }
      continue;
    }
    const std::uint32_t* const limb = &unit.limbs[k * EK_FILM_LIMBS * stride + first];
    for (std::size_t i = 0; i < film_pixels.size(); ++i) {
      static_assert(EK_FILM_LIMBS == 4);
      const std::uint64_t low = limb[i] | std::uint64_t{limb[stride + i]} << 32;
      const std::uint64_t high = limb[2 * stride + i] | std::uint64_t{limb[3 * stride + i]} << 32;
      add_to_sum(film_pixels[i] * pixel_sums + place, static_cast<int128>(uint128{high} << 64 | low));
    }
  }
}

void Film::add_light_paths(const LightPathCount& count) {
  if (count.paths.size() != layout_.replicates)
    throw InternalError(fmt::format("{} counts of light paths for {} replicates", count.paths.size(), layout_.replicates));
  const auto place = std::ranges::lower_bound(light_paths_, order_of(count.window), {},
                                              [](const LightPathCount& of) { return order_of(of.window); });
  if (place == light_paths_.end() || place->window != count.window) {
    light_paths_.insert(place, count);
    return;
  }
  for (std::size_t r = 0; r < count.paths.size(); ++r)
    if (__builtin_add_overflow(place->paths[r], count.paths[r], &place->paths[r]))
      throw InputError("film: more than 2^64 light paths");
}

std::uint64_t Film::light_paths_at(std::size_t pixel, std::size_t replicate) const {
  if (light_paths_.size() == 1 && light_paths_.front().window == layout_.crop) return light_paths_.front().paths[replicate];
  const std::size_t x = layout_.crop.x0 + pixel % layout_.crop.width(), y = layout_.crop.y0 + pixel / layout_.crop.width();
  std::uint64_t paths = 0;
  for (const LightPathCount& of : light_paths_) {
    if (of.window.y0 > y) break;
    if (x >= of.window.x0 && x < of.window.x1 && y >= of.window.y0 && y < of.window.y1) paths += of.paths[replicate];
  }
  return paths;
}

std::span<const int128> Film::row_sums(std::uint32_t y) const {
  const std::size_t cells = layout_.replicates * layout_.channels.size();
  return {&sums_[pixel_index(layout_.crop.x0, y) * cells], layout_.crop.width() * cells};
}

std::span<const std::uint64_t> Film::row_counts(std::uint32_t y) const {
  return {&counts_[pixel_index(layout_.crop.x0, y) * layout_.replicates],
          std::size_t{layout_.crop.width()} * layout_.replicates};
}

void Film::add_row(std::uint32_t x, std::uint32_t y, std::span<const int128> sums,
                   std::span<const std::uint64_t> counts) {
  const std::size_t pixels = counts.size() / layout_.replicates, cells = layout_.replicates * layout_.channels.size();
  const std::size_t first = pixel_index(x, y);
  if (counts.size() != pixels * layout_.replicates || sums.size() != pixels * cells || pixels > layout_.crop.x1 - x)
    throw InternalError(
        fmt::format("{} sums and {} counts do not fit the film from pixel {},{} on", sums.size(), counts.size(), x, y));
  for (std::size_t i = 0; i < sums.size(); ++i)
    if (sums[i] != 0) add_to_sum(first * cells + i, sums[i]);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    std::uint64_t& count = counts_[first * layout_.replicates + i];
    if (__builtin_add_overflow(count, counts[i], &count))
      throw InputError(fmt::format("film: more than 2^64 samples in row {}", y));
  }
}

void Film::add(const Film& other) {
  const FilmLayout& theirs = other.layout_;
  if (theirs.width != layout_.width || theirs.height != layout_.height || theirs.replicates != layout_.replicates ||
      theirs.channels != layout_.channels || theirs.mattes != layout_.mattes)
    throw InternalError("films of different size, replicates, channels or mattes cannot be added");
  add_rows(other, theirs.crop.y0, theirs.crop.y1);
  for (const LightPathCount& count : other.light_paths_) add_light_paths(count);
}

void Film::add_rows(const Film& other, std::uint32_t y0, std::uint32_t y1) {
  const Crop& crop = other.layout_.crop;
  for (std::uint32_t y = y0; y < y1; ++y) {
    add_row(crop.x0, y, other.row_sums(y), other.row_counts(y));
    for (std::size_t m = 0; m < mattes_.size(); ++m)
      for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
        for (const MatteCount& count : other.matte(m, x, y)) add_to_matte(m, x, y, count);
  }
}

Film Film::rows(std::uint32_t y0, std::uint32_t y1) const {
  FilmLayout layout = layout_;
  layout.crop.y0 = y0;
  layout.crop.y1 = y1;
  Film part(std::move(layout));
  part.add_rows(*this, y0, y1);
  part.light_paths_ = light_paths_;
  return part;
}

void Film::add_to_matte(std::size_t matte, std::uint32_t x, std::uint32_t y, const MatteCount& count) {
  (void)pixel_index(x, y);
  mattes_.at(matte).add(x - layout_.crop.x0, y - layout_.crop.y0, count);
}

std::vector<MatteCount> Film::matte(std::size_t matte, std::uint32_t x, std::uint32_t y) const {
  (void)pixel_index(x, y);
  return mattes_.at(matte).of(x - layout_.crop.x0, y - layout_.crop.y0);
}

void Film::add_mattes(const UnitSums& unit) {
  const std::size_t pixels = unit.pixels.size(), samples = unit.sample_end - unit.sample_begin;
  if (unit.matte_numbers.size() != mattes_.size() * samples * pixels || unit.matte_ids.size() != mattes_.size())
    throw InternalError(
        fmt::format("unit of {} pixels and {} samples: {} numbers and {} lists of ids do not fit {} mattes", pixels,
                    samples, unit.matte_numbers.size(), unit.matte_ids.size(), mattes_.size()));
  if (mattes_.empty()) return;
  const std::vector<std::vector<std::uint32_t>> bands = bands_of(unit.pixels);
  const std::size_t bands_of_part = kNumbersOfPart * bands.size() / std::max<std::size_t>(1, samples * pixels);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, bands.size(), std::max<std::size_t>(1, bands_of_part)),
                    [&](const auto& part) {
                      for (std::size_t m = 0; m < mattes_.size(); ++m)
                        for (std::size_t b = part.begin(); b < part.end(); ++b) add_matte_band(unit, m, bands[b]);
                    });
}

/// Adds the numbers that the samples of some pixels met.
/// band  indices of the pixels in the unit
void Film::add_matte_band(const UnitSums& unit, std::size_t matte, std::span<const std::uint32_t> band) {
  const std::size_t pixels = unit.pixels.size(), samples = unit.sample_end - unit.sample_begin;
  const std::vector<std::uint32_t>& ids = unit.matte_ids[matte];
  // Most samples of a pixel meet the same as the sample before, so equal ones are counted first.
  struct Run {
    std::uint32_t number = 0;
    std::uint64_t samples = 0;
  };
  const auto add_run = [&](std::uint32_t pixel, const Run& run) {
    if (run.samples == 0) return;
    if (run.number >= ids.size()) throw InternalError(fmt::format("a ray met number {} of {}", run.number, ids.size()));
    add_to_matte(matte, unit.pixels[pixel] & 0xffffu, unit.pixels[pixel] >> 16, {ids[run.number], run.samples});
  };
  // The numbers of a sample lie together, so they are read along the pixels.
  constexpr std::size_t kTogether = 64;
  for (std::size_t first = 0; first < band.size(); first += kTogether) {
    const std::span<const std::uint32_t> some = band.subspan(first, std::min(kTogether, band.size() - first));
    std::array<Run, kTogether> runs{};
    for (std::size_t s = 0; s < samples; ++s) {
      const std::uint32_t* const numbers = &unit.matte_numbers[(matte * samples + s) * pixels];
      for (std::size_t i = 0; i < some.size(); ++i) {
        if (numbers[some[i]] != runs[i].number) {
          add_run(some[i], runs[i]);
          runs[i] = {.number = numbers[some[i]]};
        }
        ++runs[i].samples;
      }
    }
    for (std::size_t i = 0; i < some.size(); ++i) add_run(some[i], runs[i]);
  }
}

int128 Film::sum(std::uint32_t x, std::uint32_t y, std::uint32_t replicate, std::uint32_t channel) const {
  return sums_[(pixel_index(x, y) * layout_.replicates + replicate) * layout_.channels.size() + channel];
}

std::uint64_t Film::count(std::uint32_t x, std::uint32_t y, std::uint32_t replicate) const {
  return counts_[pixel_index(x, y) * layout_.replicates + replicate];
}

void Film::set(std::uint32_t x, std::uint32_t y, std::uint32_t replicate, std::uint32_t channel, int128 sum) {
  const std::size_t index = (pixel_index(x, y) * layout_.replicates + replicate) * layout_.channels.size() + channel;
  sums_[index] = 0;
  add_to_sum(index, sum);
}

void Film::set_count(std::uint32_t x, std::uint32_t y, std::uint32_t replicate, std::uint64_t count) {
  counts_[pixel_index(x, y) * layout_.replicates + replicate] = count;
}

int128 Film::total(std::uint32_t x, std::uint32_t y, std::uint32_t channel) const {
  const std::size_t channels = layout_.channels.size();
  const std::size_t first = pixel_index(x, y) * layout_.replicates * channels + channel;
  int128 total = 0;
  for (std::size_t r = 0; r < layout_.replicates; ++r) total += sums_[first + r * channels];
  return total;
}

int128 Film::total(std::uint32_t x, std::uint32_t y, std::span<const std::uint32_t> channels) const {
  int128 all = 0;
  for (const std::uint32_t channel : channels)
    if (__builtin_add_overflow(all, total(x, y, channel), &all))
      throw InputError(fmt::format("film: the channels of pixel {},{} that a layer adds up are beyond 2^63", x, y));
  return all;
}

std::uint64_t Film::samples(std::uint32_t x, std::uint32_t y) const {
  const std::size_t first = pixel_index(x, y) * layout_.replicates;
  std::uint64_t samples = 0;
  for (std::size_t r = 0; r < layout_.replicates; ++r) samples += counts_[first + r];
  return samples;
}

}  // namespace eikon
