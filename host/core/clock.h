// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace eikon {

/// Monotonic seconds since the first call in this process.
[[nodiscard]] double host_seconds();

/// Seconds since the system started this process, in steps of a clock tick (10 ms). The time to
/// link its libraries counts. throws InternalError when /proc is missing
[[nodiscard]] double process_seconds();

}  // namespace eikon
