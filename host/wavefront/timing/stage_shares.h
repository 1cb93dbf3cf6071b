// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <span>
#include <string>

#include "shared/records.h"

namespace eikon {

/// The share of a launch of kernel `paths` that each stage took, from its work-items' ticks: a stage's ticks over those of all
/// work-items from the first one's begin to the last one's end, so that the shares and what the work-items spent otherwise
/// (waiting for the last, taking chunks) add to 1. Empty where there is no counter.
std::map<std::string, double> stage_shares(std::span<const WorkerTally> tallies);

}  // namespace eikon
