// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "core/trace.h"
#include "io/json_text.h"

namespace eikon {

/// Writes --profile as Chrome trace events, for Perfetto or chrome://tracing. Times are
/// microseconds since the command began to measure.
///   "M"  names a track, or notes that detail was left out
///   "X"  is a span. The spans of a track nest and follow each other. One that stands for several
///        has the name of the longest kind, and args {"spans": how many, "busy_ms": their sum,
///        "ms": {name: milliseconds}}
///   "C"  is a counter, with args {"value"}: rates and live paths are means until the next event of
///        that name, and the last value is 0
/// throws InputError
void write_trace(const std::filesystem::path& path, const Trace& trace);
/// The same events as an array.
[[nodiscard]] Json trace_events(const Trace& trace);

}  // namespace eikon
