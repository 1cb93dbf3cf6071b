// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/light_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/error.h"

namespace eikon {
namespace {

using u64 = std::uint64_t;
constexpr u64 kFull = u64{1} << 32;  // weight of a bucket

// The shares of the lights. Their sum is exactly one full bucket per light.
std::vector<u64> shares_of(std::span<const double> powers) {
  const u64 count = powers.size();
  const double largest = *std::max_element(powers.begin(), powers.end());
  double sum = 0;
  for (const double power : powers) sum += power / largest;
  // The smallest share is 2^-8 / count, and never so small that a light would have less than a few
  // of the 2^32 words.
  const double least = std::max(0x1p-8 / double(count), 0x1p-30);
  std::vector<double> weights(count, 0.0);
  double total = 0;
  for (u64 i = 0; i < count; ++i) {
    if (powers[i] > 0) weights[i] = std::max(powers[i] / largest / sum, least);
    total += weights[i];
  }
  std::vector<u64> shares(count);
  u64 given = 0;
  for (u64 i = 0; i < count; ++i) {
    shares[i] = u64(weights[i] / total * double(count) * double(kFull));
    given += shares[i];
  }
  // Rounding leaves over, or overspends, a part in 2^32 at most. The strongest light takes it, as
  // it has a full bucket at least.
  u64& strongest = *std::max_element(shares.begin(), shares.end());
  strongest += count * kFull - given;
  return shares;
}

// The number of 32-bit words a for which the high word of a * count is `bucket`, and the low word
// is in [begin, end).
u64 words_between(u64 bucket, u64 begin, u64 end, u64 count) {
  const auto words_below = [&](u64 rest) {  // a * count < bucket * 2^32 + rest
    const unsigned __int128 bound = (static_cast<unsigned __int128>(bucket) << 32) + rest;
    return u64((bound + count - 1) / count);
  };
  return words_below(end) - words_below(begin);
}

}  // namespace

LightTable build_light_table(std::span<const double> powers) {
  const u64 count = powers.size();
  if (count > (u64{1} << 28)) throw InternalError(fmt::format("a light table of {} lights: at most 2^28", count));
  for (u64 i = 0; i < count; ++i)
    if (!(powers[i] >= 0) || !std::isfinite(powers[i]))
      throw InternalError(fmt::format("light {} has power {}: must be finite and not negative", i, powers[i]));
  LightTable table;
  table.probability.assign(count, 0.0);
  if (std::none_of(powers.begin(), powers.end(), [](double power) { return power > 0; })) return table;

  std::vector<u64> shares = shares_of(powers);
  table.buckets.resize(count);
  std::vector<std::uint32_t> small, large;
  for (u64 i = 0; i < count; ++i) (shares[i] < kFull ? small : large).push_back(std::uint32_t(i));

  std::vector<u64> words(count, 0);
  const auto fill = [&](std::uint32_t bucket, u64 threshold, std::uint32_t alias) {
    // The threshold of a full bucket does not fit 32 bits. The one word beyond it goes to the
    // alias, which is the bucket itself.
    const auto stored = std::uint32_t(std::min(threshold, kFull - 1));
    table.buckets[bucket] = {.threshold = stored, .alias = alias};
    words[bucket] += words_between(bucket, 0, threshold, count);
    words[alias] += words_between(bucket, threshold, kFull, count);
  };
  // A light with less than a bucket shares it with a light that has more than one. Sums are exact,
  // so both lists end at the same time, and the buckets that are left are full.
  while (!small.empty()) {
    const std::uint32_t bucket = small.back();
    const std::uint32_t donor = large.back();
    small.pop_back();
    fill(bucket, shares[bucket], donor);
    shares[donor] -= kFull - shares[bucket];
    if (shares[donor] < kFull) {
      large.pop_back();
      small.push_back(donor);
    }
  }
  for (const std::uint32_t bucket : large) fill(bucket, kFull, bucket);
  for (u64 i = 0; i < count; ++i) table.probability[i] = double(words[i]) * 0x1p-32;
  return table;
}

}  // namespace eikon
