// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <vector>

#include "shared/records.h"

namespace eikon {

/// How light sampling chooses among lights: kernels/lights/light.h, alias_table_sample.
struct LightTable {
  std::vector<AliasEntry> buckets;  // one per light; empty if no light has power
  /// Of choosing each light: the number of 32-bit words that choose it, divided by 2^32, so exactly what the table
  /// does. 0 if and only if the light has no power.
  std::vector<double> probability;
};

/// Table that chooses lights by power, but each light that has any at least 2^-8 / n of the time: where the strong
/// lights are hidden, a weak one must not come as a firefly. powers   any finite unit, >= 0; they may differ by any
/// factor throws   InternalError for a negative or non-finite power or more than 2^28 lights source   [Walker 1974;
/// Vose 1991], in integers, so that no light is chosen or lost by rounding
LightTable build_light_table(std::span<const double> powers);

}  // namespace eikon
