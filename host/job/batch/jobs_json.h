// SPDX-License-Identifier: Apache-2.0
// The jobs of a batch as JSON lines, for programs that share them between machines. Nothing is
// rendered.
#pragma once
#include <string>
#include <vector>

#include "job/batch/batch_job.h"

namespace eikon {

/// One line per job:
///
///   {"eikon": "0.1.0", "line": n, "job": "render ..", "error": ".." | null, "key": "16 hex digits"
///   | null,
///    "scene": "..", "size": [w, h] | null, "samples": [begin, end], "crop": [x0, y0, x1, y1] |
///    null, "open_ended": true | false, "output": "..", "results": [".."], "words": [".."], "part":
///    [".."]}
///
/// Names and words have "\u0000ff" for a byte FF that is not UTF-8 (name_to_utf8()). Each frame of
/// a line with `--frames` has a line of its own. `key` is that of the ledger (job_key.h); it is
/// null, with an error, if a file cannot be read. `size` is null where the scene's camera decides
/// it. `open_ended` is true where --time or --target-error ends the render. `part` has the words
/// that `--samples` and `-o`, when they are added, turn into a render of some of the samples. A
/// line that does not parse has the fields up to `key`.
[[nodiscard]] std::string to_json_lines(const std::vector<BatchJob>& jobs);

}  // namespace eikon
