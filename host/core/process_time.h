// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace eikon {

/// Seconds since the system started this process, before any of its code ran: linking the libraries counts. In steps of a
/// clock tick (10 ms).
/// throws InternalError where /proc is missing
[[nodiscard]] double process_seconds();

}  // namespace eikon
