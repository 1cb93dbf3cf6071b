// SPDX-License-Identifier: Apache-2.0
// The exact film: sums of samples as 128-bit two's-complement fixed-point integers of unit 2^-64,
// per pixel, replicate and channel. Integer addition commutes, so devices, work units, restarts and
// machines may share an image in any way, and the merged sums have the bits of an unbroken render.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "film/matte_counts.h"
#include "shared/records.h"

namespace eikon {

__extension__ typedef __int128 int128;

/// The window of the full image that a film holds, in pixels; x1 and y1 are exclusive.
struct Crop {
  std::uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  [[nodiscard]] std::uint32_t width() const { return x1 - x0; }
  [[nodiscard]] std::uint32_t height() const { return y1 - y0; }
  [[nodiscard]] std::uint64_t pixel_count() const { return std::uint64_t{width()} * height(); }
  bool operator==(const Crop&) const = default;
};

/// The order of windows in a list: by rows, then columns.
[[nodiscard]] inline auto order_of(const Crop& window) {
  return std::tuple(window.y0, window.x0, window.y1, window.x1);
}

/// The numbers that decide which sums a film has. Films of one layout can be added.
struct FilmLayout {
  std::uint32_t width = 0, height = 0;  // of the full image
  Crop crop;
  std::uint32_t replicates = 2;                      // power of two
  std::vector<std::string> channels{"R", "G", "B"};  // then AOV channels (albedo.R, ...) in the order of features.def
  // Layers that count what each sample hits (mattes.h).
  std::vector<std::string> mattes{};
  bool operator==(const FilmLayout&) const = default;
};

// A film takes samples that are finite and below 2^38 in magnitude: 2^24 of them do not overflow a
// sum. The film stage counts the others as rejected.

/// The number of samples in [begin, end) that belong to a replicate.
[[nodiscard]] std::uint64_t samples_of_replicate(std::uint64_t begin, std::uint64_t end, std::uint32_t replicate,
                                                 std::uint32_t replicates);

/// fixed * 2^-64, correctly rounded (to nearest, ties to even).
[[nodiscard]] double to_double(int128 fixed);
/// fixed * 2^-64 / count, correctly rounded; 0 when count is 0.
[[nodiscard]] double to_mean(int128 fixed, std::uint64_t count);

/// The prefix of channels that hold what light paths bring to the channel of the rest of the name
/// (film/splats.cpp).
inline constexpr std::string_view kSplats = "splats.";

/// Splats are held in units of 2^-48, not 2^-64, since they are larger than samples: a pixel's sum
/// of splats is divided by the number of all light paths of the window, of which few reach the
/// pixel.
inline constexpr int kSplatShift = 16;

/// Light paths that were traced for a window of the image.
struct LightPathCount {
  Crop window;
  std::vector<std::uint64_t> paths;  // [replicate]
  bool operator==(const LightPathCount&) const = default;
};

/// The sums of one finished work unit, in the fixed-point limbs that a device writes.
struct UnitSums {
  // Each pixel of the unit as x | y << 16, in the full image.
  std::span<const std::uint32_t> pixels;
  std::uint32_t pixel_stride = 0;
  // Half-open range of sample indices, the same for every pixel.
  std::uint64_t sample_begin = 0, sample_end = 0;
  std::span<const std::uint32_t>
      limbs;  // [((replicate * channels + channel) * EK_FILM_LIMBS + limb) * pixel_stride + pixel]
  std::span<const std::uint32_t> rejected;  // [replicate * pixel_stride + pixel]: samples left out
  /// Instead of limbs: packed sums, all of which fit (kernels/shared/packed_sums.h).
  std::span<const std::uint32_t> packed = {};
  /// Number of the object or material that each sample's camera ray hit, [(matte * samples + sample
  /// - sample_begin) * pixels.size() + pixel], and the ids that the mattes give to these numbers,
  /// [matte][number].
  std::span<const std::uint32_t> matte_numbers = {};
  std::span<const std::vector<std::uint32_t>> matte_ids = {};
  /// Splats of its light paths, SPLAT_WORDS words each (kernels/shared/splat.h), and the number of
  /// light paths that it has of each of its samples.
  std::span<const std::uint32_t> splats = {};
  std::uint64_t light_paths = 0;
};

/// The memory that Film::predicted_error() takes.
inline constexpr std::uint64_t kErrorBytesPerPixel = 2 * sizeof(double);

/// The relative mean squared error of the image, predicted from the spread between replicates, and
/// its 95 % confidence interval.
struct PredictedError {
  // Where only "at least" can be said, hi is infinite.
  double relmse = 0, lo = 0, hi = 0;
  // False for one replicate, or when some replicate of some pixel has no sample.
  bool known = false;
  // The standard deviation of the logarithm of relmse, and a bound of its bias.
  double scatter = 0, bias = 0;

