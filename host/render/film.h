// SPDX-License-Identifier: Apache-2.0
// The exact film: sums of samples as 128-bit two's-complement fixed-point integers of unit 2^-64, per pixel, replicate and
// channel. Integer addition commutes, so devices, work units, restarts and machines may share an image in any way and the
// merged sums have the same bits as an unbroken render.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "shared/records.h"

namespace eikon {

__extension__ typedef __int128 int128;

/// Window of the full image that a film holds, in pixels; x1 and y1 exclusive.
struct Crop {
  std::uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  [[nodiscard]] std::uint32_t width() const { return x1 - x0; }
  [[nodiscard]] std::uint32_t height() const { return y1 - y0; }
  [[nodiscard]] std::uint64_t pixel_count() const { return std::uint64_t{width()} * height(); }
  bool operator==(const Crop&) const = default;
};

struct FilmLayout {
  std::uint32_t width = 0, height = 0;  // of the full image
  Crop crop;
  std::uint32_t replicates = 2;         // power of two
  std::vector<std::string> channels{"R", "G", "B"};  // then the AOV channels in the order of features.def: albedo.R ...
  bool operator==(const FilmLayout&) const = default;
};

/// The sums of one finished work unit, as a device wrote them.
struct UnitSums {
  std::span<const std::uint32_t> pixels;  // x | y << 16 of the full image, one per pixel of the unit
  std::uint32_t pixel_stride = 0;
  std::uint64_t sample_begin = 0, sample_end = 0;  // half-open range of sample indices, the same for every pixel
  std::span<const std::uint32_t> limbs;     // [((replicate * channels + channel) * EK_FILM_LIMBS + limb) * pixel_stride + pixel]
  std::span<const std::uint32_t> rejected;  // [replicate * pixel_stride + pixel]: samples left out
};

/// Predicted relative mean squared error of the image, and its 95 % confidence interval, from the spread between replicates.
struct PredictedError {
  double relmse = 0, lo = 0, hi = 0;
  bool known = false;  // false when some replicate of some pixel has no sample
};

class Film {
 public:
  explicit Film(FilmLayout layout);

  [[nodiscard]] const FilmLayout& layout() const { return layout_; }

  /// Adds a unit's sums. throws InternalError for a pixel outside the crop or arrays of the wrong size.
  void add(const UnitSums& unit);
  /// Adds another film of the same layout; the union of their samples must be disjoint (the caller's business).
  void add(const Film& other);

  /// Exact sum and count; x, y in the full image.
  [[nodiscard]] int128 sum(std::uint32_t x, std::uint32_t y, std::uint32_t replicate, std::uint32_t channel) const;
  [[nodiscard]] std::uint64_t count(std::uint32_t x, std::uint32_t y, std::uint32_t replicate) const;

  /// Sets them; for reading checkpoints and parts.
  void set(std::uint32_t x, std::uint32_t y, std::uint32_t replicate, std::uint32_t channel, int128 sum);
  void set_count(std::uint32_t x, std::uint32_t y, std::uint32_t replicate, std::uint64_t count);

  /// Mean over all samples of all replicates, correctly rounded to double from the exact sum; 0 where there is no sample.
  [[nodiscard]] double mean(std::uint32_t x, std::uint32_t y, std::uint32_t channel) const;
  /// Variance of that mean, estimated between replicates: sum_r w_r (m_r - m)^2 / (R - 1) / ..., see film.cpp; NaN if unknown.
  [[nodiscard]] double variance_of_mean(std::uint32_t x, std::uint32_t y, std::uint32_t channel) const;
  [[nodiscard]] std::uint64_t samples(std::uint32_t x, std::uint32_t y) const;

  /// relMSE with eps 1e-2 in the denominator, over R, G, B and all pixels, as `compare` would find it against the truth.
  [[nodiscard]] PredictedError predicted_error() const;

 private:
  FilmLayout layout_;
  std::vector<int128> sums_;           // [(pixel * replicates + replicate) * channels + channel]
  std::vector<std::uint64_t> counts_;  // [pixel * replicates + replicate]
};

/// value = sum * 2^-64, correctly rounded.
[[nodiscard]] double to_double(int128 fixed);

}  // namespace eikon
