// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "job/log.h"

namespace eikon {

/// Measures what the words that follow `eikon meter` ask for. Returns the JSON that --json writes,
/// or nothing if `stop` was set before the end. throws Error
[[nodiscard]] std::optional<std::string> meter_json(std::vector<std::string> words, const Log& log,
                                                    const std::atomic<bool>& stop);

}  // namespace eikon