  /// The upper end of a one-sided interval: relMSE lies above it with this probability.
  [[nodiscard]] double upper(double probability) const;
};

/// The mean over all pixels of R, G and B, and the standard errors of these three numbers.
struct MeanRadiance {
  std::array<double, 3> value{};
  std::optional<std::array<double, 3>> standard_error{};  // nothing where PredictedError is not known
};

/// Not synchronised: one writer at a time, and no reader beside it.
class Film {
 public:
  /// Makes a film of zero sums and counts. throws InternalError unless the crop is inside the image
  /// and not empty, the number of replicates is a power of two, and the channels begin with R, G, B
  explicit Film(FilmLayout layout);

  [[nodiscard]] const FilmLayout& layout() const { return layout_; }
  /// The index of a channel ("albedo.R"), or nothing when the film does not have it.
  [[nodiscard]] std::optional<std::uint32_t> channel_index(std::string_view name) const;

  /// Adds a unit's sums and counts; sample i belongs to replicate i mod replicates.
  /// throws InternalError for a pixel outside the crop, arrays of the wrong size, or more rejected
  /// samples than samples; InputError when a pixel leaves the film's range (mean radiance times
  /// number of samples reaches 2^63). The film is then unusable.
  void add(const UnitSums& unit);
  /// Adds to the light paths that were traced for a window. throws InternalError unless there is a
  /// count for each replicate
  void add_light_paths(const LightPathCount& count);
  /// The light paths of all windows, in the order of the windows.
  [[nodiscard]] std::span<const LightPathCount> light_paths() const { return light_paths_; }
  /// Adds another film of the same image size, replicates, channels and mattes, whose crop lies
  /// inside this one's. The caller must know that their samples are disjoint. throws as above
  void add(const Film& other);

  /// The part of the film in rows y0 to y1 - 1 of its crop.
  [[nodiscard]] Film rows(std::uint32_t y0, std::uint32_t y1) const;

  /// Exact sum and count; x and y are coordinates of the full image, inside the crop.
  [[nodiscard]] int128 sum(std::uint32_t x, std::uint32_t y, std::uint32_t replicate, std::uint32_t channel) const;
  [[nodiscard]] std::uint64_t count(std::uint32_t x, std::uint32_t y, std::uint32_t replicate) const;

  /// Replace a sum and a count, for reading checkpoints and parts. throws InputError beyond the
  /// film's range
  void set(std::uint32_t x, std::uint32_t y, std::uint32_t replicate, std::uint32_t channel, int128 sum);
  void set_count(std::uint32_t x, std::uint32_t y, std::uint32_t replicate, std::uint64_t count);

  /// All sums of a row of the crop, [((x - crop.x0) * replicates + replicate) * channels +
  /// channel], and all its counts, [(x - crop.x0) * replicates + replicate]. Valid until the film
  /// changes.
  [[nodiscard]] std::span<const int128> row_sums(std::uint32_t y) const;
  [[nodiscard]] std::span<const std::uint64_t> row_counts(std::uint32_t y) const;
  /// Adds such arrays to the pixels from x on. throws InternalError unless they are whole pixels of
  /// the row; InputError beyond the film's range. The film is then unusable.
  void add_row(std::uint32_t x, std::uint32_t y, std::span<const int128> sums, std::span<const std::uint64_t> counts);

  /// Adds samples of a pixel to a matte (an index into FilmLayout::mattes).
  /// throws InputError beyond 2^64 samples
  void add_to_matte(std::size_t matte, std::uint32_t x, std::uint32_t y, const MatteCount& count);
  /// The ids that the samples of a pixel hit, with their counts. Rejected samples count too, so the
  /// counts add up to the number of samples drawn.
  [[nodiscard]] std::vector<MatteCount> matte(std::size_t matte, std::uint32_t x, std::uint32_t y) const;

