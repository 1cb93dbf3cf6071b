// SPDX-License-Identifier: Apache-2.0
// The flags of a render: of `eikon render`, and of each line of a batch.
#pragma once
#include <string>
#include <vector>

#include "cli/command_flags.h"
#include "job/render_options.h"

namespace eikon {

// `options` and `png` must live as long as the parser.
void add_render_flags(CommandFlags& flags, RenderOptions& options);
/// Adds --png, --exposure, --ev100 and --tonemap.
void add_png_flags(CommandFlags& flags, PngOptions& png);

/// Reads the words that follow `eikon render` on a command line. throws UsageError
[[nodiscard]] RenderOptions parse_render(std::vector<std::string> words);

}  // namespace eikon
