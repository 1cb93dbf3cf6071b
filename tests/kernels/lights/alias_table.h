// SPDX-License-Identifier: Apache-2.0
// The choice of an alias table by its definition.
#pragma once
#include "kernels/probe.h"
#include "pack/lights/light_table.h"
#include "support/random.h"

namespace eikon::test {

/// The entry that an alias table gives for the word a.
inline std::uint32_t choose(const LightTable& table, std::uint32_t a) {
  const std::uint64_t product = std::uint64_t{a} * table.buckets.size();
  const auto bucket = std::uint32_t(product >> 32);
  return std::uint32_t(product) < table.buckets[bucket].threshold ? bucket : table.buckets[bucket].alias;
}

}  // namespace eikon::test
