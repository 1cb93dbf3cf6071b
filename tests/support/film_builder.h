// SPDX-License-Identifier: Apache-2.0
// Films and work units made from floats, for tests.
#pragma once
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "film/film.h"

namespace eikon::test {

inline FilmLayout small_layout(std::uint32_t width, std::uint32_t height, std::uint32_t replicates = 2) {
  return {.width = width, .height = height, .crop = {0, 0, width, height}, .replicates = replicates};
}

/// A work unit that owns its arrays.
class UnitBuilder {
 public:
  UnitBuilder(const FilmLayout& layout, std::vector<std::uint32_t> pixels, std::uint64_t begin, std::uint64_t end)
      : layout_(layout), pixels_(std::move(pixels)), begin_(begin), end_(end), stride_(pixels_.size() + 3) {
    limbs_.assign(layout.replicates * layout.channels.size() * EK_FILM_LIMBS * stride_, 0);
    rejected_.assign(layout.replicates * stride_, 0);
  }

  /// Adds one sample of one channel; the counts come from the sample range.
  void add(std::size_t pixel, std::uint64_t sample, std::size_t channel, int128 fixed) {
    const std::size_t first = ((sample % layout_.replicates) * layout_.channels.size() + channel) * EK_FILM_LIMBS;
    unsigned __int128 sum = 0;
    for (std::size_t limb = EK_FILM_LIMBS; limb-- > 0;) sum = sum << 32 | limbs_[(first + limb) * stride_ + pixel];
    sum += static_cast<unsigned __int128>(fixed);
    for (std::size_t limb = 0; limb < EK_FILM_LIMBS; ++limb, sum >>= 32)
      limbs_[(first + limb) * stride_ + pixel] = static_cast<std::uint32_t>(sum);
  }
  void reject(std::size_t pixel, std::uint64_t sample) { ++rejected_[(sample % layout_.replicates) * stride_ + pixel]; }

  [[nodiscard]] UnitSums sums() const {
    return {.pixels = pixels_,
            .pixel_stride = static_cast<std::uint32_t>(stride_),
            .sample_begin = begin_,
            .sample_end = end_,
            .limbs = limbs_,
            .rejected = rejected_};
  }

 private:
  FilmLayout layout_;
  std::vector<std::uint32_t> pixels_;
  std::uint64_t begin_, end_;
  std::size_t stride_;
  std::vector<std::uint32_t> limbs_, rejected_;
};

/// A film full of random bits in every sum and count, of a size that stays in range.
inline Film random_film(const FilmLayout& layout, unsigned seed) {
  Film film(layout);
  std::mt19937_64 random(seed);
  const Crop& crop = layout.crop;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
      for (std::uint32_t r = 0; r < layout.replicates; ++r) {
        for (std::uint32_t c = 0; c < layout.channels.size(); ++c)
          film.set(x, y, r, c, static_cast<int128>(static_cast<std::int64_t>(random()) >> 8) << 64 | random());
        film.set_count(x, y, r, random() >> 8);
      }
  return film;
}

}  // namespace eikon::test
