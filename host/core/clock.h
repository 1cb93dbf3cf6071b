// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace eikon {

/// Monotonic seconds since the process first asked.
[[nodiscard]] double host_seconds();

}  // namespace eikon
