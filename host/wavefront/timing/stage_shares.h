// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <span>
#include <string>

#include "shared/records.h"

namespace eikon {

/// The share of each stage in a launch of kernel `paths`: the stage's ticks over the ticks of all
/// work-items from the first begin to the last end. So the shares, and the time that work-items
/// spent waiting and taking chunks, add up to 1. Empty if the processor has no counter.
std::map<std::string, double> stage_shares(std::span<const WorkerTally> tallies);

}  // namespace eikon
