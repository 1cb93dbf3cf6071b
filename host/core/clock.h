// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace eikon {

/// Monotonic seconds since the first call in this process.
[[nodiscard]] double host_seconds();

}  // namespace eikon
