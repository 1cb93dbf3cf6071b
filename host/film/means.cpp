// SPDX-License-Identifier: Apache-2.0
// Means of sums and their spread: where the film's integers become floating point.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "film/film.h"

namespace eikon {
namespace {

__extension__ typedef unsigned __int128 uint128;

constexpr int kFractionBits = 64;

/// The mean of splats over light paths; exact but for the rounding of to_mean.
double mean_of_splats(int128 sum, std::uint64_t paths) { return std::ldexp(to_mean(sum, paths), kSplatShift); }

/// The number as a double, correctly rounded. The compiler's own conversion counts bits, and takes
/// several times as long.
double rounded(int128 fixed) {
  constexpr std::int64_t kMaxHigh = 1 << 21;  // for 53 bits above the low 32
  const auto high = static_cast<std::int64_t>(fixed >> 64);
  if (high < -kMaxHigh || high >= kMaxHigh) return static_cast<double>(fixed);
  // Both parts are exact, and only their sum is rounded.
  return static_cast<double>(static_cast<std::int64_t>(fixed >> 32)) * 0x1p32 +
         static_cast<double>(static_cast<std::uint32_t>(fixed));
}

/// Returns 2^exponent, for exponents of normal numbers.
double power_of_two(int exponent) { return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52); }

/// Divides sums by a count: to_mean() of many.
class Quotient {
 public:
  explicit Quotient(std::uint64_t count)
      : count_(count),
        scale_(std::has_single_bit(count) ? power_of_two(-kFractionBits - std::countr_zero(count)) : 0) {}
  [[nodiscard]] double operator()(int128 sum) const {
    return scale_ != 0 ? rounded(sum) * scale_ : to_mean(sum, count_);
  }

 private:
  std::uint64_t count_;
  double scale_;  // 0: the count is no power of two
};

}  // namespace

double to_double(int128 fixed) {
  // The conversion rounds to nearest even, and scaling is exact: the result is 0 or at least 2^-64.
  return rounded(fixed) * power_of_two(-kFractionBits);
}

double to_mean(int128 fixed, std::uint64_t count) {
  if (count == 0 || fixed == 0) return 0;
  if ((count & (count - 1)) == 0) return rounded(fixed) * power_of_two(-kFractionBits - std::countr_zero(count));
  const uint128 magnitude = fixed < 0 ? ~static_cast<uint128>(fixed) + 1 : static_cast<uint128>(fixed);
  const auto high = static_cast<std::uint64_t>(magnitude >> 64);
  const int shift = high != 0 ? std::countl_zero(high) : 64 + std::countl_zero(static_cast<std::uint64_t>(magnitude));
  // The dividend has its top bit set and the divisor at most 64 bits, so the quotient has at least
  // 64 bits: more than the 53 of the result and the rounding bit. A remainder of the division sets
  // the last bit, which then breaks ties the right way.
  const uint128 dividend = magnitude << shift;
  const uint128 quotient = dividend / count;
  const uint128 sticky = quotient * count != dividend ? 1 : 0;
  const double mean = std::ldexp(static_cast<double>(quotient | sticky), -kFractionBits - shift);
  return fixed < 0 ? -mean : mean;
}

double Film::mean(std::uint32_t x, std::uint32_t y, std::uint32_t channel) const {
  return mean(x, y, std::span(&channel, 1));
}

double Film::mean(std::uint32_t x, std::uint32_t y, std::span<const std::uint32_t> channels) const {
  const double by_samples = to_mean(total(x, y, channels), samples(x, y));
  std::vector<std::uint32_t> splats;
  for (const std::uint32_t channel : channels)
    if (const auto of = splats_of_[channel]) splats.push_back(*of);
  if (splats.empty()) return by_samples;
  std::uint64_t paths = 0;
  for (std::uint32_t r = 0; r < layout_.replicates; ++r) paths += light_paths_at(pixel_index(x, y), r);
  return by_samples + mean_of_splats(total(x, y, splats), paths);
}

double Film::variance_of_mean(std::uint32_t x, std::uint32_t y, std::uint32_t channel) const {
  return mean_and_variance(pixel_index(x, y), channel).variance;
}

Film::MeanAndVariance Film::mean_and_variance(std::size_t pixel, std::uint32_t channel) const {
  const std::size_t replicates = layout_.replicates, channels = layout_.channels.size();
  const std::uint64_t* const counts = &counts_[pixel * replicates];
  const int128* const sums = &sums_[pixel * replicates * channels + channel];
  const int128* const splats = splats_of_[channel] ? sums + (*splats_of_[channel] - channel) : nullptr;
  std::uint64_t all = 0, all_paths = 0;
  int128 total = 0, total_splats = 0;
  for (std::size_t r = 0; r < replicates; ++r) {
    all += counts[r], total += sums[r * channels];
    if (splats != nullptr) all_paths += light_paths_at(pixel, r), total_splats += splats[r * channels];
  }
  MeanAndVariance found{.mean = to_mean(total, all) + mean_of_splats(total_splats, all_paths),
                        .variance = std::numeric_limits<double>::quiet_NaN()};
  if (replicates < 2) return found;
  double spread = 0;
  for (std::size_t r = 0; r < replicates; ++r) {
    if (counts[r] == 0 || (all_paths > 0 && light_paths_at(pixel, r) == 0)) return found;
    double mean = to_mean(sums[r * channels], counts[r]);
    if (splats != nullptr) mean += mean_of_splats(splats[r * channels], light_paths_at(pixel, r));
    const double difference = mean - found.mean;
    spread += static_cast<double>(counts[r]) / static_cast<double>(all) * difference * difference;
  }
  found.variance = spread / static_cast<double>(replicates - 1);
  return found;
}

