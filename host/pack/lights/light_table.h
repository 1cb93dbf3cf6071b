// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <vector>

#include "shared/records.h"

namespace eikon {

/// An alias table, by which light sampling chooses among lights (alias_table_sample in
/// kernels/lights/alias_table.h).
struct LightTable {
  std::vector<AliasEntry> buckets;  // one per light; empty if no light has power
  /// The exact probability of each light: the number of 32-bit words that choose it, divided by
  /// 2^32. It is 0 if and only if the light has no power.
  std::vector<double> probability;
};

/// Builds a table that chooses lights by power, but each light that has any with probability 2^-8 /
/// n at least. Otherwise a weak light would be a firefly where the strong ones are hidden.
/// powers  in any unit, >= 0 and finite; they may differ by any factor
/// throws  InternalError for a negative or non-finite power, or more than 2^28 lights
/// source  [Walker 1974; Vose 1991], in integers, so that no light is chosen or lost by rounding
LightTable build_light_table(std::span<const double> powers);

}  // namespace eikon
