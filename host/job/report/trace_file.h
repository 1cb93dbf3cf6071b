// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "core/trace.h"

namespace eikon {

/// --profile: Chrome trace events, for Perfetto or chrome://tracing; times in microseconds since the command began to measure.
///   "M"  names of tracks; a note where detail was left out
///   "X"  spans: of one track they nest and follow each other. One that stands for several has args {"spans": how many,
///        "busy_ms": without what lies between them, "ms": {name: milliseconds}} and the name of what took most
///   "C"  counters, args {"value"}: rates and live paths are means until the next event of that name, the last one is 0
/// throws InputError
void write_trace(const std::filesystem::path& path, const Trace& trace);

}  // namespace eikon