std::optional<std::uint64_t> Film::count_of_row(std::size_t first) const {
  const auto begin = counts_.begin() + std::ptrdiff_t(first * layout_.replicates);
  const auto end = begin + std::ptrdiff_t(std::size_t{layout_.crop.width()} * layout_.replicates);
  const bool alike = std::all_of(begin, end, [&](std::uint64_t count) { return count == *begin; });
  return alike ? std::optional(*begin) : std::nullopt;
}

void Film::row_means_and_variances(std::uint32_t y, std::uint32_t channel, double* means, double* variances) const {
  const std::size_t first = pixel_index(layout_.crop.x0, y), width = layout_.crop.width();
  const std::size_t replicates = layout_.replicates, channels = layout_.channels.size();
  const std::optional<std::uint64_t> count = count_of_row(first);
  if (splats_of_[channel] || replicates < 2 || count.value_or(0) == 0) {
    for (std::size_t i = 0; i < width; ++i) {
      const MeanAndVariance found = mean_and_variance(first + i, channel);
      means[i] = found.mean, variances[i] = found.variance;
    }
    return;
  }
  // As mean_and_variance(), with what all pixels have in common taken out.
  const Quotient of_one(*count), of_all(*count * replicates);
  const double weight = static_cast<double>(*count) / static_cast<double>(*count * replicates);
  const int128* sums = &sums_[first * replicates * channels + channel];
  for (std::size_t i = 0; i < width; ++i, sums += replicates * channels) {
    int128 total = 0;
    for (std::size_t r = 0; r < replicates; ++r) total += sums[r * channels];
    const double mean = of_all(total);
    double spread = 0;
    for (std::size_t r = 0; r < replicates; ++r) {
      const double difference = of_one(sums[r * channels]) - mean;
      spread += weight * difference * difference;
    }
    means[i] = mean, variances[i] = spread / static_cast<double>(replicates - 1);
  }
}

void Film::row_means(std::uint32_t y, std::uint32_t channel, float* means) const {
  const std::size_t first = pixel_index(layout_.crop.x0, y), width = layout_.crop.width();
  const std::size_t replicates = layout_.replicates, channels = layout_.channels.size();
  const std::optional<std::uint64_t> count = count_of_row(first);
  if (splats_of_[channel] || !count) {
    for (std::size_t i = 0; i < width; ++i)
      means[i] = static_cast<float>(mean(layout_.crop.x0 + static_cast<std::uint32_t>(i), y, channel));
    return;
  }
  const Quotient of_all(*count * replicates);
  const int128* sums = &sums_[first * replicates * channels + channel];
  for (std::size_t i = 0; i < width; ++i, sums += replicates * channels) {
    int128 total = 0;
    for (std::size_t r = 0; r < replicates; ++r) total += sums[r * channels];
    means[i] = static_cast<float>(of_all(total));
  }
}

MeanRadiance Film::mean_radiance() const {
  const Crop& crop = layout_.crop;
  // Sums of each row, which are added in their order, so the number of threads changes no bit.
  struct RowSums {
    std::array<double, 3> mean{}, variance{};
  };
  std::vector<RowSums> rows(crop.height());
  tbb::parallel_for(crop.y0, crop.y1, [&](std::uint32_t y) {
    std::vector<double> means(crop.width()), variances(crop.width());
    RowSums& row = rows[y - crop.y0];
    for (std::uint32_t channel = 0; channel < 3; ++channel) {
      row_means_and_variances(y, channel, means.data(), variances.data());
      row.mean[channel] = std::accumulate(means.begin(), means.end(), 0.0);
      row.variance[channel] = std::accumulate(variances.begin(), variances.end(), 0.0);
    }
  });
  RowSums all;
  for (const RowSums& row : rows)
    for (std::size_t channel = 0; channel < 3; ++channel) {
      all.mean[channel] += row.mean[channel];
      all.variance[channel] += row.variance[channel];
    }
  const auto pixels = static_cast<double>(crop.pixel_count());
  MeanRadiance result;
  for (std::size_t channel = 0; channel < 3; ++channel) result.value[channel] = all.mean[channel] / pixels;
  if (std::ranges::any_of(all.variance, [](double value) { return std::isnan(value); })) return result;
  std::array<double, 3>& error = result.standard_error.emplace();
  for (std::size_t channel = 0; channel < 3; ++channel) error[channel] = std::sqrt(all.variance[channel]) / pixels;
  return result;
}

}  // namespace eikon