  /// The exact sum over replicates.
  [[nodiscard]] int128 total(std::uint32_t x, std::uint32_t y, std::uint32_t channel) const;
  /// The exact sum over replicates and several channels. throws InputError beyond the film's range
  [[nodiscard]] int128 total(std::uint32_t x, std::uint32_t y, std::span<const std::uint32_t> channels) const;
  /// The mean over all samples, correctly rounded to double from the exact sum; 0 without samples.
  /// The mean of the pixel's splats over the light paths that were traced for it, rounded likewise,
  /// is added.
  [[nodiscard]] double mean(std::uint32_t x, std::uint32_t y, std::uint32_t channel) const;
  /// The mean of the sum of several channels.
  [[nodiscard]] double mean(std::uint32_t x, std::uint32_t y, std::span<const std::uint32_t> channels) const;
  /// Estimates the variance of mean() as sum_r (n_r / N) (m_r - m)^2 / (R - 1). Each of the R
  /// replicates has n_r samples and mean m_r; all together have N samples and mean m. Replicates
  /// are independent and m_r is unbiased, so for equal n_r the expectation is the variance of m,
  /// however the samples within a replicate depend on each other. For unequal n_r this holds when
  /// the variance of m_r goes as 1 / n_r. Where low discrepancy makes it fall faster, the estimate
  /// is slightly too large or too small, by a factor that is 1 for equal counts (the renderer's
  /// counts differ by at most one). The result is NaN when the variance is unknown: for R = 1, or a
  /// replicate without samples.
  [[nodiscard]] double variance_of_mean(std::uint32_t x, std::uint32_t y, std::uint32_t channel) const;
  /// Computes mean() and variance_of_mean() for all pixels of a row of the crop.
  void row_means_and_variances(std::uint32_t y, std::uint32_t channel, double* means, double* variances) const;
  /// Computes mean(), rounded to float, for all pixels of a row of the crop.
  void row_means(std::uint32_t y, std::uint32_t channel, float* means) const;
  /// The number of samples over all replicates.
  [[nodiscard]] std::uint64_t samples(std::uint32_t x, std::uint32_t y) const;
  /// Samples of a pixel, the mean over the crop.
  [[nodiscard]] double mean_samples() const;

  /// Predicts the relMSE (eps 1e-2) over R, G, B and all pixels that `compare` would find against
  /// the true image; film_error.cpp states the assumptions. It takes about 0.5 us per pixel, so it
  /// is for reports and not for every unit.
  [[nodiscard]] PredictedError predicted_error() const;
  /// Averages R, G and B over all pixels. Pixels are independent, so the variances of their means
  /// add up.
  [[nodiscard]] MeanRadiance mean_radiance() const;

 private:
  FilmLayout layout_;
  std::vector<int128> sums_;           // [(pixel * replicates + replicate) * channels + channel]
  std::vector<std::uint64_t> counts_;  // [pixel * replicates + replicate]
  std::vector<MatteCounts> mattes_;
  std::vector<LightPathCount> light_paths_;  // of different windows
  std::size_t camera_channels_ = 0;          // the first ones; behind them are those of splats
  std::vector<std::optional<std::uint32_t>> splats_of_;  // channel of the splats of each channel
  int128 limit_ = 0;  // bound of a replicate's sum, so that the total over replicates always fits

  struct MeanAndVariance {
    double mean, variance;
  };
  [[nodiscard]] MeanAndVariance mean_and_variance(std::size_t pixel, std::uint32_t channel) const;
  /// The samples of each replicate of each pixel of a row from pixel `first` on, if all have as
  /// many.
  [[nodiscard]] std::optional<std::uint64_t> count_of_row(std::size_t first) const;
  void add_pixels(const UnitSums& unit, std::span<const std::uint64_t> drawn, std::size_t begin, std::size_t end);
  void add_sums(const UnitSums& unit, std::size_t first, std::span<const std::size_t> film_pixels);
  void add_mattes(const UnitSums& unit);
  void add_matte_band(const UnitSums& unit, std::size_t matte, std::span<const std::uint32_t> band);
  void add_splats(const UnitSums& unit);
  [[nodiscard]] std::uint64_t light_paths_at(std::size_t pixel, std::size_t replicate) const;
  void add_rows(const Film& other, std::uint32_t y0, std::uint32_t y1);
  [[nodiscard]] std::size_t pixel_index(std::uint32_t x, std::uint32_t y) const;
  void add_to_sum(std::size_t index, int128 value);
  [[noreturn]] void refuse_sum(std::size_t index) const;
};

}  // namespace eikon
