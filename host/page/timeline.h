// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "io/json_text.h"

namespace eikon {

/// Trace events, as --profile writes them (job/report/trace_file.h), as a page draws them: spans
/// that would be narrower than a pixel are joined, and counters are thinned.
///   "end_s"     seconds from the first event to the last
///   "names"     of spans
///   "tracks"    [{"name", "rows": [[[begin_s, end_s, index into names], ...] for each depth of
///               nesting]}]
///   "counters"  {name: [[seconds, value], ...]}
/// Seconds count from the first event.
/// throws InputError if they are not such events
[[nodiscard]] Json page_timeline(const Json& trace_events);

}  // namespace eikon
